#!/usr/bin/env bash
# A sweep on a real Slurm of one node: a job array of eight, one task killed, one requeued, and the
# merge. Every file of blocks and the table must be those of a single run, byte for byte.
# usage: test.sh STICKSLIP      (the program; absolute path)
set -euo pipefail
for need in sbatch slurmctld slurmd munged; do
    command -v "$need" >/dev/null || {
        echo "error: $need is missing; apt-get install slurm-wlm munge" >&2
        exit 1
    }
done
here=$(cd "$(dirname "$0")" && pwd)
export STICKSLIP=$1
folder=$(mktemp -d)
slurm=$folder/slurm
tidy() {
    "$here/loopback/down.sh" "$slurm"
    # The daemons write a last state before they end.
    sleep 0.5
    rm -rf "$folder"
}
trap tidy EXIT
fail() {
    echo "error: $*" >&2
    tail -n 5 "$folder"/out/log/* "$slurm"/log/*.log >&2 || true
    exit 1
}
# Waits, for at most 60 s, until a command succeeds.
await() {
    local what=$1 tries=0
    shift
    until "$@" >/dev/null 2>&1; do
        tries=$((tries + 1))
        [ "$tries" -lt 1200 ] || fail "waited for 60 s: $what"
        sleep 0.05
    done
}

out=$folder/out
# Large enough that a share lasts far longer than the polls that wait for its first blocks.
sweep=(basin basins --grid 512x384)
timeout 60 "$STICKSLIP" "${sweep[@]}" --out "$folder/single" >/dev/null
"$here/loopback/up.sh" "$slurm"
export SLURM_CONF=$slurm/slurm.conf
submitted=$("$here/submit.sh" 8 "$out" "${sweep[@]}")
echo "$submitted"
array=$(sed -E 's/^array ([0-9]+) .*/\1/' <<<"$submitted")

some_blocks() { compgen -G "$out/shares/$1-of-8/sweep/blocks/*.block"; }
await "the first blocks of share 1" some_blocks 1
victim=$(pgrep -f -- "--shard 1/8 .*--out $out/") || fail "share 1 has ended too soon to be killed"
kill -9 "$victim"
await "the first blocks of share 3" some_blocks 3
scontrol requeue "${array}_3" || fail "share 3 has ended too soon to be requeued"

merged() { grep -q '^wrote' "$out/log/merge.log"; }
await "the merge" merged
log() { cat "$out/log/share-$1.log"; }
grep -q 'killed by signal 9; it is queued again' <(log 1) || fail "share 1 was not killed"
for restarted in 1 3; do
    grep -q 'restarts: 1' <(log $restarted) || fail "share $restarted was not started again"
done
diff -r "$folder/single" "$out" --exclude=shares --exclude=log --exclude=work ||
    fail "the merged files are not those of a single run"
echo "8 shares, one killed and one requeued: the same bytes as a single run"
