"""Lyapunov exponents of ten series of one column: `stickslip spectrum` beside nolds and neurokit2, error and time.

    python spectra.py PROGRAM [--points N] [--rounds N] [--csv FILE]

All read the same numbers. `spectrum` chooses delay and dimension itself; the packages, which choose none, are given those of
`series.py`. What else they are given is what they recommend: no neighbours within one mean period; as many exponents as the
embedding has dimensions (neurokit2 takes four and no other number); trajectories of 20 points, and, since that passes the straight
part of most curves, a second time those of the straight part, which a curve of nolds itself shows and whose search is not timed.

One thread each. Times are the processor's, so that others on the machine count little: of `spectrum` for its whole process, start and
reading of the file included, of a package for its call alone; the median over rounds in which all take turns.
"""

import os

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[threads] = "1"

import argparse
import csv
import json
import math
import resource
import statistics
import subprocess
import sys
import tempfile
import warnings
from importlib import resources

import numpy as np

if sys.version_info < (3, 12):
    # nolds 0.6.3 asks for the files beside one of its modules, which older Pythons know of packages only.
    files_of_package = resources.files
    resources.files = lambda anchor: files_of_package("nolds" if anchor == "nolds.datasets" else anchor)

import neurokit2
import nolds

import series

OURS = "spectrum"
GIVEN = "spectrum, embedding given"
# The straight part of a curve of divergence: between these parts of its whole rise.
STRAIGHT = (0.2, 0.7)
# Points of the curve on which it is searched, and fewest of the part.
WHOLE, FEWEST = 1000, 5
# Trajectories of both packages if nothing is said.
DEFAULT = 20
# What is asked of the program: errors smaller on so many of the ten series, and so many times faster.
SERIES, FASTER = 9, 20.0


def mean_period(x):
    """Points of a mean period: one over the mean frequency, as in both packages."""
    power, frequency = np.abs(np.fft.rfft(x)[1:]) ** 2, np.fft.rfftfreq(len(x))[1:]
    return math.ceil(power.sum() / (frequency * power).sum())


def straight_part(case, x):
    """First and last point of the straight part of the curve of divergence; none if it does not rise."""
    whole = min(WHOLE, len(x) // 5)
    _, (_, curve, _) = nolds.lyap_r(x, case.dimension, case.delay, mean_period(x), trajectory_len=whole, fit="poly", debug_data=True)
    rise = np.median(curve[len(curve) // 2 :]) - curve[0]
    first, last = (int(np.argmax(curve - curve[0] >= part * rise)) for part in STRAIGHT)
    return (first, last) if rise > 1.0 and last - first + 1 >= FEWEST else None


def by_nolds_r(case, x, part):
    settings = {"trajectory_len": DEFAULT} if part is None else {"trajectory_len": part[1] + 1, "fit_offset": part[0], "fit": "poly"}
    return [nolds.lyap_r(x, case.dimension, case.delay, mean_period(x), case.dt, **settings)]


def by_nolds_e(case, x):
    span = (case.dimension - 1) * case.delay + 1
    return nolds.lyap_e(x, span, case.dimension, min_tsep=mean_period(x), tau=case.dt)


def by_neurokit(case, x, method, **settings):
    dimension = 3 * case.delay + 1 if method == "eckmann1986" else case.dimension
    found, _ = neurokit2.complexity_lyapunov(x, delay=case.delay, dimension=dimension, method=method, **settings)
    return np.atleast_1d(found) / case.dt


def by_program(program, case, path, *options):
    """The exponents that are not the embedding's own, and what is said of the first."""
    command = [program, "spectrum", path, "--dt", repr(case.dt), "--json", *options]
    run = subprocess.run(command, check=True, capture_output=True, text=True)
    exponents = [one for one in json.loads(run.stdout)["exponents"] if one["status"] != "spurious"]
    return [math.nan if one["exponent"] is None else one["exponent"] for one in exponents], exponents[0]["status"]


def estimators(program, case, x, path):
    """Of each its name, whether it gives a spectrum, and a call that returns exponents and a word on the first."""
    part = straight_part(case, x)
    length = DEFAULT if part is None else part[1] + 1
    given = ("--dimension", str(case.dimension), "--delay", str(case.delay))

    def package(call):
        return lambda: (call(), "")

    return [
        (OURS, True, lambda: by_program(program, case, path)),
        (GIVEN, True, lambda: by_program(program, case, path, *given)),
        ("nolds lyap_r", False, package(lambda: by_nolds_r(case, x, None))),
        ("nolds lyap_r, straight part", False, package(lambda: by_nolds_r(case, x, part))),
        ("nolds lyap_e", True, package(lambda: by_nolds_e(case, x))),
        ("neurokit2 rosenstein1993", False, package(lambda: by_neurokit(case, x, "rosenstein1993"))),
        ("neurokit2 rosenstein1993, straight part", False, package(lambda: by_neurokit(case, x, "rosenstein1993", len_trajectory=length))),
        ("neurokit2 makowski", False, package(lambda: by_neurokit(case, x, "makowski"))),
        ("neurokit2 eckmann1986", True, package(lambda: by_neurokit(case, x, "eckmann1986"))),
    ]


def spent():
    """Seconds of the processor on this process and on those it ran."""
    uses = [resource.getrusage(whose) for whose in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(use.ru_utime + use.ru_stime for use in uses)


def call(estimator):
    """Exponents, the word on the first, and seconds; no exponents of one that fails."""
    np.random.seed(0)
    begin = spent()
    try:
        exponents, word = estimator()
    except Exception as error:  # What a package cannot do is its row's word, not the end of the others.
        exponents, word = [], f"failed: {type(error).__name__}: {error}"[:120]
    return [float(v) for v in exponents], word, spent() - begin


def distance(found, known):
    """Mean distance of the first exponents from the known ones; infinite where one is missing."""
    pairs = [abs(a - b) for a, b in zip(found, known)]
    complete = len(pairs) == len(known) and all(map(math.isfinite, pairs))
    return statistics.fmean(pairs) if complete else math.inf


def measure(program, case, points, rounds, folder):
    x = case.column(points)
    path = os.path.join(folder, "series.txt")
    np.savetxt(path, x, fmt="%.17g")
    every = estimators(program, case, x, path)
    times, found = {name: [] for name, _, _ in every}, {}
    for _ in range(rounds):
        for name, _, estimator in every:
            exponents, word, seconds = call(estimator)
            times[name].append(seconds)
            found[name] = (exponents, word)
    rows = []
    for name, gives_spectrum, _ in every:
        exponents, word = found[name]
        rows.append(
            {
                "series": case.name,
                "points": points,
                "dt": case.dt,
                "known": " ".join(map(repr, case.known[: case.compared])),
                "source": case.source,
                "estimator": name,
                "seconds": statistics.median(times[name]),
                "error": distance(exponents[:1], case.known[:1]),
                "spectrum_error": distance(exponents, case.known[: case.compared]) if gives_spectrum else math.nan,
                "exponents": " ".join(f"{v:.6g}" for v in exponents),
                "status": word,
            }
        )
    return rows


def show(rows):
    head = rows[0]
    print(f"{head['series']}, {head['points']} points, true {head['known']} ({head['source']})")
    for row in rows:
        print(f"  {row['estimator']:41s}{row['error']:9.4f}{row['spectrum_error']:9.4f}{row['seconds']:9.3f} s  {row['exponents']} {row['status']}")
    sys.stdout.flush()


def summary(rows):
    """The two counts that are asked for, from the rows of all series."""
    names = list(dict.fromkeys(row["series"] for row in rows))
    of = {(row["series"], row["estimator"]): row for row in rows}
    peers = [name for name in dict.fromkeys(row["estimator"] for row in rows) if name not in (OURS, GIVEN)]
    lines, fewest = [], len(names)
    for peer in peers:
        smaller = sum(of[name, OURS]["error"] < of[name, peer]["error"] for name in names)
        fewest = min(fewest, smaller)
        lines.append(f"  error of the first exponent smaller than that of {peer:41s} on {smaller} of {len(names)} series")
    best = sum(all(of[name, OURS]["error"] < of[name, peer]["error"] for peer in peers) for name in names)
    spectra = [peer for peer in peers if not math.isnan(of[names[0], peer]["spectrum_error"])]
    faster = [min(of[name, peer]["seconds"] for peer in spectra) / of[name, OURS]["seconds"] for name in names]
    closer = sum(all(of[name, OURS]["spectrum_error"] < of[name, peer]["spectrum_error"] for peer in spectra) for name in names)
    lines += [
        f"  smaller than those of all of them on {best}; error of the spectrum smaller than those of {' and '.join(spectra)} on {closer}",
        f"smaller error than each: on at least {fewest} of {len(names)} series (asked: {SERIES} of 10)",
        f"faster than the fastest that gives a spectrum: {statistics.median(faster):.0f} times (median), {min(faster):.0f} to "
        f"{max(faster):.0f}, {FASTER:.0f} times or more on {sum(f >= FASTER for f in faster)} of {len(names)} series",
    ]
    return "\n".join(lines)


def cell(value):
    """Four digits; nothing of what does not exist."""
    if not isinstance(value, float):
        return value
    return "" if math.isnan(value) else f"{value:.4g}"


def write(path, rows):
    """Whole or not at all."""
    rounded = [{key: cell(v) for key, v in row.items()} for row in rows]
    beside = f"{path}.part"
    with open(beside, "w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rounded)
    os.replace(beside, path)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("program")
    arguments.add_argument("--points", type=int, default=5000)
    arguments.add_argument("--rounds", type=int, default=3)
    arguments.add_argument("--csv", default="report/spectra.csv")
    options = arguments.parse_args()
    # Of the packages: divergence that does not rise, short series.
    warnings.simplefilter("ignore")
    print("                                            error of 1st, of all, median time, exponents")
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for case in series.CASES:
            found = measure(options.program, case, options.points, options.rounds, folder)
            show(found)
            rows += found
    print(summary(rows))
    write(options.csv, rows)


if __name__ == "__main__":
    main()
