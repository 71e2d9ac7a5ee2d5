#!/usr/bin/env bash
# Installs the build into a folder of its own, moves that folder, and uses what is there as a stranger would: compiles
# the example against it, loads the completions, reads the manual pages, checks the service. Called by ./run installed.
#   run_installed.sh BUILD_FOLDER
set -euo pipefail
build=$1
root=$PWD
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
ok() { printf 'ok    %s\n' "$*"; }
not_ok() { printf 'FAIL  %s\n' "$*"; failed=1; }
# quiet WHAT COMMAND..: succeeds without a word
quiet() {
  local what=$1 said
  shift
  if said=$("$@" 2>&1) && [ -z "$said" ]; then ok "$what"; else not_ok "$what: $said"; fi
}

cmake --install "$build" --prefix "$work/first" >/dev/null
mv "$work/first" "$work/usr"
PATH=$work/usr/bin:$PATH
[ "$(hdrcam --version)" = "$("$build/hdrcam" --version)" ] && ok "the installed program runs" || not_ok "hdrcam --version"

guides=$work/usr/share/doc/hdrcam
quiet "the pages that README.md links are there" \
  sh -c "cd '$guides' && ls -d \$(grep -o '](docs/[A-Za-z/-]*[.]md' README.md | cut -c3- | sort -u) >/dev/null"

# The library, by both ways to find it.
example=$work/usr/share/doc/hdrcam-dev/examples/mean_radiance
frames=$(hdrcam info "$root/tests/data/demo.mkv" | sed -n 's/^ *frames  *\([0-9]*\) in.*/\1/p')
cmake -S "$example" -B "$work/cmake" -DCMAKE_PREFIX_PATH="$work/usr" -DCMAKE_BUILD_TYPE=Release >"$work/log" 2>&1 &&
  cmake --build "$work/cmake" >>"$work/log" 2>&1 || { cat "$work/log"; not_ok "the example by its CMake package"; }
"$work/cmake/mean_radiance" "$root/tests/data/demo.mkv" >"$work/radiance" || not_ok "the example runs"
[ "$(grep -cE '^ *[0-9.]+ s  exposure +[0-9.]+  radiance [0-9.]+ [0-9.]+ [0-9.]+$' "$work/radiance")" = "$frames" ] &&
  ok "the example, by its CMake package, prints the radiance of all $frames frames" || not_ok "the example's lines"
export PKG_CONFIG_PATH=$work/usr/lib/pkgconfig
# shellcheck disable=SC2046 # the words of pkg-config are arguments
g++ -std=c++20 -O1 "$example/mean_radiance.cpp" $(pkg-config --cflags --libs hdrcam) -o "$work/by_pc" &&
  "$work/by_pc" "$root/tests/data/demo.mkv" | cmp - "$work/radiance" && ok "the same by hdrcam.pc" || not_ok "hdrcam.pc"

# Completions: the shells parse them, and offer every verb and flag that --help shows.
quiet "bash parses its completion" bash -n "$work/usr/share/bash-completion/completions/hdrcam"
quiet "zsh parses its completion" zsh -n "$work/usr/share/zsh/vendor-completions/_hdrcam"
quiet "fish parses its completion" fish --no-execute "$work/usr/share/fish/vendor_completions.d/hdrcam.fish"
verbs=$(hdrcam --help | sed -n 's/^ *\$ hdrcam \([a-z]*\).*/\1/p')
flags_in_help() {
  { hdrcam "$1" --help; [ "$1" != bench ] || for part in pareto kernels; do hdrcam bench $part --help; done; } |
    sed -n 's/^  \(-[^ =]*\).*/\1/p' | tr , '\n' | grep '^--' | sort -u
}
by_fish() { fish --no-config -c "source $work/usr/share/fish/vendor_completions.d/hdrcam.fish; complete -C 'hdrcam $1 --'" | cut -f1 | sort; }
# A zsh without a terminal completes into a pseudo terminal's text; zpty drives it.
by_zsh() {
  zsh -f "$root/tests/packaging/zsh_offers.zsh" "$work/usr/share/zsh/vendor-completions" "hdrcam $1 --" | sort
}
for verb in $verbs; do
  for shell in fish zsh; do
    cmp -s <(flags_in_help "$verb") <("by_$shell" "$verb") && ok "$shell offers all flags of $verb" ||
      not_ok "$shell, $verb: $(diff <(flags_in_help "$verb") <("by_$shell" "$verb") | tr '\n' ' ')"
  done
done

# Manual pages: both readers take them without a warning.
for page in "$work"/usr/share/man/man1/*.gz; do
  quiet "mandoc: $(basename "$page")" mandoc -T lint -W warning "$page"
  said=$(LC_ALL=C.UTF-8 MANWIDTH=80 man --warnings -E UTF-8 -l "$page" 2>&1 >/dev/null) || true
  [ -z "$said" ] && ok "man: $(basename "$page")" || not_ok "man: $(basename "$page"): $said"
done
[ "$(ls "$work"/usr/share/man/man1 | wc -l)" = $((1 + $(wc -w <<<"$verbs"))) ] && ok "a page for every verb" ||
  not_ok "a page for every verb"

# The service, with the program where it is here.
sed "s|^ExecStart=hdrcam|ExecStart=$work/usr/bin/hdrcam|" "$work/usr/lib/systemd/system/hdrcam.service" >"$work/hdrcam.service"
quiet "systemd accepts the service" systemd-analyze verify --man=no "$work/hdrcam.service"
exposure=$(systemd-analyze security --offline=true --no-pager "$work/hdrcam.service" |
  sed -n 's/.*exposure level for .*: \([0-9.]*\) .*/\1/p')
awk "BEGIN { exit !($exposure <= 2.0) }" && ok "exposure of the service: $exposure" ||
  not_ok "exposure of the service: $exposure, more than 2.0"
exit $failed
