#!/bin/sh
# Starts a Slurm of one node on the loopback address and waits until the node is idle. All that it
# writes is below FOLDER.
# usage: up.sh FOLDER      then: export SLURM_CONF=FOLDER/slurm.conf      in the end: down.sh FOLDER
set -eu
umask 022
folder=$1
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$folder/run" "$folder/log" "$folder/state" "$folder/spool"
# Ports of its own, so that two tests on one machine do not collide.
port=$((20000 + $$ % 10000 * 2))
sed -e "s|@FOLDER@|$folder|g" -e "s|@USER@|$(id -un)|g" -e "s|@HOST@|$(hostname -s)|" \
    -e "s|@CONTROL_PORT@|$port|" -e "s|@NODE_PORT@|$((port + 1))|" -e "s|@CPUS@|$(nproc)|" \
    -e "s|@MEMORY@|$(awk '/MemTotal/ { print int($2 / 1024 * 0.9) }' /proc/meminfo)|" \
    "$here/slurm.conf.in" >"$folder/slurm.conf"
export SLURM_CONF="$folder/slurm.conf"
(umask 077 && dd if=/dev/urandom of="$folder/run/munge.key" bs=1024 count=1 status=none)
munged --force --key-file="$folder/run/munge.key" --socket="$folder/run/munge.socket" \
    --pid-file="$folder/run/munged.pid" --log-file="$folder/log/munged.log" --seed-file="$folder/run/munge.seed"
slurmctld -c
slurmd
tries=0
until sinfo --noheader --format=%t 2>/dev/null | grep -q idle; do
    tries=$((tries + 1))
    [ "$tries" -lt 150 ] || { echo "the node is not idle after 15 s; see $folder/log" >&2; exit 1; }
    sleep 0.1
done
