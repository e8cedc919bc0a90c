#!/bin/sh
# A sweep as a Slurm job array, and a merge that runs when all tasks are done.
# usage: submit.sh SHARES OUT COMMAND [ARGUMENT...]
#   cluster/submit.sh 64 results/plane basin belt.toml --set v=0.2
# STICKSLIP is the program to run; by default, stickslip in the path. Options of both jobs, such as
# --partition, come from Slurm's own SBATCH_... variables. The same line resumes a stopped sweep.
set -eu
[ $# -ge 3 ] || { sed -n '2,6s/^# //p' "$0" >&2; exit 2; }
case $1 in '' | *[!0-9]* | 0)
    echo "error: SHARES is \`$1\`; give a whole number of at least 1" >&2
    exit 2
    ;;
esac
shares=$1 out=$2
shift
shift
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$out/log"
out=$(cd "$out" && pwd)
array=$(sbatch --parsable --array="1-$shares" --output="$out/log/share-%a.log" \
    "$here/share.sbatch" "$shares" "$out" "$@")
merge=$(sbatch --parsable --dependency="afterok:$array" --kill-on-invalid-dep=yes \
    --output="$out/log/merge.log" "$here/merge.sbatch" "$shares" "$out")
echo "array $array of $shares shares, then merge $merge; logs in $out/log"
