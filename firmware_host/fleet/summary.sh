#!/usr/bin/env bash
# The table at the end of a fleet: each recording of OUT/recordings, its frames and times from stats.json, how it ended.
# Fails unless all ended well. A result of another recording, program or flags is none.
#   summary.sh OUT
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/fingerprint.sh"
need_jq
out=$1
mapfile -t flags <"$out/flags"
same=$(same_for_all "${flags[@]}")
verdict=0
printf '%-24s %8s %9s %8s  %s\n' recording frames 'ms/frame' 'wall s' result
without_figures() {
  printf '%-24s %8s %9s %8s  %s\n' "$name" - - - "$1"
  verdict=1
}
while IFS= read -r recording; do
  name=$(name_of "$recording")
  job=$out/$name/job
  if [ ! -e "$job" ]; then
    without_figures 'not run'
  elif [ "$(job_says fingerprint "$job")" != "$(fingerprint "$recording" "$same")" ]; then
    without_figures 'not run; what is there is of another recording, program or flags'
  elif [ "$(job_says exit "$job")" != 0 ]; then
    without_figures "exit $(job_says exit "$job"): $(job_says said "$job")"
  elif ! figures=$(jq -r --arg name "$name" '[$name, .emitted, .ms_per_frame, .wall_s] | @tsv' \
    "$out/$name/stats.json"); then
    without_figures 'no figures: its stats.json is gone or damaged; remove it and run the fleet again'
  else
    awk -F'\t' '{ printf "%-24s %8d %9.1f %8.1f  done\n", $1, $2, $3, $4 }' <<<"$figures"
  fi
done <"$out/recordings"
exit $verdict
