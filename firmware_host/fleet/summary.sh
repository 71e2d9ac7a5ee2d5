#!/usr/bin/env bash
# The table at the end of a fleet: each recording of OUT/recordings, its frames and times from stats.json, how it ended.
# Fails unless all ended well.
#   summary.sh OUT
set -euo pipefail
out=$1
verdict=0
printf '%-24s %8s %9s %8s  %s\n' recording frames 'ms/frame' 'wall s' result
while IFS= read -r recording; do
  name=$(basename "${recording%.*}")
  job=$out/$name/job
  if [ ! -e "$job" ]; then
    printf '%-24s %8s %9s %8s  %s\n' "$name" - - - 'not run'
    verdict=1
  elif [ "$(sed -n 's/^exit //p' "$job")" = 0 ]; then
    jq -r --arg name "$name" '[$name, .emitted, .ms_per_frame, .wall_s] | @tsv' "$out/$name/stats.json" |
      awk -F'\t' '{ printf "%-24s %8d %9.1f %8.1f  done\n", $1, $2, $3, $4 }'
  else
    printf '%-24s %8s %9s %8s  exit %s: %s\n' "$name" - - - "$(sed -n 's/^exit //p' "$job")" "$(sed -n 's/^said //p' "$job")"
    verdict=1
  fi
done <"$out/recordings"
exit $verdict
