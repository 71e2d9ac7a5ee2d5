#!/usr/bin/env bash
# A Slurm cluster of this machine alone, for trying a fleet without one: munge, controller and node run from a folder
# of their own and touch nothing of an installed cluster. Needs root and Debian's slurm-wlm.
#   one_node.sh start FOLDER [CPUS] | stop FOLDER      then: export SLURM_CONF=FOLDER/slurm.conf
set -euo pipefail
verb=$1
mkdir -p "$2"
home=$(realpath "$2")

start() {
  local cpus=${1:-$(nproc)} node
  node=$(hostname -s)
  mkdir -p "$home/state" "$home/spool" "$home/log" "$home/munge"
  # munged insists: its socket is for everyone, its key for nobody else.
  chmod 755 "$home" "$home/munge"
  (umask 377 && head -c 1024 /dev/urandom >"$home/munge/key")
  cat >"$home/slurm.conf" <<CONF
ClusterName=fleet
SlurmctldHost=$node(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$home/munge/socket
SlurmctldPort=16817
SlurmdPort=16818
StateSaveLocation=$home/state
SlurmdSpoolDir=$home/spool
SlurmctldPidFile=$home/slurmctld.pid
SlurmdPidFile=$home/slurmd.pid
SlurmctldLogFile=$home/log/slurmctld
SlurmdLogFile=$home/log/slurmd
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SchedulerType=sched/builtin
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
NodeName=$node NodeAddr=127.0.0.1 CPUs=$cpus State=UNKNOWN
PartitionName=fleet Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
  munged --key-file="$home/munge/key" --socket="$home/munge/socket" --pid-file="$home/munge/pid" \
    --log-file="$home/munge/log" --seed-file="$home/munge/seed"
  export SLURM_CONF=$home/slurm.conf
  slurmctld -c
  slurmd
  for _ in $(seq 60); do
    [ "$(sinfo -h -o %T 2>/dev/null)" != idle ] || return 0
    sleep 0.5
  done
  echo "the node did not come up; see $home/log" >&2
  stop
  exit 1
}

stop() {
  local file
  for file in "$home/slurmd.pid" "$home/slurmctld.pid" "$home/munge/pid"; do
    [ ! -e "$file" ] || kill "$(cat "$file")" 2>/dev/null || true
  done
}

case "$verb" in
  start) start "${3:-}" ;;
  stop) stop ;;
  *) echo "one_node.sh start FOLDER [CPUS] | stop FOLDER" >&2; exit 2 ;;
esac
