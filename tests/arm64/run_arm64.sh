#!/bin/bash
# 64-bit Arm on any machine: cross-compiles all programs and runs tests of them under user-mode emulation, the kernels'
# NEON registers among them.
#
#   tests/arm64/run_arm64.sh "PACKAGE.." [FILTER..]    PACKAGE: of the libraries that the build needs ('./run arm64' knows them);
#                                                      FILTER: Catch2's arguments; without: a subset, see README.md
#
# The programs are build/arm64/hdrcam and build/arm64/tests/hdrcam_tests; run them with qemu-aarch64 -L build/arm64/root.
# Tests that start the program are out of reach: the emulator does not emulate what its program starts.
# exit: 0 passed, 1 failed, 2 could not set up.
# needs: apt with Debian 12's lists, clang, binutils-aarch64-linux-gnu, qemu-user, cmake, ninja, glslang-tools. Arm's packages
# are unpacked under ARM64_CACHE (build/arm64), never installed; the first run fetches 150 MB.
set -euo pipefail
export LC_ALL=C
here=$(cd "$(dirname "$0")" && pwd)
source_folder=$(cd "$here/../.." && pwd)
[ $# -ge 1 ] || { sed -n '2,15s/^# \{0,1\}//p' "$0"; exit 2; }
read -ra packages <<<"$1"
shift
cache=${ARM64_CACHE:-$source_folder/build/arm64}
root=$cache/root
setup_failed() { echo "arm64: $*" >&2; exit 2; }
# shellcheck source=tests/unpacked_packages.sh
. "$here/../unpacked_packages.sh"

fetch() {
  : >"$cache/no-packages"
  packages_in "$cache" -o APT::Architecture=arm64 -o APT::Architectures=arm64
  download_closure "$cache/packages" "$cache/no-packages" libstdc++-12-dev "${packages[@]}"
  rm -rf "$root"
  unpack "$cache/packages" "$root"
  # Links from / are links from the unpacked root.
  local link
  find "$root/lib" "$root/usr/lib" -type l -lname '/*' | while read -r link; do
    ln -snf --relative "$root$(readlink "$link")" "$link"
  done
  touch "$cache/fetched"
}

mkdir -p "$cache"
[ -e "$cache/fetched" ] || fetch
launcher=()
! command -v ccache >/dev/null || launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
cmake -G Ninja -S "$source_folder" -B "$cache" -DCMAKE_BUILD_TYPE=Release -DHDRCAM_ARM64_ROOT="$root" \
  -DCMAKE_TOOLCHAIN_FILE="$here/toolchain.cmake" "${launcher[@]}" >"$cache/configure.log" 2>&1 ||
  { cat "$cache/configure.log" >&2; setup_failed "cmake did not configure"; }
cmake --build "$cache" --parallel "${JOBS:-$(nproc)}" --target hdrcam hdrcam_tests -- ${CI:+--quiet} >&2 ||
  setup_failed "the build failed"

# Kernels, schedule, poses. -#: a file's name is a tag of its tests.
[ $# -gt 0 ] || set -- -# "[isa],[#exposure_schedule_test],[pose]"
# No Vulkan driver of this machine is one of that processor.
export VK_DRIVER_FILES=/dev/null VK_ICD_FILENAMES=/dev/null
algebra=/usr/lib/aarch64-linux-gnu/blas:/usr/lib/aarch64-linux-gnu/lapack
emulated=(qemu-aarch64 -L "$root" -E LD_LIBRARY_PATH="$algebra" "$cache/tests/hdrcam_tests")
if listed=$("${emulated[@]}" --list-test-names-only "$@") && [ -z "$listed" ]; then
  echo "arm64: no test is selected by: $*" >&2
  exit 1
fi
exec "${emulated[@]}" "$@"
