#!/usr/bin/env bash
# Gives broken input to each target for some seconds, beginning with what fuzz/corpus/ keeps:
#
#     fuzz/run.sh SECONDS TARGET...
#
# A failure leaves its input in fuzz/artifacts/TARGET/. Exit code 75: cargo-fuzz is missing.
set -euo pipefail
cd "$(dirname "$0")/.."
[ $# -ge 2 ] || { sed -n '4s/^# *//p' "$0" >&2; exit 2; }
command -v cargo-fuzz >/dev/null || {
    echo "not run: cargo-fuzz is missing; install it by \`cargo install --locked cargo-fuzz\`" >&2
    exit 75
}
# The coverage of the fuzzer is of the nightly compiler; this makes the stable one accept it. There
# is no sanitizer, since this code has no `unsafe`.
export RUSTC_BOOTSTRAP=1
seconds="$1"
shift
cargo fuzz build --sanitizer none
for target in "$@"; do
    # What is found grows in target/ and not in the repository.
    found="target/fuzz/$target"
    mkdir -p "$found"
    cargo fuzz run --sanitizer none "$target" "$found" "fuzz/corpus/$target" -- \
        -max_total_time="$seconds" -timeout=20 -rss_limit_mb=2048 -max_len=4096 \
        -print_final_stats=1
done
