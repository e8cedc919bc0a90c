"""Lyapunov exponents of ten series of one column: `stickslip spectrum` beside nolds and neurokit2.

Error and time. All read the same numbers. `spectrum` chooses delay and dimension itself.
The packages choose none and are given those of `series.py`. Their other settings are those that
they recommend: no neighbours within one mean period; as many exponents as the embedding has
dimensions (neurokit2 takes four and no other number); trajectories of 20 points. Such trajectories
pass the straight part of most curves, so that the packages are also given that part, which a curve
of nolds itself shows. Its search is not timed.

One thread each. Times are those of the processor, so that other processes count little: of
`spectrum` for its whole process, with its start and the reading of the file; of a package for its
call alone. They are medians over rounds in which all take turns.
"""

import json
import math
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import warnings
from importlib import resources

import numpy as np

if sys.version_info < (3, 12):
    # nolds 0.6.3 asks for the files beside one of its modules. Older Pythons have those of packages
    # only.
    files_of_package = resources.files
    resources.files = lambda anchor: files_of_package(
        "nolds" if anchor == "nolds.datasets" else anchor
    )

import neurokit2
import nolds

import series
import tables

OURS = "spectrum"
GIVEN = "spectrum, embedding given"
# The straight part of a curve of divergence lies between these fractions of its whole rise.
STRAIGHT_RISE = (0.2, 0.7)
# Points of the curve on which it is searched, and the least number of points of the part.
CURVE_POINTS, LEAST_POINTS = 1000, 5
# Length of trajectories that both packages take by default.
DEFAULT_LENGTH = 20
# Targets: errors smaller on so many of the ten series, and so many times faster.
TARGET_SERIES, TARGET_SPEED = 9, 20.0


def mean_period(x):
    """Points of a mean period: one over the mean frequency, as in both packages."""
    power, frequency = np.abs(np.fft.rfft(x)[1:]) ** 2, np.fft.rfftfreq(len(x))[1:]
    return math.ceil(power.sum() / (frequency * power).sum())


def straight_part(case, x):
    """First and last point of the straight part of the curve of divergence.

    None if the curve does not rise.
    """
    settings = {"trajectory_len": min(CURVE_POINTS, len(x) // 5), "fit": "poly", "debug_data": True}
    _, (_, curve, _) = nolds.lyap_r(x, case.dimension, case.delay, mean_period(x), **settings)
    rise = np.median(curve[len(curve) // 2 :]) - curve[0]
    first, last = (int(np.argmax(curve - curve[0] >= part * rise)) for part in STRAIGHT_RISE)
    return (first, last) if rise > 1.0 and last - first + 1 >= LEAST_POINTS else None


def by_nolds_r(case, x, part):
    settings = {"trajectory_len": DEFAULT_LENGTH}
    if part is not None:
        settings = {"trajectory_len": part[1] + 1, "fit_offset": part[0], "fit": "poly"}
    return [nolds.lyap_r(x, case.dimension, case.delay, mean_period(x), case.dt, **settings)]


def by_nolds_e(case, x):
    span = (case.dimension - 1) * case.delay + 1
    return nolds.lyap_e(x, span, case.dimension, min_tsep=mean_period(x), tau=case.dt)


def by_neurokit(case, x, method, **settings):
    dimension = 3 * case.delay + 1 if method == "eckmann1986" else case.dimension
    exponents, _ = neurokit2.complexity_lyapunov(
        x, delay=case.delay, dimension=dimension, method=method, **settings
    )
    return np.atleast_1d(exponents) / case.dt


def by_program(program, case, path, *options):
    """The exponents that are not the embedding's own, and the status of the first."""
    command = [program, "spectrum", path, "--dt", repr(case.dt), "--json", *options]
    run = subprocess.run(command, check=True, capture_output=True, text=True)
    exponents = [one for one in json.loads(run.stdout)["exponents"] if one["status"] != "spurious"]
    values = [math.nan if one["exponent"] is None else one["exponent"] for one in exponents]
    return values, exponents[0]["status"]


def estimators(program, case, x, path):
    """List each estimator: name, whether it gives a spectrum, and a call.

    The call returns the exponents and the status of the first.
    """
    part = straight_part(case, x)
    length = DEFAULT_LENGTH if part is None else part[1] + 1
    given = ("--dimension", str(case.dimension), "--delay", str(case.delay))
    rosenstein = "rosenstein1993"

    def package(call):
        return lambda: (call(), "")

    return [
        (OURS, True, lambda: by_program(program, case, path)),
        (GIVEN, True, lambda: by_program(program, case, path, *given)),
        ("nolds lyap_r", False, package(lambda: by_nolds_r(case, x, None))),
        ("nolds lyap_r, straight part", False, package(lambda: by_nolds_r(case, x, part))),
        ("nolds lyap_e", True, package(lambda: by_nolds_e(case, x))),
        (f"neurokit2 {rosenstein}", False, package(lambda: by_neurokit(case, x, rosenstein))),
        (
            f"neurokit2 {rosenstein}, straight part",
            False,
            package(lambda: by_neurokit(case, x, rosenstein, len_trajectory=length)),
        ),
        ("neurokit2 makowski", False, package(lambda: by_neurokit(case, x, "makowski"))),
        ("neurokit2 eckmann1986", True, package(lambda: by_neurokit(case, x, "eckmann1986"))),
    ]


def spent():
    """Seconds of the processor for this process and those that it ran."""
    uses = [resource.getrusage(whose) for whose in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(use.ru_utime + use.ru_stime for use in uses)


def call(estimator):
    """Exponents, the status of the first, and seconds; no exponents if it fails."""
    np.random.seed(0)
    begin = spent()
    try:
        exponents, status = estimator()
    # A package that fails has that as its status, and the others go on.
    except Exception as error:
        exponents, status = [], f"failed: {type(error).__name__}: {error}"[:120]
    return [float(v) for v in exponents], status, spent() - begin


def distance(exponents, known):
    """Mean distance of the first exponents from the true ones; infinite if one is missing."""
    distances = [abs(a - b) for a, b in zip(exponents, known)]
    complete = len(distances) == len(known) and all(map(math.isfinite, distances))
    return statistics.fmean(distances) if complete else math.inf


def measure(program, case, points, rounds, folder):
    x = case.column(points)
    path = os.path.join(folder, "series.txt")
    np.savetxt(path, x, fmt="%.17g")
    every = estimators(program, case, x, path)
    times, results = {name: [] for name, _, _ in every}, {}
    for _ in range(rounds):
        for name, _, estimator in every:
            exponents, status, seconds = call(estimator)
            times[name].append(seconds)
            results[name] = (exponents, status)
    rows = []
    for name, gives_spectrum, _ in every:
        exponents, status = results[name]
        of_all = distance(exponents, case.known[: case.compared])
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
                "spectrum_error": of_all if gives_spectrum else math.nan,
                "exponents": " ".join(f"{v:.6g}" for v in exponents),
                "status": status,
            }
        )
    return rows


def show(rows):
    head = rows[0]
    print(f"{head['series']}, {head['points']} points, true {head['known']} ({head['source']})")
    for row in rows:
        print(
            f"  {row['estimator']:41s}{row['error']:9.4f}{row['spectrum_error']:9.4f}"
            f"{row['seconds']:9.3f} s  {row['exponents']} {row['status']}"
        )
    sys.stdout.flush()


def summary(rows):
    """Tell how far the two targets are met, from the rows of all series."""
    names = list(dict.fromkeys(row["series"] for row in rows))
    of = {(row["series"], row["estimator"]): row for row in rows}
    tools = dict.fromkeys(row["estimator"] for row in rows)
    peers = [name for name in tools if name not in (OURS, GIVEN)]

    def is_smaller(name, peer, error):
        return of[name, OURS][error] < of[name, peer][error]

    lines, fewest = [], len(names)
    for peer in peers:
        smaller = sum(is_smaller(name, peer, "error") for name in names)
        fewest = min(fewest, smaller)
        lines.append(
            f"  error of the first exponent smaller than that of {peer:41s} on {smaller} of "
            f"{len(names)} series"
        )
    best = sum(all(is_smaller(name, peer, "error") for peer in peers) for name in names)
    spectra = [peer for peer in peers if not math.isnan(of[names[0], peer]["spectrum_error"])]
    faster = [
        min(of[name, peer]["seconds"] for peer in spectra) / of[name, OURS]["seconds"]
        for name in names
    ]
    closer = sum(
        all(is_smaller(name, peer, "spectrum_error") for peer in spectra) for name in names
    )
    lines += [
        f"  smaller than those of all of them on {best}; error of the spectrum smaller than those "
        f"of {' and '.join(spectra)} on {closer}",
        f"smaller error than each: on at least {fewest} of {len(names)} series "
        f"(asked: {TARGET_SERIES} of 10)",
        f"faster than the fastest that gives a spectrum: {statistics.median(faster):.0f} times "
        f"(median), {min(faster):.0f} to {max(faster):.0f}, {TARGET_SPEED:.0f} times or more on "
        f"{sum(f >= TARGET_SPEED for f in faster)} of {len(names)} series",
    ]
    return "\n".join(lines)


def measure_all(program, points, rounds, path):
    """Measures all series, reports them, and writes the table."""
    # The packages warn of divergence that does not rise and of short series.
    warnings.simplefilter("ignore")
    print(f"{'':44s}error of 1st, of all, median time, exponents")
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for case in series.CASES:
            of_case = measure(program, case, points, rounds, folder)
            show(of_case)
            rows += of_case
    print(summary(rows))
    tables.write(path, list(rows[0]), rows)
