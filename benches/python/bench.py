"""This package beside its peers from Python, in one process: error, time, lines of the user.

    python bench.py TABLE [--rounds N] [PROBLEM ...]

Each problem is a module with a function `with_TOOL(tol)` for each tool, of one shape: it states
the problem and returns a function that solves it. Times are those of the processor on one thread,
least of so many rounds, in which the tools take turns. What it takes to state the problem and to
compile it has a column of its own. The time at equal error is read between the tolerances, at the
target or at the tool's least error. SciPy does a sample of the starts of the basin, and its time is
scaled.
"""

import argparse
import csv
import importlib
import inspect
import io
import os
import sys
import time
import tokenize

import numpy as np

TOOLS = ("stickslip", "scipy", "heyoka", "diffsol")
TOLERANCES = (1e-5, 1e-7, 1e-9, 1e-11, 1e-13)
# Error at which times are compared.
TARGETS = {"belt": 1e-10, "impact": 1e-10, "buck": 1e-10, "diagram": 1e-5}
SLOW = 1.0


def lines(function):
    """Lines of code, without the one with `def`, comments and empty ones."""
    ignored = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}
    tokens = tokenize.generate_tokens(io.StringIO(inspect.getsource(function)).readline)
    found = {
        line
        for token in tokens
        if token.type not in ignored and token.type != tokenize.ENDMARKER
        for line in range(token.start[0], token.end[0] + 1)
    }
    return len(found) - 1


def timed(run):
    begin = time.process_time()
    found = run()
    return time.process_time() - begin, found


def error(found, wanted):
    """The largest difference, infinite where something is missing."""
    return float(np.abs(found - wanted).max()) if found.shape == wanted.shape else np.inf


def at_error(curve, target):
    """The time at an error, by a line through the logarithms, and that error.

    Where the target is not reached, it is the least error of the tool.
    """
    curve = sorted((wrong, seconds) for wrong, seconds in curve if 0 < wrong < np.inf)
    if not curve:
        return np.nan, np.nan
    reached = [one for one in curve if one[0] <= target]
    if not reached:
        return curve[0][1], curve[0][0]
    below = min(reached, key=lambda one: one[1])
    above = [one for one in curve if one[0] > target and one[1] < below[1]]
    if not above:
        return below[1], below[0]
    above = max(above, key=lambda one: one[1])
    part = np.log(target / below[0]) / np.log(above[0] / below[0])
    return below[1] * (above[1] / below[1]) ** part, target


def orbits(name, rounds):
    """Rows of a problem with a number as its answer, at all tolerances."""
    module = importlib.import_module(name)
    wanted = module.reference()
    runs, found = [], {}
    for tool in TOOLS:
        make = getattr(module, f"with_{tool}", None)
        for tol in TOLERANCES if make else ():
            stated, run = timed(lambda: make(tol))
            try:
                seconds, answer = timed(run)
            except Exception as failure:
                print(f"{name}: {tool} fails at {tol:g}: {failure}", file=sys.stderr)
                continue
            runs.append((tool, tol, run))
            found[tool, tol] = [stated, seconds, error(answer, wanted), lines(make)]
    for _ in range(rounds):
        for tool, tol, run in runs:
            one = found[tool, tol]
            if one[1] < SLOW:
                one[1] = min(one[1], timed(run)[0])
    return [(name, *key, *values) for key, values in found.items()]


def basins(rounds):
    """Rows of the basin; the error is the part of the starts with another answer."""
    module = importlib.import_module("basin")
    starts = module.starts()
    wanted = module.with_stickslip(1e-12)(starts)
    some = np.random.default_rng(1).permutation(len(starts))
    sizes = {"stickslip": len(starts), "heyoka": len(starts), "scipy": 150}
    rows = []
    for tool, size in sizes.items():
        make = getattr(module, f"with_{tool}")
        stated, run = timed(lambda: make(1e-8))
        chosen = some[:size]
        seconds, answer = timed(lambda: run(starts[chosen]))
        for _ in range(rounds if tool != "scipy" else 0):
            seconds = min(seconds, timed(lambda: run(starts[chosen]))[0])
        wrong = float((answer != wanted[chosen]).mean())
        scaled = seconds * len(starts) / size
        rows.append(("basin", tool, 1e-8, stated, scaled, wrong, lines(make)))
    return rows


def compared(rows):
    """The rows with the time at equal error, and how many times as long that is as ours."""
    names = dict.fromkeys(row[0] for row in rows)
    for name in names:
        of = {tool: [row for row in rows if row[:2] == (name, tool)] for tool in TOOLS}
        if name == "basin":
            equal = {tool: (some[0][4], some[0][5]) for tool, some in of.items() if some}
        else:
            curves = {tool: [(row[5], row[4]) for row in some] for tool, some in of.items()}
            equal = {
                tool: at_error(curve, TARGETS[name]) for tool, curve in curves.items() if curve
            }
        for tool, (seconds, wrong) in equal.items():
            ratio = seconds / equal["stickslip"][0]
            print(
                f"{name:8} {tool:10} {1e3 * seconds:12.3f} ms at an error of {wrong:8.1e}, "
                f"{ratio:8.3g} times ours; {of[tool][0][6]} lines"
            )
            for row in of[tool]:
                yield (*row, seconds, wrong, ratio)


HEADING = (
    "problem tool rtol seconds_to_state seconds error lines "
    "seconds_at_equal_error that_error over_stickslip"
)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("table")
    parser.add_argument(
        "problems", nargs="*", default=["belt", "impact", "buck", "diagram", "basin"]
    )
    parser.add_argument("--rounds", type=int, default=7)
    wanted = parser.parse_args()
    rows = []
    for name in wanted.problems:
        rows += basins(wanted.rounds) if name == "basin" else orbits(name, wanted.rounds)
    rows = list(compared(rows))
    with open(f"{wanted.table}.part", "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(HEADING.split())
        for row in rows:
            writer.writerow(f"{one:.4g}" if isinstance(one, float) else one for one in row)
    os.replace(f"{wanted.table}.part", wanted.table)
    print(f"wrote {wanted.table}")


if __name__ == "__main__":
    main()
