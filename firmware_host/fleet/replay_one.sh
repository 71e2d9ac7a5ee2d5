#!/usr/bin/env bash
# One job of a fleet: replays the recording on line INDEX (from 0) of OUT/recordings into OUT/NAME, unless an earlier
# job did so with the same recording, program and flags and its figures are there. OUT/NAME/job then says how it went;
# it is written last.
#   replay_one.sh OUT INDEX
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/fingerprint.sh"
out=$1
recording=$(sed -n "$(($2 + 1))p" "$out/recordings")
[ -n "$recording" ] || { echo "there is no recording $2 in $out/recordings" >&2; exit 2; }
mapfile -t flags <"$out/flags"
folder=$out/$(name_of "$recording")
now=$(fingerprint "$recording" "$(same_for_all "${flags[@]}")")

if [ "$(job_says fingerprint "$folder/job")" = "$now" ] && [ "$(job_says exit "$folder/job")" = 0 ] &&
  [ -s "$folder/stats.json" ]; then
  echo "$recording: done earlier"
  exit 0
fi

# frames ACTION: of OUT/NAME, as replay numbers them.
frames() { find "$folder" -maxdepth 1 -type f -regextype posix-extended -regex '.*/[0-9]{6,}\.exr' "$@"; }

# ended CODE SAID: writes how the job went, and ends it.
ended() {
  {
    printf 'fingerprint %s\nexit %s\n' "$now" "$1"
    [ "$1" = 0 ] || printf 'said %s\n' "$2"
  } >"$folder/job.part" && mv "$folder/job.part" "$folder/job"
  exit "$1"
}

mkdir -p "$folder"
# Every job begins its log before its frames.
[ -e "$folder/log" ] || [ -z "$(frames -print -quit)" ] ||
  ended 17 "in $folder are frames that no job of a fleet wrote; move them, or give another OUT"
[ -e "$recording" ] || ended 3 "hdrcam: '$recording' does not exist." # its frames stay: the disk may be back tomorrow
# replay FLAG..: what the job does.
replay() { "$hdrcam" replay "$recording" -o "$folder/%06d.exr" --stats "$folder/stats.json" "$@" 2>"$folder/log"; }

# Without --force replay refuses the earlier frames at the latest, and before that flags that do not fit together.
if [ -n "$(frames -print -quit)" ]; then
  replay "${flags[@]}"
  [ $? != 2 ] || ended 2 "$(tail -n 1 "$folder/log")"
fi
# An earlier job may have left more frames than this one will, and figures of its own.
rm -f "$folder/job" "$folder/frames.csv" "$folder/stats.json"
frames -delete
replay --force "${flags[@]}"
code=$?
ended "$code" "$(tail -n 1 "$folder/log")"
