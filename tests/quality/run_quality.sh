#!/usr/bin/env bash
# Scores hdrcam on every clip with ground truth under a folder, beside classical peers if wanted.
set -euo pipefail
trap 'exit 130' INT # replay ends in order at ^C; what is next would begin

usage() {
  cat <<'TEXT'
usage: run_quality.sh CLIPS [options] [-- REPLAY-FLAGS...]

CLIPS is a clip (a folder with clip.json and gt/) or a folder that holds clips at any depth.
For each clip: hdrcam import, then for each preset and emission hdrcam replay and hdrcam compare.

  -o, --out DIR          where results go                            (default out/quality)
      --hdrcam PROGRAM   the program to score                        (default build/release/hdrcam)
      --preset LIST      comma separated                             (default balanced)
      --emit LIST        comma separated: state, field, merged       (default: what replay emits by itself)
      --peers FILE       hdrpeers.cpp, compiled on the fly; needs a C++ compiler and OpenCV's photo and imgcodecs
      --peer-list LIST   METHOD:RESPONSE, comma separated            (default kang:est2,kang:gt)
      --set NAME=LIST    one more run for each value of a knob: --set steps=0,30,100
      --geometry         also depth, motion and novel views: a second table
      --skip N           frames left out at either end               (default 1)
      --again            do not keep results of an earlier run
      --keep             keep recordings and HDR frames (large)
  -h, --help             this text
What follows -- goes to hdrcam replay as it is.

Writes DIR/quality.md, DIR/quality.json and DIR/runs/CLIP/METHOD/{scores.json,stats.json,log.txt}. A result is kept from
an earlier run as long as the program and its flags are the same. Exit code: 0, 1 where a run failed, 2 for bad usage.
TEXT
}

fail() { echo "run_quality.sh: $*" >&2; exit 2; }

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
clips_root='' out=out/quality hdrcam=$root/build/release/hdrcam presets=balanced emits='' peers='' peer_list=kang:est2,kang:gt
skip=1 again=no keep=no knob='' knob_values='' geometry=no replay_flags=()
while [[ $# -gt 0 ]]; do
  case $1 in
    -o|--out|--hdrcam|--preset|--emit|--peers|--peer-list|--skip|--set)
      [[ $# -ge 2 ]] || fail "$1 needs a value; see --help" ;;&
    -o|--out) out=$2; shift 2 ;;
    --hdrcam) hdrcam=$2; shift 2 ;;
    --preset) presets=$2; shift 2 ;;
    --emit) emits=$2; shift 2 ;;
    --peers) peers=$2; shift 2 ;;
    --peer-list) peer_list=$2; shift 2 ;;
    --skip) skip=$2; shift 2 ;;
    --set)
      [[ $2 == ?*=?* ]] || fail "--set takes NAME=VALUE,VALUE.., not '$2'"
      knob=${2%%=*} knob_values=${2#*=}; shift 2 ;;
    --geometry) geometry=yes; shift ;;
    --again) again=yes; shift ;;
    --keep) keep=yes; shift ;;
    -h|--help) usage; exit 0 ;;
    --) shift; replay_flags=("$@"); break ;;
    -*) fail "unknown option '$1'; see --help" ;;
    *) [[ -z $clips_root ]] || fail "one folder of clips at a time, not '$clips_root' and '$1'"; clips_root=$1; shift ;;
  esac
done
[[ -n $clips_root ]] || { usage >&2; exit 2; }
[[ -d $clips_root ]] || fail "'$clips_root' is not a folder"
[[ $skip =~ ^[0-9]+$ ]] || fail "--skip takes a count of frames, not '$skip'"
command -v "$hdrcam" >/dev/null || fail "there is no program '$hdrcam'; build it or give --hdrcam"
hdrcam=$(command -v "$hdrcam")

mapfile -t clips < <(find -L "$clips_root" -name clip.json -type f -printf '%h\n' | sort |
                     while read -r folder; do [[ -d $folder/gt ]] && echo "$folder"; done || true)
[[ ${#clips[@]} -gt 0 ]] || fail "no clip with ground truth (clip.json and gt/) under '$clips_root'"
repeated=$(printf '%s\n' "${clips[@]##*/}" | sort | uniq -d)
[[ -z $repeated ]] || fail "two clips are called '${repeated%%$'\n'*}'; score their folders one at a time"

mkdir -p "$out"
out=$(cd "$out" && pwd)
failures=0

# The first number called KEY in a JSON file, or nothing.
figure() { grep -oE "\"$2\": *-?[0-9][0-9.eE+-]*" "$1" 2>/dev/null | head -n 1 | sed 's/.*: *//' || true; }

# done_before RUN STAMP: whether RUN holds scores that were made the same way.
done_before() { [[ $again == no && -s $1/scores.json && -f $1/stamp && $(<"$1/stamp") == "$2" ]]; }

# run_step RUN WORDS...: runs a command into the log of RUN; says the last line of the log where it fails.
run_step() {
  local run=$1; shift
  echo "\$ $*" >>"$run/log.txt"
  "$@" >>"$run/log.txt" 2>&1 && return
  echo "  failed: $(tail -n 1 "$run/log.txt") (see $run/log.txt)" >&2
  return 1
}

compile_peers() {
  command -v g++ >/dev/null || fail "--peers needs g++"
  [[ -f $peers ]] || fail "there is no file '$peers' to compile the peers from"
  local work=$out/peers module modules=(core imgproc imgcodecs photo video calib3d)
  mkdir -p "$work/include/opencv2"
  # <opencv2/opencv.hpp> wants every module of OpenCV installed; the peers use these.
  for module in "${modules[@]}"; do echo "#include <opencv2/$module.hpp>"; done >"$work/include/opencv2/opencv.hpp"
  g++ -O2 -std=c++17 -I"$work/include" -I/usr/include/opencv4 "$peers" -o "$work/hdrpeers" \
      "${modules[@]/#/-lopencv_}" >"$work/log.txt" 2>&1 ||
    fail "the peers do not compile ($(grep -m 1 error "$work/log.txt")); they need libopencv-photo-dev and" \
         "libopencv-imgcodecs-dev (log: $work/log.txt)"
}

# score_peer CLIP RUN METHOD RESPONSE
score_peer() {
  local clip=$1 run=$2 ms
  run_step "$run" "$out/peers/hdrpeers" "$clip" "$run/frames" "$3" --crf "$4" || return 1
  ms=$(grep -oE 'ms_per_frame mean=[0-9.]+' "$run/log.txt" | tail -n 1 | cut -d= -f2)
  echo "{\"ms_per_frame\": ${ms:-null}}" >"$run/stats.json"
  run_step "$run" "$hdrcam" compare "$clip" "$run/frames" --skip "$skip" --label "$3-$4" --json "$run/scores.json"
}

# score_hdrcam CLIP RUN LABEL REPLAY-FLAGS...: imports the clip where no method before has.
score_hdrcam() {
  local clip=$1 run=$2 label=$3
  shift 3
  if [[ ! -s $recording ]]; then
    run_step "$run" "$hdrcam" import "$clip" -o "$recording.part.mkv" || return 1
    mv "$recording.part.mkv" "$recording"
  fi
  mkdir -p "$run/frames"
  [[ $geometry == no ]] || set -- "$@" --truth "$clip"
  run_step "$run" "$hdrcam" replay "$recording" -o "$run/frames/%06d.exr" --stats "$run/stats.json" "$@" || return 1
  run_step "$run" "$hdrcam" compare "$clip" "$run/frames" --skip "$skip" --label "$label" --json "$run/scores.json"
}

# score CLIP METHOD STAMP SCORER WORDS...: one cell of the table, unless it is there already. Adds it to rows.tsv.
score() {
  local clip=$1 method=$2 stamp="$3 skip=$skip" scorer=$4 run=$out/runs/${1##*/}/$2
  shift 4
  if ! done_before "$run" "$stamp"; then
    rm -rf "$run"
    mkdir -p "$run"
    if "$scorer" "$clip" "$run" "$@"; then echo "$stamp" >"$run/stamp"; else rm -f "$run/scores.json"; fi
    [[ $keep == yes ]] || rm -rf "$run/frames"
  fi
  [[ -s $run/scores.json ]] || failures=$((failures + 1))
  local cell="${clip##*/}"$'\t'"$method" key
  for key in psnr_mu flicker worst_psnr_mu; do cell+=$'\t'$(figure "$run/scores.json" "$key"); done
  cell+=$'\t'$(figure "$run/stats.json" ms_per_frame)
  for key in depth_abs_rel flow_backward_epe_px field_flow_epe_px field_flow_moving_epe_px novel_psnr_mu; do cell+=$'\t'$(figure "$run/scores.json" "$key"); done
  echo "$cell" >>"$out/rows.tsv"
  if [[ -s $run/scores.json ]] && ! grep -q '"missing": \[\]' "$run/scores.json"; then
    echo "  some frames of ${clip##*/} have no estimate, see \"missing\" in $run/scores.json" >&2
  fi
  printf '  %-24s %s\n' "$method" "$(awk -F '\t' "$words"'{ print words($3, $4, $5, $6) }' <<<"$cell")"
}

# A cell in words, for awk.
words='
  function or_dash(value, form) { return value == "" ? "-" : sprintf(form, value) }
  function words(psnr, flicker, worst, ms) {
    if (psnr == "") return "failed"
    return or_dash(psnr, "%.2f") " / " or_dash(flicker, "%.4f") " / " or_dash(worst, "%.2f") " / " or_dash(ms, "%.1f")
  }'

# The second table: what is known of depth and motion.
geometry_markdown() {
  echo
  echo 'Depth: mean |s d - g| / g with one scale s a clip. Motion: end-point error of the flow to the previous frame, pixels: of the'
  echo "state, of the field, of the field where objects move in the world (its scene flow). Novel view: PSNR-mu of the field's"
  echo "picture from the clip's other camera (gt/novel)."
  echo
  echo '| clip | method | depth abs-rel | state motion, px | field motion, px | moving objects, px | novel view, dB |'
  echo '|---|---|---|---|---|---|---|'
  awk -F '\t' "$words"'$7 != "" || $8 != "" {
    printf "| %s | %s | %s | %s | %s | %s | %s |\n", $1, $2, or_dash($7, "%.4f"), or_dash($8, "%.3f"),
           or_dash($9, "%.3f"), or_dash($10, "%.3f"), or_dash($11, "%.2f") }' "$out/rows.tsv"
}

# rows.tsv holds, tab separated: clip, method, psnr_mu, flicker, worst_psnr_mu, ms_per_frame, depth_abs_rel,
# flow_backward_epe_px, field_flow_epe_px, field_flow_moving_epe_px, novel_psnr_mu.
markdown() {
  echo '# Quality'
  echo
  echo 'Cells: PSNR-mu dB / flicker stops per frame / worst frame dB / ms per frame. Mean: over the clips on which none failed.'
  echo
  awk -F '\t' "$words"'
    !($1 in clip_seen) { clip_seen[$1]; clip[++clips] = $1 }
    !($2 in method_seen) { method_seen[$2]; method[++methods] = $2 }
    {
      cell[$1, $2] = words($3, $4, $5, $6)
      for (k = 3; k <= 6; ++k) value[$1, $2, k] = $k
      if ($3 == "") failed[$1]
    }
    function mean(m, k,    i, sum, count) {
      for (i = 1; i <= clips; ++i)
        if (!(clip[i] in failed) && value[clip[i], m, k] != "") { sum += value[clip[i], m, k]; ++count }
      return count ? sum / count : ""
    }
    END {
      line = "| clip |"; rule = "|---|"
      for (j = 1; j <= methods; ++j) { line = line " " method[j] " |"; rule = rule "---|" }
      print line; print rule
      for (i = 1; i <= clips; ++i) {
        line = "| " clip[i] " |"
        for (j = 1; j <= methods; ++j) line = line " " cell[clip[i], method[j]] " |"
        print line
      }
      for (i in failed) ++lost
      line = "| **mean of " clips - lost "** |"
      for (j = 1; j <= methods; ++j) {
        m = method[j]
        line = line " " words(mean(m, 3), mean(m, 4), mean(m, 5), mean(m, 6)) " |"
      }
      print line
    }' "$out/rows.tsv"
}

json() {
  awk -F '\t' 'function or_null(v) { return v == "" ? "null" : v }
    BEGIN { print "[" }
    {
      if (NR > 1) print ","
      printf " {\"clip\": \"%s\", \"method\": \"%s\", ", $1, $2
      printf "\"psnr_mu\": %s, \"flicker\": %s, \"worst_psnr_mu\": %s, \"ms_per_frame\": %s, ",
             or_null($3), or_null($4), or_null($5), or_null($6)
      printf "\"depth_abs_rel\": %s, \"flow_backward_epe_px\": %s, \"field_flow_epe_px\": %s, ", or_null($7), or_null($8), or_null($9)
      printf "\"field_flow_moving_epe_px\": %s, \"novel_psnr_mu\": %s}", or_null($10), or_null($11)
    }
    END { print "\n]" }' "$out/rows.tsv"
}

if [[ -n $peers ]]; then compile_peers; fi
program=$(sha256sum "$hdrcam" | cut -c 1-16)
IFS=, read -ra preset_list <<<"$presets"
IFS=, read -ra emit_list <<<"$emits"
IFS=, read -ra peer_pairs <<<"$peer_list"
IFS=, read -ra value_list <<<"$knob_values"
[[ ${#emit_list[@]} -gt 0 ]] || emit_list=('')
[[ ${#value_list[@]} -gt 0 ]] || value_list=('')
: >"$out/rows.tsv"

for clip in "${clips[@]}"; do
  echo "${clip##*/}"
  recording=$out/runs/${clip##*/}/clip.mkv
  rm -f "$recording"  # of an earlier run, perhaps of an earlier program
  for preset in "${preset_list[@]}"; do
    for emit in "${emit_list[@]}"; do
      layers=depth,flow,field_flow
      [[ $emit != state ]] || layers=flow  # the rest is the field's
      for value in "${value_list[@]}"; do
        flags=(--preset "$preset" ${emit:+--emit "$emit"} ${value:+--set "$knob=$value"} "${replay_flags[@]}")
        [[ $geometry == no ]] || flags+=(--layers "$layers")
        method=$preset${emit:+-$emit}${value:+-$knob=$value}
        score "$clip" "$method" "$program ${flags[*]}" score_hdrcam "$method" "${flags[@]}"
      done
    done
  done
  if [[ -n $peers ]]; then
    for pair in "${peer_pairs[@]}"; do
      method=${pair%%:*} response=${pair##*:}
      score "$clip" "$method-$response" "$(sha256sum <"$peers" | cut -c 1-16)" score_peer "$method" "$response"
    done
  fi
  [[ $keep == yes ]] || rm -f "$recording"
done

markdown >"$out/quality.md"
[[ $geometry == no ]] || geometry_markdown >>"$out/quality.md"
json >"$out/quality.json"
rm -f "$out/rows.tsv"
echo
sed -n '3,$p' "$out/quality.md"
if [[ $failures -gt 0 ]]; then
  echo "run_quality.sh: $failures of the runs failed; their logs are under $out/runs" >&2
  exit 1
fi
