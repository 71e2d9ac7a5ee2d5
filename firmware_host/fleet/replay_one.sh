#!/usr/bin/env bash
# One job of a fleet: replays the recording on line INDEX (from 0) of OUT/recordings into OUT/NAME, unless an earlier job
# did so with the same recording, program and flags. OUT/NAME/job then says how it went; it is written last.
#   replay_one.sh OUT INDEX
set -uo pipefail
out=$1
recording=$(sed -n "$(($2 + 1))p" "$out/recordings")
[ -n "$recording" ] || { echo "there is no recording $2 in $out/recordings" >&2; exit 2; }
mapfile -t flags <"$out/flags"
hdrcam=${HDRCAM:-hdrcam}
folder=$out/$(basename "${recording%.*}")

# What the result depends on: a changed recording, program or flag makes the job new.
fingerprint=$({ stat -c '%s %Y' "$recording" && sha256sum <"$(command -v "$hdrcam")" && printf '%s\n' "${flags[@]}"; } |
  sha256sum | cut -c1-16)
if [ "$(sed -n 's/^fingerprint //p' "$folder/job" 2>/dev/null)" = "$fingerprint" ] &&
  [ "$(sed -n 's/^exit //p' "$folder/job")" = 0 ]; then
  echo "$recording: done earlier"
  exit 0
fi
mkdir -p "$folder"
rm -f "$folder/job"
"$hdrcam" replay "$recording" -o "$folder/%06d.exr" --stats "$folder/stats.json" --force "${flags[@]}" 2>"$folder/log"
code=$?
{
  printf 'fingerprint %s\nexit %s\n' "$fingerprint" "$code"
  [ "$code" = 0 ] || printf 'said %s\n' "$(tail -n 1 "$folder/log")"
} >"$folder/job.part" && mv "$folder/job.part" "$folder/job"
exit "$code"
