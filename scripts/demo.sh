#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# From a fresh clone to an adjusted block: installs the packages that are missing, builds, simulates
# the shipped block of 12 parallel strips and two tie strips, checks it, adjusts it, and prints the
# summary. A second call builds nothing and takes seconds. Results: build/demo.
#
# Usage: scripts/demo.sh [SCENE]     a file of datasets/scenes without .toml (block-12-strips)
set -euo pipefail
# shellcheck source=scripts/lib.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/lib.sh"

scene=${1:-block-12-strips}
[[ -f $root/datasets/scenes/$scene.toml ]] || fail "no scene '$scene'; there are:" \
  "$(cd -- "$root/datasets/scenes" && printf '%s ' *.toml)"

# The preset configures the last three as well.
install_packages tools libraries "building the Python module" "building sarblock-mpi" "building the tests"
build release --target sarblock

sarblock=$root/build/release/src/cli/sarblock
demo=$root/build/demo
mkdir -p "$demo"
rm -rf -- "$demo/block" "$demo/result"

step "sarblock simulate datasets/scenes/$scene.toml -o build/demo/block"
"$sarblock" simulate "$root/datasets/scenes/$scene.toml" -o "$demo/block"
step "sarblock check build/demo/block"
"$sarblock" check "$demo/block"
step "sarblock adjust build/demo/block -o build/demo/result"
"$sarblock" adjust "$demo/block" -o "$demo/result"

step "Done. The program is build/release/src/cli/sarblock; the result, build/demo/result:"
ls -- "$demo/result"
