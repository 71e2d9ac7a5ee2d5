#!/usr/bin/env bash
# Puts the deliberate faults of this folder into a copy of the tree, one after the other, and fails where the named tests
# stay green. ./run mutants [NAME..] calls it; README.md says what a mutant is and how to add one.
set -euo pipefail
# Compilers end in order at ^C, and what is next would begin. The copy may then hold a fault; the next run writes it anew.
trap 'exit 130' INT
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

copy=build/mutants
tests=$copy/build/release/tests/hdrcam_tests
limit_s=300 # for one named test; whether one that takes longer would fail is not known

fail() { printf 'mutants: %s\n' "$*" >&2; exit 1; }

# field WORD FILE: what stands behind "WORD: " in a patch's header, a line each.
field() { sed -n "/^--- /q; s/^$1: //p" "$2"; }

# The tree as git sees it, uncommitted files included. Only what differs is written, so that the build stays incremental.
sync_copy() {
  local file
  mkdir -p "$copy"
  git ls-files --cached --others --exclude-standard | while read -r file; do
    [ -f "$file" ] || continue
    cmp -s "$file" "$copy/$file" && continue
    mkdir -p "$copy/$(dirname "$file")"
    cp --no-preserve=timestamps "$file" "$copy/$file"
  done
  comm -13 <(git ls-files --cached --others --exclude-standard | sort) \
    <(cd "$copy" && find . -path ./build -prune -o -type f -print | sed 's|^\./||' | sort) |
    while read -r file; do rm "$copy/$file"; done
}

build_copy() { cmake --build "$copy/build/release" --target hdrcam_tests >"$copy/build/$1.log" 2>&1; }

# A name as Catch2 takes it: a comma would separate, a bracket open a tag.
escaped() { printf '%s' "$1" | sed 's/[\\,[]/\\&/g'; }
# timeout ends the test with all that it started, by a process group of its own, which ^C does not reach: it is awaited.
run_test() {
  local running
  env --default-signal=INT,QUIT timeout "$limit_s" "$tests" --abort "$(escaped "$1")" >"$copy/build/$2.log" 2>&1 &
  running=$!
  # shellcheck disable=SC2064 # the process that runs now
  trap "kill $running; wait $running || true; exit 130" INT
  wait "$running"
}

# try NAME: prints the verdict; returns 1 unless every named test fails.
try() {
  trap 'exit 130' INT # a subshell of its own
  local name=$1 patch=tests/mutants/$1.patch verdict=caught survived='' hung='' test
  if ! patch --dry-run --force --silent -p1 -d "$copy" <"$patch" >/dev/null; then
    echo 'PATCH NO LONGER APPLIES'
    return 1
  fi
  patch --force --silent --no-backup-if-mismatch -p1 -d "$copy" <"$patch"
  if ! build_copy "$name"; then
    verdict='DOES NOT BUILD'
  else
    while read -r test; do
      if run_test "$test" "$name"; then survived=$test; elif [ $? = 124 ]; then hung=$test; fi
    done < <(field Test "$patch")
    [ -z "$hung" ] || verdict="HANGS '$hung'"
    [ -z "$survived" ] || verdict="SURVIVED '$survived'"
  fi
  patch --reverse --force --silent --no-backup-if-mismatch -p1 -d "$copy" <"$patch"
  echo "$verdict"
  [ "$verdict" = caught ]
}

names=("$@")
if [ ${#names[@]} = 0 ]; then
  for patch in tests/mutants/*.patch; do names+=("$(basename "$patch" .patch)"); done
fi
for name in "${names[@]}"; do
  [ -f "tests/mutants/$name.patch" ] || fail "there is no tests/mutants/$name.patch"
  [ -n "$(field Fault "tests/mutants/$name.patch")" ] || fail "$name.patch does not say what is wrong ('Fault: ..')"
  [ -n "$(field Test "tests/mutants/$name.patch")" ] || fail "$name.patch does not name a test ('Test: ..')"
done

export CI=true
! command -v mold >/dev/null || export LDFLAGS=-fuse-ld=mold # each mutant links two programs
sync_copy
mkdir -p "$copy/build"
echo "mutants: builds the tree without a fault and runs the named tests; log: $copy/build/unmutated.log" >&2
(cd "$copy" && ./run build hdrcam_tests) >"$copy/build/unmutated.log" 2>&1 || { cat "$copy/build/unmutated.log" >&2; fail "the tree itself does not build"; }
mapfile -t named < <(for name in "${names[@]}"; do field Test "tests/mutants/$name.patch"; done | sort -u)
filter=''
for test in "${named[@]}"; do
  # Catch2 exits with the number of tests that it lists
  [ "$("$tests" --list-test-names-only "$(escaped "$test")" || true)" = "$test" ] || fail "there is no test '$test'"
  filter+="${filter:+,}$(escaped "$test")"
done
# In one process, because tests share the clips that they film.
"$tests" "$filter" >"$copy/build/unmutated.log" 2>&1 ||
  { tail -30 "$copy/build/unmutated.log" >&2; fail "a named test fails without any fault"; }

uncaught=0
printf '%-32s%-26s %s\n' mutant verdict 'seconds'
for name in "${names[@]}"; do
  start=$SECONDS
  verdict=$(try "$name") || uncaught=$((uncaught + 1))
  printf '%-32s%-26s %d\n' "$name" "$verdict" $((SECONDS - start))
done
echo
echo "$((${#names[@]} - uncaught)) of ${#names[@]} mutants caught"
[ "$uncaught" = 0 ]
