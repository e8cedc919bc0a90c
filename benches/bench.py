"""This project beside other tools. Each command writes a table of report/.

    python benches/bench.py orbits EXAMPLE [--rounds N] [PROBLEM ...]          bench.csv, bench.txt
    python benches/bench.py python [--rounds N] [PROBLEM ...]                  python.csv
    python benches/bench.py basins PROGRAM EXAMPLE [--points N]                basins.csv
    python benches/bench.py spectra PROGRAM [--rounds N] [--points N]          spectra.csv
    python benches/bench.py pages                          docs/speed.md and README.md anew
    python benches/bench.py one PROBLEM SOLVER SETTING TOLERANCE
                                                  events of a problem, as a whole process is timed

EXAMPLE is the root's example `bench` for the orbits, and the library's example `basin` for the
basins; PROGRAM is `stickslip`. `--out FOLDER` writes elsewhere than into report/.

A run is made twice before it is timed. What the first one takes longer is added to its time to
compile. Then all take turns in rounds, on one thread each. A time is the mean over as many calls as
take SAMPLE_TIME; a table has the median of the rounds.
"""

import argparse
import csv
import importlib
import inspect
import io
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import tokenize
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[threads] = "1"

import tables

REFERENCES = tables.ROOT / "data/references"
# A solver that takes longer than this, in seconds, to compile and run once has failed.
TIME_LIMIT = 60
# That is thousands of times the clock's resolution.
SAMPLE_TIME = 5e-3
# A run that takes longer than this is timed once.
SLOW = 1.0
# Modules of the solvers of orbits, by the first word of their names.
SOLVERS = {
    "stickslip": "with_stickslip",
    "SciPy": "with_scipy",
    "numba": "with_numba",
    "heyoka": "with_heyoka",
    "pydiffsol": "with_diffsol",
}
# Problems of which whole processes are timed.
PROCESS_PROBLEMS = ("belt_sensitive", "bracket")


class Mismatch(Exception):
    """An answer that is of another kind than the reference."""


def seconds(call, batch):
    """Time of a call (s): the mean over as many as take `batch`."""
    count, begin = 0, time.perf_counter()
    while True:
        call()
        count += 1
        spent = time.perf_counter() - begin
        if spent >= batch:
            return spent / count


def late(_signal, _frame):
    raise TimeoutError(f"not done after {TIME_LIMIT} s")


def prepared(row, build, error):
    """Completes a row by two runs, and returns the call to time; None if it fails or is slow.

    `build` returns the call and the time to compile; `error` compares its answer.
    """
    row |= {"seconds": [], "compile_s": None, "error": None, "note": ""}
    signal.alarm(TIME_LIMIT)
    try:
        call, compiled = build()
        begin = time.perf_counter()
        answer = call()
        first = time.perf_counter() - begin
        warm = first if first > SLOW else seconds(call, 0.0)
        row |= {"compile_s": compiled + max(first - warm, 0.0), "events": len(answer)}
        row["seconds"].append(warm)
        row["error"] = error(answer)
        return call if warm <= SLOW else None
    except Mismatch as fault:
        row["note"] = f"failed: {fault}"
        return call
    # A solver that fails gets a note in its row, and the others go on.
    except Exception as failure:
        row["note"] = " ".join(f"failed: {type(failure).__name__}: {failure}".split())[:200]
        return None
    finally:
        signal.alarm(0)


def take_turns(calls, rounds, ours=lambda: None):
    """Times the calls of the rows in rounds, each of which begins with `ours`."""
    for number in range(rounds):
        ours()
        for row, call in calls:
            # The run before them all is not among the rounds.
            row["seconds"] = row["seconds"] if number else []
            row["seconds"].append(seconds(call, SAMPLE_TIME))


# --- event times of seven problems ---


def event_error(events, reference):
    """The largest error of an event time."""
    if len(events) != len(reference):
        raise Mismatch(f"{len(events)} events, the reference has {len(reference)}")
    if any(kind != wanted for (kind, _), (wanted, _) in zip(events, reference)):
        raise Mismatch("other kinds of events than the reference has")
    return max(abs(t - wanted) for (_, t), (_, wanted) in zip(events, reference))


def references(name):
    with open(REFERENCES / f"{name}.csv", encoding="utf-8") as file:
        return [(row["kind"], float(row["t"])) for row in csv.DictReader(file)]


def compiled(example, name):
    """A round of the compiled solver on a problem: its solvers, tolerances, times and events."""
    run = subprocess.run([example, name], check=True, capture_output=True, text=True)
    rows = list(csv.DictReader(run.stdout.splitlines()))
    for row in rows:
        events = [event.split("@") for event in row["events"].split(";")]
        row["events"] = [(kind, float(t)) for kind, t in events]
    return rows


def orbit_rows(example, name, problem, rounds):
    """All rows of a problem."""
    import numba

    from orbits import systems

    reference = references(name)
    common = {"problem": name, "setting": "rtol = atol", "process_s": None}
    ours = []
    for one in compiled(example, name):
        row = common | {"solver": one["solver"], "tolerance": float(one["tolerance"]), "note": ""}
        row["steps"] = int(one["steps"])
        row |= {"compile_s": 0.0, "events": len(one["events"]), "seconds": [], "error": None}
        try:
            row["error"] = event_error(one["events"], reference)
        except Mismatch as fault:
            row["note"] = f"failed: {fault}"
        ours.append(row)
    system = systems.make_compiled(problem, numba.njit)
    theirs, calls = [], []
    for module in SOLVERS.values():
        curves = importlib.import_module(f"orbits.{module}").curves(problem, system)
        for solver, setting, tolerance, build in curves:
            row = common | {"solver": solver, "setting": setting, "tolerance": tolerance}
            call = prepared(row, build, lambda events: event_error(events, reference))
            # Peers do not report accepted steps alike.
            row["steps"] = getattr(call, "steps", None)
            theirs.append(row)
            calls += [(row, call)] if call else []

    def time_ours():
        for row, one in zip(ours, compiled(example, name)):
            row["seconds"].append(float(one["seconds"]))

    take_turns(calls, rounds, time_ours)
    return ours + theirs


def time_processes(rows, example, rounds):
    """Whole processes that start, compile and solve once, with the best setting of each solver."""
    best = {}
    for row in rows:
        key = row["problem"], row["solver"]
        found = row["error"] is not None and row["problem"] in PROCESS_PROBLEMS
        if found and (key not in best or row["error"] < best[key]["error"]):
            best[key] = row
    samples = {key: [] for key in best}
    for _ in range(rounds):
        for (name, solver), row in best.items():
            setting = [] if row["compile_s"] == 0.0 else [row["setting"]]
            command = [example] if not setting else [sys.executable, __file__, "one"]
            command += [name, solver, *setting, repr(row["tolerance"])]
            begin = time.perf_counter()
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            samples[name, solver].append(time.perf_counter() - begin)
    for key, row in best.items():
        row["process_s"] = statistics.median(samples[key]) if samples[key] else None


def orbits(wanted):
    from orbits import systems

    rows, all_problems = [], systems.load(REFERENCES / "problems.json")
    for name in wanted.problems or all_problems:
        print(f"measuring {name}", file=sys.stderr)
        rows += orbit_rows(wanted.example, name, all_problems[name], wanted.rounds)
    time_processes(rows, wanted.example, min(wanted.rounds, 5))
    for row in rows:
        times = row["seconds"]
        row["median_s"] = statistics.median(times) if times else None
        row["min_s"] = min(times, default=None)
        both = row["median_s"] and row["steps"]
        row["step_ns"] = 1e9 * row["median_s"] / row["steps"] if both else None
    columns = "solver problem setting tolerance error events "
    columns += "median_s min_s compile_s process_s steps step_ns note"
    tables.write(wanted.out / "bench.csv", columns.split(), rows)
    versions = [
        pair
        for module in SOLVERS.values()
        for pair in importlib.import_module(f"orbits.{module}").VERSIONS
    ]
    (_, own), *peers = versions
    beside = ", ".join(f"{package} {number}" for package, number in peers)
    head = f"stickslip {own} beside {beside}; medians of {wanted.rounds} alternating rounds"
    text = tables.report(tables.read(wanted.out / "bench.csv"), head)
    tables.write_text(wanted.out / "bench.txt", text)


def one(wanted):
    """Imports only what its solver needs."""
    from orbits import systems

    module = importlib.import_module(f"orbits.{SOLVERS[wanted.solver.split()[0]]}")
    problem = systems.load(REFERENCES / "problems.json")[wanted.problem]
    key = wanted.solver, wanted.setting, wanted.tolerance
    for *settings, build in module.curves(problem, systems.make(problem)):
        if tuple(settings) == key:
            call, _ = build()
            print("".join(f"{kind},{t!r}\n" for kind, t in call()), end="")
            return
    sys.exit(f"error: {wanted.solver} has no setting '{wanted.setting}', {wanted.tolerance}")


# --- seven problems as a user of Python states them ---

TOOLS = ("stickslip", "scipy", "heyoka", "diffsol", "siconos")
TOLERANCES = (1e-5, 1e-7, 1e-9, 1e-11, 1e-13)
# Error at which times are compared.
TARGETS = {"belt": 1e-10, "impact": 1e-10, "table": 1e-9, "buck": 1e-10, "diagram": 1e-5}
# Ensembles: the tolerance, and of how many orbits SciPy does a sample. Its time is scaled to all.
ENSEMBLES = {"basin": (1e-8, 150), "valve": (1e-10, 24)}


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


def largest(found, wanted):
    """The largest difference."""
    if found.shape != wanted.shape:
        raise Mismatch(f"an answer of shape {found.shape} for {wanted.shape}")
    return float(abs(found - wanted).max())


def stated(make, *arguments):
    """A call, and the time to state and compile its problem."""
    begin = time.perf_counter()
    run = make(*arguments)
    return run, time.perf_counter() - begin


def python_rows(name, rounds):
    """The rows of a problem.

    A module has a function `with_TOOL(tol)` for each tool, which states the problem and returns a
    function that solves it. A tool whose setting is another has `tolerances` of its own. The error
    of an ensemble is the part of the starts with another answer.
    """
    import numpy as np

    module = importlib.import_module(f"problems.{name}")
    rows, calls = [], []
    tolerances, sampled = TOLERANCES, None
    if name in ENSEMBLES:
        tolerance, sampled = ENSEMBLES[name]
        tolerances = (tolerance,)
        starts = module.starts()
        right = module.with_stickslip(1e-12)(starts)
        order = np.random.default_rng(1).permutation(len(starts))
    else:
        right = module.reference()
    for tool in TOOLS:
        make = getattr(module, f"with_{tool}", None)
        for tol in getattr(make, "tolerances", tolerances) if make else ():
            row = {"problem": name, "tool": tool, "rtol": tol, "lines": lines(make), "scale": 1.0}
            if sampled:
                some = order[: sampled if tool == "scipy" else None]
                row["scale"] = len(starts) / len(some)

                def build(make=make, tol=tol, some=some):
                    run, spent = stated(make, tol)
                    return lambda: run(starts[some]), spent

                other = lambda found, some=some: module.is_other(found, right[some]).mean()
                call = prepared(row, build, lambda found: float(other(found)))
            else:
                build = lambda make=make, tol=tol: stated(make, tol)
                call = prepared(row, build, lambda found: largest(found, right))
            if row["note"]:
                print(f"{name}: {tool} at {tol:g}: {row['note']}", file=sys.stderr)
            rows.append(row)
            calls += [(row, call)] if call else []
    take_turns(calls, rounds)
    return [row for row in rows if row["error"] is not None]


def compare(rows):
    """Adds the time at equal error, and how many times as long that is as ours."""
    for row in rows:
        row["seconds"] = statistics.median(row["seconds"]) * row["scale"]
        row["seconds_to_state"] = row["compile_s"]
    for name in dict.fromkeys(row["problem"] for row in rows):
        equal = {}
        for tool in TOOLS:
            of = [row for row in rows if (row["problem"], row["tool"]) == (name, tool)]
            curve = tables.front((row["seconds"], row["error"]) for row in of)
            if curve:
                # The error of an ensemble is no number to compare at.
                error = max(TARGETS.get(name, 0.0), curve[-1][1])
                equal[tool] = tables.time_for(curve, error), error
        for row in rows:
            if row["problem"] == name:
                row["seconds_at_equal_error"], row["that_error"] = equal[row["tool"]]
                row["over_stickslip"] = equal[row["tool"]][0] / equal["stickslip"][0]


def python(wanted):
    rows = []
    for name in wanted.problems or [*TARGETS, *ENSEMBLES]:
        print(f"measuring {name}", file=sys.stderr)
        rows += python_rows(name, wanted.rounds)
    compare(rows)
    columns = "problem tool rtol seconds_to_state seconds error lines "
    columns += "seconds_at_equal_error that_error over_stickslip"
    tables.write(wanted.out / "python.csv", columns.split(), rows)


# --- starts of a basin per second ---

GRID, PROGRAM_GRID = 60, 240
MAP = ["map", "forced", "--x", "mu0=0.122:0.134", "--y", "omega=3.76:3.86"]
MAP += ["--start", "x=-0.269", "--start", "v=-1.52"]
MAP += ["--grid", "12x9", "--until", "400", "--duration", "60"]


def by_program(program):
    """Points per second, and the share of the fixed point. With so many starts, its own start and
    its files are negligible."""
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "basin", "basins", "--grid", f"{PROGRAM_GRID}x{PROGRAM_GRID}"]
        command += ["--tol", "1e-8", "--threads", "1", "--out", folder]
        begin = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        elapsed = time.perf_counter() - begin
        with open(f"{folder}/attractors.csv", encoding="utf-8") as table:
            rows = [row for row in csv.DictReader(table) if row["motion"] == "equilibrium"]
    return PROGRAM_GRID * PROGRAM_GRID / elapsed, sum(float(row["share"]) for row in rows)


def by_library(example):
    """Points per second, and the share of the fixed point."""
    call = lambda: subprocess.run([example], check=True, capture_output=True, text=True)
    # A run is short, so that the median of some runs is taken.
    times = [seconds(call, 0.0) for _ in range(9)]
    found = call().stdout.splitlines()
    shares = [float(line.split()[0]) for line in found if line.endswith(": equilibrium")]
    return GRID * GRID / statistics.median(times), sum(shares)


def basins(wanted):
    """Each tool does a sample of the starts, drawn from a fixed seed."""
    import numpy as np

    from problems import basin

    starts = basin.starts()
    order = np.random.default_rng(16).permutation(len(starts))
    found = {
        "stickslip compiled": by_library(wanted.example),
        "stickslip from a file": by_program(wanted.program),
    }
    tools = {"stickslip from Python": (basin.with_stickslip, len(starts))}
    tools["heyoka"] = basin.with_heyoka, 100 * wanted.points
    for method in ("RK45", "DOP853", "LSODA"):
        make = lambda tol, method=method: basin.with_scipy(tol, method)
        tools[f"SciPy {method}"] = make, wanted.points
    for name, (make, points) in tools.items():
        run, some = make(1e-8), starts[order[:points]]
        begin = time.perf_counter()
        rests = run(some)
        found[name] = len(some) / (time.perf_counter() - begin), float(rests.mean())
    both = [found["stickslip compiled"][0], found["stickslip from a file"][0]]
    rows = []
    for name, (rate, share) in found.items():
        print(f"{name:23s}{rate:9.1f} points/s  share of the fixed point {share:.3f}")
        rows.append([name, rate, f"{share:.3f}", both[0] / rate, both[1] / rate])
    columns = "solver points_per_second share_of_fixed_point compiled_over_it file_over_it".split()
    with tempfile.TemporaryDirectory() as folder:
        command = [wanted.program, *MAP, "--threads", "1", "--out", folder]
        spent = seconds(lambda: subprocess.run(command, check=True, capture_output=True), 0.0)
        cells = len(Path(folder, "map.csv").read_text(encoding="utf-8").splitlines()) - 1
    print(f"{'stickslip map':23s}{cells / spent:9.1f} cells/s, attractor and exponent of each")
    tables.write(wanted.out / "basins.csv", columns, [dict(zip(columns, row)) for row in rows])


def spectra(wanted):
    import spectra

    spectra.measure_all(wanted.program, wanted.points, wanted.rounds, wanted.out / "spectra.csv")


def pages(_wanted):
    for path, text in tables.pages().items():
        tables.write_text(tables.ROOT / path, text)


def main():
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    commands = parser.add_subparsers(required=True)

    def command(function, *positional, rounds=None, points=None, problems=False):
        own = commands.add_parser(function.__name__)
        own.set_defaults(run=function)
        own.add_argument("--out", type=Path, default=tables.REPORT)
        for name in positional:
            own.add_argument(name, type=float if name == "tolerance" else str)
        if rounds:
            own.add_argument("--rounds", type=int, default=rounds)
        if points:
            own.add_argument("--points", type=int, default=points)
        if problems:
            own.add_argument("problems", nargs="*")

    command(orbits, "example", rounds=21, problems=True)
    command(python, rounds=7, problems=True)
    command(basins, "program", "example", points=100)
    command(spectra, "program", rounds=3, points=5000)
    command(pages)
    command(one, "problem", "solver", "setting", "tolerance")
    wanted = parser.parse_args()
    signal.signal(signal.SIGALRM, late)
    wanted.out.mkdir(parents=True, exist_ok=True)
    wanted.run(wanted)


if __name__ == "__main__":
    main()
