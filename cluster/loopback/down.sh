#!/bin/sh
# Ends the three daemons that up.sh has started, and no others.
# usage: down.sh FOLDER
for daemon in slurmd slurmctld munged; do
    file="$1/run/$daemon.pid"
    [ ! -s "$file" ] || kill "$(cat "$file")" 2>/dev/null
done
exit 0
