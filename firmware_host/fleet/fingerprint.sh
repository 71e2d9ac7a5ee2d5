#!/usr/bin/env bash
# Sourced by what starts, does and lists jobs. What the result of a job depends on: a changed recording, program, flag
# or file or folder that a flag names, such as --config or --truth, makes the job new.
hdrcam=${HDRCAM:-hdrcam}
command -v "$hdrcam" >/dev/null || { echo "there is no program '$hdrcam' here; set HDRCAM to it" >&2; exit 2; }

# same_for_all FLAG..: what all jobs of a fleet share; give it to fingerprint.
same_for_all() {
  local word file
  sha256sum <"$(command -v "$hdrcam")"
  for word in "$@"; do
    printf '%s\n' "$word"
    for file in "$word" "${word#*=}"; do # x.toml, --config=x.toml
      [ ! -f "$file" ] || sha256sum <"$file"
      # a folder may be large: its files by their names, sizes and times
      [ ! -d "$file" ] || find -L "$(realpath -- "$file")" -type f -printf '%P %s %T@\n' | LC_ALL=C sort
    done
  done
}

# fingerprint RECORDING SAME_FOR_ALL: a recording that is gone has one, too.
fingerprint() {
  { stat -c '%s %Y' "$1" 2>/dev/null || true; printf '%s\n' "$2"; } | sha256sum | cut -c1-16
}

# name_of RECORDING: of its folder in OUT and of its row in the table: without folder and extension.
name_of() { sed 's|.*/||; s|\(.\)\.[^.]*$|\1|' <<<"$1"; }

# need_jq: stops where the figures of a job cannot be read.
need_jq() {
  command -v jq >/dev/null || { echo "there is no program 'jq' here, which reads the figures of the table" >&2; exit 2; }
}

# job_says WORD FILE: what the file of a job says under that word; nothing where there is none.
job_says() { sed -n "s/^$1 //p" "$2" 2>/dev/null || true; }
