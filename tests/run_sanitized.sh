#!/usr/bin/env bash
# run_sanitized.sh address|thread TESTS [FILTER..]: runs the sanitized test program with the options that it needs here.
# Ends at the first finding. ./run sanitize calls it.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
kind=$1 tests=$2
shift 2

# No Vulkan driver is loaded: Mesa's leak when they are unloaded, and their threads have locks that cannot be seen.
export VK_DRIVER_FILES=/dev/null VK_ICD_FILENAMES=/dev/null
# Clang 14 puts registers of 32 and 64 bytes at places of 16 when it instruments frames: kernels of the baseline.
if [ "$kind" = address ]; then export HDRCAM_ISA=baseline; fi
# Programs started by tests inherit these.
export ASAN_OPTIONS=strict_string_checks=1:detect_stack_use_after_return=1
export LSAN_OPTIONS="suppressions=$here/leak_sanitizer.supp print_suppressions=0"
export UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS="halt_on_error=1 second_deadlock_stack=1 suppressions=$here/thread_sanitizer.supp"

# Kernels with much address randomisation put mappings where the thread sanitizer has its shadow.
fixed_addresses=()
if [ "$kind" = thread ] && setarch -R true 2>/dev/null; then fixed_addresses=(setarch -R); fi
# Catch2 calls it a success where no test is selected; a program that cannot even list them has other words.
if [ $# -gt 0 ] && listed=$("${fixed_addresses[@]}" "$tests" --list-test-names-only "$@") && [ -z "$listed" ]; then
  echo "sanitize: no test is selected by: $*" >&2
  exit 1
fi
exec "${fixed_addresses[@]}" "$tests" "$@"
