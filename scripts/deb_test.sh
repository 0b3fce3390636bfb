#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes the Debian packages and proves them on a clean system: lintian, then a fresh Debian 12 made
# by debootstrap, in which apt installs sarblock with what it depends on and a block is simulated and
# adjusted, by the program and, where the build has it, by the Python package. Needs root and a network; by hand, not in CI.
#
# Usage: scripts/deb_test.sh [BUILD [ROOT]]    a complete build (build/release) and the folder of the
#                                              clean system (build/debian-root, made if it is missing)
set -euo pipefail
# shellcheck source=scripts/lib.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/lib.sh"

build=$(realpath -- "${1:-$root/build/release}")
clean=${2:-$root/build/debian-root}
[[ $(id -u) -eq 0 ]] || fail "a clean system needs root"
for tool in debootstrap dpkg-shlibdeps file chroot; do
  command -v "$tool" > /dev/null || fail "$tool is missing (packages debootstrap, dpkg-dev, file)"
done

step "Make the packages of $build"
debs=$build/deb
rm -rf -- "$debs"
(cd -- "$build" && cpack -G DEB -B "$debs" > "$build/cpack.log") || fail "see $build/cpack.log"
ls -l -- "$debs"/*.deb
python=()
[[ ! -e $build/python/sarblock ]] || python=(--python)
mpi=()
[[ ! -e $build/src/mpi/sarblock-mpi ]] || mpi=(--mpi)
python3 "$root/tests/package/check_deb.py" "$debs" "${python[@]}" "${mpi[@]}"

if command -v lintian > /dev/null; then
  step "lintian"
  lintian --tag-display-limit 0 "$debs"/*.deb || true
fi

if [[ ! -x $clean/usr/bin/apt-get ]]; then
  step "Make a clean Debian 12 in $clean"
  debootstrap --variant=minbase bookworm "$clean" http://deb.debian.org/debian
fi

step "Install sarblock there"
cp -- "$debs"/sarblock_*.deb "$clean/tmp/"
in_clean() { chroot "$clean" env DEBIAN_FRONTEND=noninteractive LC_ALL=C "$@"; }
in_clean apt-get update -q
in_clean sh -c 'apt-get install -q -y --no-install-recommends /tmp/sarblock_*.deb'
in_clean dpkg -s sarblock | grep -E '^(Version|Status|Depends)'

step "Use it there"
in_clean sarblock --version
in_clean sh -c 'rm -rf /tmp/block /tmp/result
  sarblock simulate /usr/share/sarblock/scenes/block-12-strips.toml -o /tmp/block
  sarblock check /tmp/block
  sarblock adjust /tmp/block -o /tmp/result --strict
  test -s /tmp/result/summary.json
  ! ldd /usr/bin/sarblock | grep "not found"'

if [[ ${#python[@]} -gt 0 ]]; then
  step "Install and use python3-sarblock there"
  cp -- "$debs"/python3-sarblock_*.deb "$clean/tmp/"
  in_clean sh -c 'apt-get install -q -y --no-install-recommends /tmp/python3-sarblock_*.deb'
  in_clean python3 -c '
import sarblock
block = sarblock.read_block("/tmp/block")
result = sarblock.adjust(block)
result.write("/tmp/result_python")
print(block, result, sep="\n")'
  in_clean sh -c 'for table in points passes residuals; do
    cmp /tmp/result/$table.csv /tmp/result_python/$table.csv
  done'
  in_clean apt-get purge -q -y python3-sarblock
fi

step "Remove it"
in_clean apt-get purge -q -y sarblock
in_clean sh -c '! test -e /usr/bin/sarblock && ! test -e /usr/share/sarblock'
step "Done"
