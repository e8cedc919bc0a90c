#!/bin/sh
# Changes one thing at a time that no test may overlook: a constant of a model, a published digit, a
# sign in a statement. Each change must make `cargo test` fail. A part of the tests that fails is
# enough; if it passes, all of them run. Files are restored after each change.
#   tests/mutants.sh [NUMBER...]     all twelve, or those with these numbers
set -u
cd "$(dirname "$0")/.."
[ -z "$(git status --porcelain -- src data crates)" ] ||
    { echo "src/, data/ or crates/ differ from the commit; commit or restore them first" >&2; exit 1; }
only=" $* "
number=0
survived=0
file=
restore() { [ -z "$file" ] || git checkout --quiet -- "$file"; }
trap restore EXIT
trap 'exit 130' INT TERM

# mutant FILE BEFORE AFTER TESTS: the text BEFORE stands once in FILE.
mutant() {
    number=$((number + 1))
    [ "$only" = "  " ] || case "$only" in *" $number "*) ;; *) return ;; esac
    file=$1
    python3 - "$1" "$2" "$3" <<'PYTHON' || { echo "mutant $number: '$2' does not stand once in $1" >&2; exit 1; }
import sys
path, before, after = sys.argv[1:]
text = open(path, encoding="utf-8").read()
if text.count(before) != 1:
    sys.exit(1)
open(path, "w", encoding="utf-8").write(text.replace(before, after))
PYTHON
    cargo test --locked --quiet $TEST_FLAGS --no-run >/dev/null 2>&1 ||
        { echo "mutant $number does not compile" >&2; exit 1; }
    answer=killed
    if cargo test --locked --quiet $TEST_FLAGS -- $4 >/dev/null 2>&1 &&
        cargo test --locked --quiet $TEST_FLAGS >/dev/null 2>&1; then
        answer=SURVIVED
        survived=$((survived + 1))
    fi
    printf '%2d %-8s %s: %s -> %s\n' "$number" "$answer" "$1" "$2" "$3"
    restore
    file=
}
TEST_FLAGS=${TEST_FLAGS:-}
models=src/paper/models
mutant $models/belt.rs 'mu0: 3f64.sqrt() / 9.0' 'mu0: 3f64.sqrt() / 9.01' properties::
mutant $models/forced.rs 'mass: 0.1,' 'mass: 0.101,' properties::
mutant $models/forced.rs 'omega: 3.0 * PI / 2.4728' 'omega: 3.0 * PI / 2.4729' procedure::
mutant $models/block_and_bracket/reading.rs '1.069, 1.980' '1.069, 1.981' block_and_bracket::short
mutant $models/block_and_bracket/mod.rs '-x[0] - force * self.coupling' '-x[0] + force * self.coupling' models::
mutant src/paper/listing/step.rs 'h * 0.166666' 'h * 0.166667' listing::
mutant src/paper/stages.rs 'let x = from(x) + k3 * h;' 'let x = from(x) - k3 * h;' listing::
mutant data/claims.csv 'value,0.4697,4' 'value,0.4698,4' listing::
mutant data/claims.csv 'value,+0.0025,4' 'value,+0.0125,4' report::
mutant data/claims.csv '"visible 1,3,5; invisible 2,4,6"' '"visible 1,3,6; invisible 2,4,5"' goldens::fig04
mutant src/figures/fig06.rs 'pair[1].1 < pair[0].1' 'pair[1].1 > pair[0].1' fig06
mutant src/figures/block_and_bracket/numbers.rs 'zeros == 2' 'zeros != 2' goldens::fig11
echo "$survived of the mutants survived"
[ "$survived" = 0 ]
