#!/usr/bin/env bash
# The service under a systemd that runs: a Debian 12 with the package, booted in a container (namespaces and a control
# group of its own; the machine's own systemd, if it has one, is left alone). The unit is ready when frames come,
# records the simulated camera within its limits, stays alive by its watchdog, is restarted when it hangs or dies, and
# stops with whole files. Needs what clean_root.sh needs, and cgroup v2. Called by ./run installed running-systemd.
#   run_running_systemd.sh FOLDER_OF_PACKAGES [MIRROR]
set -euo pipefail
here=$(dirname "$(realpath "$0")")
. "$here/clean_root.sh"
make_clean_root "$1" "${2:-}" systemd systemd-sysv

watchdog_s=10 # of this test; the unit's own is 30
first=        # process 1 of the container, as this machine numbers it
groups=$(mktemp -d)
mount -t cgroup2 cgroup2 "$groups"
group=$groups/hdrcam-test.$$
mkdir "$group"
leave() {
  [ -z "$first" ] || kill -KILL "$first" 2>/dev/null || true # with it goes everything in its namespace
  local waited
  for waited in $(seq 50); do
    find "$group" -depth -type d -exec rmdir {} + 2>/dev/null && break
    sleep 0.2
  done
  umount "$groups" && rmdir "$groups"
  remove_clean_root
}
trap leave EXIT

failed=0
check() { # WHAT COMMAND..
  local what=$1
  shift
  if "$@"; then printf 'ok    %s\n' "$what"; else
    printf 'FAIL  %s\n' "$what"
    failed=1
  fi
}
booted() { nsenter --target "$first" --all --root -- env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin "$@"; }
of_unit() { booted systemctl show hdrcam.service --property "$1" --value; }
is() { [ "$(of_unit "$1")" = "$2" ]; }
await() { # SECONDS COMMAND..
  local end=$((SECONDS + $1))
  shift
  until "$@"; do
    [ "$SECONDS" -lt "$end" ] || return 1
    sleep 0.5
  done
}
signal() { booted sh -c "kill -$1 $(of_unit MainPID)"; }
journal() { booted journalctl -u hdrcam.service --no-pager | tail -40; }
recordings() { find "$root/var/lib/hdrcam" -name '*.mkv' | wc -l; }
bytes() { du -sb "$root/var/lib/hdrcam" | cut -f1; }
grows() {
  local before
  before=$(bytes)
  await 60 eval '[ "$(bytes)" -gt "$before" ]'
}

say "boot"
mkdir -p "$root/etc/hdrcam" "$root/etc/systemd/system/hdrcam.service.d"
cat >"$root/etc/hdrcam/hdrcam.toml" <<'TOML'
[camera]
id = "sim:walk"
format = "RGB24"
width = 320
height = 240
[fit]
preset = "realtime"
[record]
file = "{start}.mkv"
TOML
printf '[Service]\nWatchdogSec=%s\n' "$watchdog_s" >"$root/etc/systemd/system/hdrcam.service.d/test.conf"
(
  echo "$BASHPID" >"$group/cgroup.procs"
  exec unshare --mount --pid --fork --kill-child --uts --ipc --net --cgroup "$here/boot_systemd.sh" "$root"
) 2>"$root/boot.log" &
is_first() { first=$(pgrep --parent "$!" || true); [ -n "$first" ]; }
await 20 is_first
up() { case $(booted systemctl is-system-running 2>/dev/null) in running | degraded) ;; *) return 1 ;; esac; }
await 120 up || { echo "systemd does not come up"; cat "$root/boot.log"; exit 1; }
booted systemctl --version | head -1

say "start"
began=$SECONDS
check "the unit starts, and says itself that it is ready" booted systemctl start hdrcam.service
[ "$failed" = 0 ] || { journal; exit 1; }
echo "      after $((SECONDS - began)) s"
check "it is active" is SubState running
check "it tells what it does: $(of_unit StatusText)" eval '[ -n "$(of_unit StatusText)" ]'
inside_pid=$(of_unit MainPID)
status=$(booted cat "/proc/$inside_pid/status")
in_status() { grep -qE "^$1:[[:space:]]*$2" <<<"$status"; }
check "it is the user hdrcam" [ "$(booted stat --format %U "/proc/$inside_pid")" = hdrcam ]
check "it has no capability" in_status CapEff 0000000000000000
check "it gets no new privilege" in_status NoNewPrivs 1
check "its system calls are filtered" in_status Seccomp 2
check "it cannot write elsewhere" eval '! booted nsenter --target "$inside_pid" --mount touch /usr/probe 2>/dev/null'
check "it records" grows

say "watchdog of $watchdog_s s"
sleep $((3 * watchdog_s))
check "three periods later it runs still" eval 'is SubState running && is NRestarts 0'
check "and records still" grows
signal STOP
check "a program that hangs is ended and started again" await $((6 * watchdog_s)) eval 'is NRestarts 1 && is SubState running'
check "for that reason" eval 'booted journalctl -u hdrcam.service --no-pager | grep -q "Watchdog timeout"'
check "and records again, into a new file" eval '[ "$(recordings)" = 2 ] && grows'
signal KILL
check "a program that is killed is started again" await 60 eval 'is NRestarts 2 && is SubState running'
check "and records again, into a new file" eval 'await 30 eval "[ \$(recordings) = 3 ]" && grows'

say "stop"
check "the unit stops" booted systemctl stop hdrcam.service
check "in order" eval 'is Result success && is ExecMainStatus 0 && is SubState dead'
for recording in "$root"/var/lib/hdrcam/*.mkv; do
  told=$(inside hdrcam info "/var/lib/hdrcam/$(basename "$recording")" || true)
  printf '      %s:%s,%s\n' "$(basename "$recording")" "$(sed -n 's/^ *frames  *\(.*\)/ \1/p' <<<"$told")" \
    "$(sed -n 's/^ *complete  *\(.*\)/ complete: \1/p' <<<"$told")"
done
check "the last recording is complete" grep -q '^ *complete  *yes' <<<"$told"
[ "$failed" = 0 ] || journal
exit "$failed"
