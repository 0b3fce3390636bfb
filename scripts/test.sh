#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# All tests from a fresh clone: installs the packages that are missing; builds Release with warnings
# as errors and every public header compiled alone; runs its tests (units, seeded statistics, house
# rules, the installed package used by a project outside); then builds with clang, warnings as errors
# again, and runs the tests under AddressSanitizer and UndefinedBehaviorSanitizer, with every fourth
# row of the tables of messages. The last line is
# `N passed, N failed` (with sanitizers a part of a module's tests counts as one); the exit status is 0
# only if nothing failed.
#
# SARBLOCK_DRAWS  seeded draws of each statistical test. Here 6: every path runs, in minutes. The
#                 full form is SARBLOCK_DRAWS=200 (docs/validation.md).
set -euo pipefail
# shellcheck source=scripts/lib.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/lib.sh"

# One BLAS thread a test: as many tests run at a time as there are cores, and one more that waits for
# processes it started.
export OPENBLAS_NUM_THREADS=1
jobs=$(($(nproc) + 1))
passed=0
failed=0
skipped=0
failures=()  # "PRESET: TEST", repeated at the end of the log

# Value of an attribute of the first element <testsuite> of a JUnit file.
suite_count() {
  sed -n "/<testsuite/,/>/s/.*[[:space:]]$2=\"\([0-9]*\)\".*/\1/p" "$1" | head -n 1
}

# run_tests PRESET [CTEST-ARGUMENT...]: runs the tests of build/PRESET and adds their counts; a failed
# test does not end the script, so that the sanitizers are heard too.
run_tests() {
  local preset=$1 junit=$root/build/$1/tests.xml total bad out
  shift
  step "Test build/$preset (SARBLOCK_DRAWS=$SARBLOCK_DRAWS)"
  rm -f -- "$junit"
  (cd -- "$root" && ctest --preset "$preset" -j"$jobs" --output-junit "$junit" "$@") || true
  [[ -s $junit ]] || fail "ctest did not run in build/$preset"
  total=$(suite_count "$junit" tests)
  bad=$(suite_count "$junit" failures)
  out=$(($(suite_count "$junit" skipped) + $(suite_count "$junit" disabled)))
  passed=$((passed + total - bad - out))
  failed=$((failed + bad))
  skipped=$((skipped + out))
  local log=$root/build/$preset/Testing/Temporary/LastTestsFailed.log
  if [[ $bad -gt 0 && -s $log ]]; then
    mapfile -t -O "${#failures[@]}" failures < <(sed "s/^[0-9]*:/build\/$preset: /" "$log")
  fi
}

install_packages

build release
step "Compile every public header alone"
(cd -- "$root" && cmake --build --preset release --target all_verify_interface_header_sets)
SARBLOCK_DRAWS=${SARBLOCK_DRAWS:-6} run_tests release

build asan
# Seeded statistics are not built with sanitizers; pages and house rules need none, and the longest of
# the other tests are left out: scripts by their names, tests of C++ by a filter of Google Test.
long=$(grep '^[a-z]*/' "$root/tests/long_under_sanitizers.txt" | paste -sd '|')
filter=$(grep -v '^#\|^[a-z]*/' "$root/tests/long_under_sanitizers.txt" | sed 's/.*/*&*/' | paste -sd ':')
SARBLOCK_DRAWS=4 GTEST_FILTER="-$filter" run_tests asan --exclude-regex "$long" --label-exclude 'docs|lint'

step "Done"
printf '%s\n' "${steps[@]}" "${failures[@]/#/FAILED }"
[[ $skipped -eq 0 ]] || echo "$skipped skipped (their reason is above or in build/*/tests.xml)"
echo "$passed passed, $failed failed"
[[ $failed -eq 0 && $passed -gt 0 ]]
