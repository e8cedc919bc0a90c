#!/usr/bin/env bash
# Makes the wheel, and tests it as its users install it:
#
#     python/make.sh wheel [PROFILE]    dist/*.whl; PROFILE of Cargo.toml, release unless given
#     python/make.sh test [PROFILE]     the same, dev unless given, and python/tests on it
#     python/make.sh release            dist/*.whl for every Linux from glibc 2.28 on, and its source
#
# With PROGRAM_IS_BUILT set, the program that `test` compares with is there and is not built.
#
# Exit code 75: the package index cannot be reached, so nothing was tested. Installed packages are
# kept in target/, and later runs need no network.
set -euo pipefail
cd "$(dirname "$0")/.."

python="${PYTHON:-python3}"
cargo="${CARGO:-cargo}"
maturin=target/wheel-venv
tests=target/python-venv
empty=target/empty-venv
wheels=target/python-wheels
log=target/pip.log

# Runs pip. A failure of the network gives exit code 75.
pip() {
    local venv="$1"
    shift
    mkdir -p target
    "$venv/bin/python" -m pip --disable-pip-version-check "$@" >"$log" 2>&1 && return
    # A reachable index has versions of every package that is installed here.
    if [[ " $* " != *" --no-index "* ]] && grep -q 'connection broken by\|from versions: none' "$log"; then
        echo "not tested: the Python package index cannot be reached; try again with a network" >&2
        exit 75
    fi
    cat "$log" >&2
    exit 1
}

# An environment with these requirements. A stamp is written after all of them are installed.
environment() {
    local venv="$1" wanted
    shift
    wanted="$("$python" --version) $*"
    [ "$(cat "$venv/wanted.txt" 2>/dev/null)" = "$wanted" ] && return
    "$python" -m venv --clear "$venv"
    pip "$venv" install "$@"
    printf '%s' "$wanted" >"$venv/wanted.txt"
}

wheel() {
    environment "$maturin" 'maturin>=1.7,<2'
    rm -rf dist
    "$maturin/bin/maturin" build --locked --profile "$1" --out dist
}

# zig links against an old glibc, whatever this machine has.
release() {
    environment "$maturin" 'maturin>=1.7,<2' 'ziglang'
    rm -rf dist
    # The source has fewer packages than its lock file, so that the wheel is built from this tree.
    "$maturin/bin/maturin" sdist --out dist
    # maturin looks for zig in the python of the path.
    PATH="$PWD/$maturin/bin:$PATH" "$maturin/bin/maturin" build --locked --release \
        --zig --compatibility manylinux_2_28 --out dist
}

# The requirements of an extra in pyproject.toml.
extra() {
    "$python" -c 'import sys, tomllib
project = tomllib.load(open("pyproject.toml", "rb"))["project"]
extra = project["optional-dependencies"][sys.argv[1]]
print("\n".join(project["dependencies"] + extra))' "$1"
}

test_wheel() {
    wheel "$1"
    # The package must compute the same bits as the program.
    [ -n "${PROGRAM_IS_BUILT:-}" ] || "$cargo" build --locked -p stickslip-cli
    local folder
    folder="$("$cargo" metadata --locked --no-deps --format-version 1 |
        sed -E 's/.*"target_directory":"([^"]*)".*/\1/')"

    # NumPy is the only dependency.
    if ! ls "$wheels"/numpy-*.whl >/dev/null 2>&1; then
        mkdir -p "$wheels"
        pip "$maturin" download --quiet --dest "$wheels" 'numpy>=1.26'
    fi
    "$python" -m venv --clear "$empty"
    pip "$empty" install --no-index --find-links "$wheels" dist/*.whl
    "$empty/bin/python" -c 'import stickslip'

    readarray -t wanted < <(extra test)
    environment "$tests" "${wanted[@]}"
    pip "$tests" install --no-index --no-deps --force-reinstall dist/*.whl
    export STICKSLIP="$folder/debug/stickslip"
    # shellcheck disable=SC2086 # Arguments, of which there may be several.
    "$tests/bin/python" -m pytest -q python/tests ${PYTEST_ARGS:-}
}

case "${1:-}" in
wheel) wheel "${2:-release}" ;;
test) test_wheel "${2:-dev}" ;;
release) release ;;
*)
    sed -n '2,12s/^# \{0,1\}//p' "$0" >&2
    exit 2
    ;;
esac
