#!/usr/bin/env bash
# Many recordings, one replay each: as a Slurm job array, or without Slurm as processes of this machine. Recordings that
# are done stay done; run it again after a failure or an interruption. Ends with a table.
#   run_fleet.sh [--plain | --one-node] [--at-once N] -o OUT RECORDING.. [-- FLAGS OF REPLAY]
# --plain      no Slurm
# --one-node   on a cluster that it starts on this machine and stops again (root, slurm-wlm)
# --at-once N  so many at a time; default: what the cluster has room for, or one for each two processors
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
manner=slurm at_once='' out='' recordings=() flags=()
while [ $# -gt 0 ]; do
  case "$1" in
    --at-once | -o) [ $# -gt 1 ] || { echo "$1 needs a value" >&2; exit 2; } ;;&
    --plain | --one-node) manner=${1#--} ;;
    --at-once) at_once=$2; shift ;;
    -o) out=$2; shift ;;
    --) shift; flags=("$@"); break ;;
    -*) echo "unknown flag '$1'; see the head of ${BASH_SOURCE[0]}" >&2; exit 2 ;;
    *) recordings+=("$(realpath "$1")") ;;
  esac
  shift
done
[ -n "$out" ] && [ ${#recordings[@]} -gt 0 ] || { echo "give recordings and -o FOLDER" >&2; exit 2; }
[[ $at_once =~ ^([1-9][0-9]*)?$ ]] || { echo "--at-once takes a number, 1 or more, not '$at_once'" >&2; exit 2; }
[ "$manner" != slurm ] || command -v sbatch >/dev/null ||
  { echo "there is no Slurm here (sbatch); --plain runs without, --one-node starts one on this machine" >&2; exit 2; }
. "$here/fingerprint.sh" # stops where there is no program
need_jq
names=$(for recording in "${recordings[@]}"; do name_of "$recording"; done | sort)
twice=$(uniq -d <<<"$names")
[ -z "$twice" ] || { echo "two recordings are named ${twice%%$'\n'*}; their results would share a folder" >&2; exit 2; }
list=$(grep -x -m 1 -e recordings -e flags <<<"$names" || true)
[ -z "$list" ] || { echo "a recording is named $list, as is a list of the fleet in $out; rename it" >&2; exit 2; }
"$hdrcam" replay --print-config "${flags[@]}" >/dev/null # what it refuses ends the fleet before a job deletes frames
mkdir -p "$out"
out=$(realpath "$out")
printf '%s\n' "${recordings[@]}" >"$out/recordings"
: >"$out/flags"
[ ${#flags[@]} = 0 ] || printf '%s\n' "${flags[@]}" >"$out/flags" # an empty one, as of --layers '', is a flag, too
last=$((${#recordings[@]} - 1))
threads=2 # of a job: beyond two the fit gains little

# The cluster's jobs go on without this script: at ^C they are cancelled. What is done stays done.
cancel() {
  local array
  trap '' INT TERM HUP
  array=$(sed -n 's/^Submitted batch job \([0-9]*\).*/\1/p' "$out/slurm-array.log" 2>/dev/null || true)
  if [ -n "$array" ]; then
    scancel "$array" || echo "the array goes on; end it with: scancel $array" >&2
    for _ in $(seq 20); do # a cluster of this machine is stopped next
      [ -n "$(squeue -h -j "$array" 2>/dev/null)" ] || break
      sleep 0.5
    done
  fi
  echo "interrupted; run it again for what is not done" >&2
  exit 130
}

# quoted WORD: as sh reads it, which runs a job of Slurm.
quoted() { printf "'%s'" "${1//\'/\'\\\'\'}"; }

submit() {
  local code=0
  rm -f "$out"/slurm-*.log # of an earlier array
  # It fails where a job failed, and where none was submitted; then it names no array. A failed recording is in the
  # table; it is no reason to leave the others.
  trap cancel INT TERM HUP
  stdbuf -oL sbatch --wait --array="0-$last${at_once:+%$at_once}" --cpus-per-task="$threads" \
    --job-name=hdrcam-fleet --output="$out/slurm-%a.log" --export=ALL \
    --wrap="$(quoted "$here/replay_one.sh") $(quoted "$out") \$SLURM_ARRAY_TASK_ID" |
    tee -i "$out/slurm-array.log" >&2 || code=$?
  trap - INT TERM HUP
  [ "$code" = 0 ] || [ -s "$out/slurm-array.log" ] || { echo "sbatch failed with $code; no job was submitted" >&2; exit "$code"; }
}

case "$manner" in
  slurm) submit ;;
  one-node)
    cluster=$(mktemp -d /tmp/hdrcam-fleet.XXXXXX)
    trap '"$here/one_node.sh" stop "$cluster"; rm -rf "$cluster"' EXIT
    "$here/one_node.sh" start "$cluster"
    export SLURM_CONF=$cluster/slurm.conf
    threads=$(($(nproc) < threads ? $(nproc) : threads))
    submit
    ;;
  plain)
    seq 0 "$last" | xargs -P "${at_once:-$((($(nproc) + 1) / threads))}" -I{} "$here/replay_one.sh" "$out" {} || true
    ;;
esac
"$here/summary.sh" "$out"
