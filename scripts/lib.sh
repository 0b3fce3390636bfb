# SPDX-License-Identifier: Apache-2.0
# Functions that demo.sh and test.sh share; sourced, not run. Sets `root`, the project's folder.
# shellcheck shell=bash

root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)
# Read by the callers.
# shellcheck disable=SC2034
readonly root

# Prints a step, so that a log reads as a list of them, each with the seconds since the start.
steps=()
step() {
  steps+=("$(printf '[%4d s] %s' "$SECONDS" "$*")")
  printf '\n== %s\n' "${steps[-1]}"
}

fail() {
  printf 'error: %s\n' "$*" >&2
  exit 1
}

# Runs a command as root: directly, or through sudo.
as_root() {
  if [[ $(id -u) -eq 0 ]]; then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    fail "packages are missing: run as root or install sudo, or install them yourself:" \
      "scripts/packages.txt"
  fi
}

# install_packages [SECTION]...: installs what is missing of these sections of scripts/packages.txt,
# of all without a name. With nothing missing it asks only dpkg and needs neither root nor network.
install_packages() {
  local wanted missing=() package
  mapfile -t wanted < <(awk -v sections="$(printf '%s|' "$@")" '
    /^# / { section = substr($0, 3) "|" }
    /^[^#]/ && (sections == "|" || index("|" sections, "|" section)) { print $1 }
  ' "$root/scripts/packages.txt")
  command -v dpkg-query >/dev/null || fail "not a Debian system: install the libraries of" \
    "docs/dependencies.md by hand, then use the presets (CONTRIBUTING.md)"
  for package in "${wanted[@]}"; do
    [[ $(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) == installed ]] ||
      missing+=("$package")
  done
  if [[ ${#missing[@]} -eq 0 ]]; then
    step "All ${#wanted[@]} packages are installed"
    return
  fi
  step "Install ${missing[*]}"
  as_root apt-get update -q
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends \
    "${missing[@]}"
}

# build PRESET [ARGUMENTS]: configures and builds build/PRESET, through ccache where there is one.
# ARGUMENTS go to cmake --build.
build() {
  local preset=$1 launcher=()
  shift
  if command -v ccache >/dev/null; then
    launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  fi
  step "Configure build/$preset"
  (cd -- "$root" && cmake --preset "$preset" "${launcher[@]}" --log-level=NOTICE)
  step "Build build/$preset"
  (cd -- "$root" && cmake --build --preset "$preset" "$@")
}
