#!/usr/bin/env bash
# Shows that results have the same bits on a processor without AVX and FMA. Such a processor is
# emulated; its code and the arithmetic are the emulator's.
#
#     tests/old_processor.sh FOLDER FIGURE...
#
# FOLDER has the program stickslip and those of the figures. What the figures' programs write is
# compared with figures/, byte by byte, and what the commands below write, with what they write
# without an emulator. Exit code 75: there is no emulator, so nothing was compared.
set -euo pipefail
cd "$(dirname "$0")/.."
[ $# -ge 1 ] || { sed -n '5,9s/^# \{0,1\}//p' "$0" >&2; exit 2; }

# The oldest processor of this emulator with what every x86-64 has: a Core 2 of 2006.
emulator="qemu-x86_64 -cpu Conroe"
command -v qemu-x86_64 >/dev/null || {
    echo "not compared: qemu-x86_64 is missing; install the package qemu-user" >&2
    exit 75
}
if ! grep -qw fma /proc/cpuinfo 2>/dev/null; then
    echo "this machine has no FMA either: the figures alone were made by one that has" >&2
fi

programs="$(realpath "$1")" root="$PWD" work="$PWD/target/old-processor"
shift
rm -rf "$work"
mkdir -p "$work/here" "$work/emulated" "$work/figures"

for figure in "$@"; do
    echo "$figure"
    $emulator "$programs/$figure" --out-dir "$work/figures" >/dev/null
done
count=0
while IFS= read -r -d '' file; do
    cmp "$work/figures/$file" "figures/$file"
    count=$((count + 1))
done < <(cd "$work/figures" && find . -type f -print0)

# Chaos that a spectrum is estimated from.
awk 'BEGIN { for (x = y = 0.1; i < 1000; i++) { z = 1 - 1.4*x*x + y; y = 0.3*x; x = z
    printf "%.17g\n", x } }' >"$work/henon.txt"
chain="$root/tests/chain.toml"
# Each runs in a folder of its own, named as its results are.
commands=(
    "simulate $chain --derivatives A,x1"
    "simulate bracket --method dop853"
    "orbit $chain --derivatives A"
    "continue $chain --parameter A=0.48:0.52 --step 0.05"
    "lyapunov $chain --transient 20 --duration 60"
    "basin basins --grid 6x6"
    "bifurcation forced --parameter mu0=0.1262:0.1325 --start x=-0.269 --start v=-1.52 --values 4 --duration 60"
    "map forced --x mu0=0.122:0.134 --y omega=3.76:3.86 --start x=-0.269 --start v=-1.52 --grid 2x2 --until 200 --duration 40"
    "spectrum $work/henon.txt --dt 1"
)
for index in "${!commands[@]}"; do
    echo "stickslip ${commands[index]//"$root/"/}"
    for where in here emulated; do
        mkdir "$work/$where/$index"
        with=""
        [ "$where" = here ] || with="$emulator"
        (
            cd "$work/$where/$index"
            # shellcheck disable=SC2086 # Arguments, of which there are several.
            $with "$programs/stickslip" ${commands[index]} --out out --json >out.json
        )
    done
done
diff -r "$work/here" "$work/emulated"
compared="$(find "$work/emulated" -type f | wc -l)"
[ "$compared" -gt $((2 * ${#commands[@]})) ] || { echo "the commands wrote no files" >&2; exit 1; }
echo "the same bytes: $count files of $# figures, $compared files of ${#commands[@]} commands"
