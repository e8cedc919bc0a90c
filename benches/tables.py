"""Tables of report/, times at equal error, and what the pages say of them.

Only the standard library is needed here.
"""

import csv
import math
import os
import platform
import re
import statistics
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
REPORT = ROOT / "report"
# Errors below this count as equal: the rounding of the times themselves.
LEAST_ERROR = 1e-16
# The error at which solvers are compared, if they reach it: near rounding, where they differ most.
COMPARED_ERROR = 1e-12
# Flows of the relief valve, and returns of the orbit at each.
VALVE_ORBITS, VALVE_RETURNS = 3072, 64
# Our solver in the pages. Peers are compared with it.
OURS = "stickslip Taylor"

# The tolerance at which steps are timed.
STEPS_AT = 1e-12

# Counts in sentences.
NUMBERS = ("none", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")


def read(name):
    """The rows of a table of report/, or of a path."""
    with open(REPORT / name, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def cell(value):
    """A number to four digits; empty for NaN and for None."""
    if value is None or isinstance(value, float) and math.isnan(value):
        return ""
    return f"{value:.3e}" if isinstance(value, float) else value


def write_text(path, text):
    """Writes a file, whole or not at all."""
    beside = f"{path}.part"
    with open(beside, "w", encoding="utf-8", newline="") as file:
        file.write(text)
    os.replace(beside, path)
    print(f"wrote {path}")


def machine():
    """The processor and its number of cores, as columns of a table of times."""
    name = platform.processor() or platform.machine()
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
        name = re.search(r"^model name\s*:\s*(.+)$", text, re.MULTILINE)[1]
    except (OSError, TypeError):
        # Elsewhere the platform's own name does.
        pass
    return {"processor": name, "cores": os.cpu_count()}


def write(path, columns, rows):
    """Writes rows of times as CSV, with the machine in each, whole or not at all."""
    of = machine()
    columns, rows = [*columns, *of], [row | of for row in rows]
    beside = f"{path}.part"
    with open(beside, "w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, columns, lineterminator="\n", extrasaction="ignore")
        table.writeheader()
        table.writerows({key: cell(value) for key, value in row.items()} for row in rows)
    os.replace(beside, path)
    print(f"wrote {path}")


def front(points):
    """The points (time, error) at which neither can be improved without the other.

    Time rises and the error falls.
    """
    found = []
    for time, error in sorted((time, max(error, LEAST_ERROR)) for time, error in points):
        if not found or error < found[-1][1]:
            found.append((time, error))
    return found


def time_for(points, error):
    """The time for an error along a front, by a line through the logarithms.

    None if it is out of reach.
    """
    at = next((i for i, point in enumerate(points) if point[1] <= error), None)
    if at is None:
        return None
    slower, better = points[at]
    if at == 0 or better == error:
        return slower
    faster, worse = points[at - 1]
    part = math.log(error / worse) / math.log(better / worse)
    return faster * (slower / faster) ** part


def fronts(rows):
    """The front of each problem and solver, from rows of report/bench.csv, in their order."""
    points = {}
    for row in rows:
        of = points.setdefault((row["problem"], row["solver"]), [])
        if row["median_s"] and row["error"]:
            of.append((float(row["median_s"]), float(row["error"])))
    return {key: front(of) for key, of in points.items()}


def ratios(rows, ours=OURS):
    """Times of peers beside one of our solvers: problem, peer, error, their time, our time.

    The error is the one that all are compared at, or the peer's least if that is larger. Our time
    is None if we do not reach it.
    """
    every = fronts(rows)
    for (problem, peer), theirs in every.items():
        if theirs and not peer.startswith("stickslip"):
            error = max(theirs[-1][1], COMPARED_ERROR)
            own = time_for(every.get((problem, ours), []), error)
            yield problem, peer, error, time_for(theirs, error), own


def duration(seconds):
    """A time to three digits in a suitable unit."""
    value, unit = next(
        (seconds * scale, unit)
        for limit, scale, unit in ((1e-3, 1e6, "µs"), (1.0, 1e3, "ms"), (math.inf, 1.0, "s"))
        if seconds < limit
    )
    return f"{value:.{2 if value < 10 else 1 if value < 100 else 0}f} {unit}"


def quotients(rows, ours=OURS):
    """Quotients for each peer: (their time over ours, problem, their time), least first."""
    found = {}
    for problem, peer, _, theirs, own in ratios(rows, ours):
        if own:
            found.setdefault(peer, []).append((theirs / own, problem, theirs))
    return {peer: sorted(of) for peer, of in found.items()}


def of_peers(rows):
    """docs/speed.md: a line for each peer, least and most over the problems."""
    lines = [
        f"| time for an error of {COMPARED_ERROR:.0e} (or the peer's least), over that of `{OURS}` "
        "| least | most | on |",
        "|---|--:|--:|---|",
    ]
    for peer, of in quotients(rows).items():
        (least, problem, time), (most, _, _) = of[0], of[-1]
        on = f"least on {problem} ({duration(time)} there)"
        lines.append(f"| {peer} | {least:.1f} | {most:.1f} | {on} |")
    return "\n".join(lines)


def of_heyoka(rows):
    """README.md, joss/paper.md: heyoka over the compiled system."""
    of = quotients(rows)["heyoka"]
    return (
        f"At an error of {COMPARED_ERROR:.0e}, heyoka takes {of[0][0]:.1f} to {of[-1][0]:.1f} "
        f"times as long as a compiled system on {NUMBERS[len(of)]} problems."
    )


def of_formulas(rows):
    """docs/speed.md: the system from formulas over the compiled one, heyoka over formulas."""
    formulas = "stickslip formulas"
    every = fronts(rows)
    over_compiled = [
        time_for(points, COMPARED_ERROR) / time_for(every[problem, OURS], COMPARED_ERROR)
        for (problem, solver), points in every.items()
        if solver == formulas
    ]
    heyoka = quotients(rows, formulas)["heyoka"]
    (least, where_least, _), (most, where_most, _) = heyoka[0], heyoka[-1]
    faster = sum(quotient < 1 for quotient, _, _ in heyoka)
    compilation = [float(row["compile_s"]) for row in rows if row["solver"] == "heyoka"]
    return (
        f"At an error of {COMPARED_ERROR:.0e} it takes {min(over_compiled):.1f} to "
        f"{max(over_compiled):.1f} times as long as the compiled system. heyoka takes {least:.2f} "
        f"(`{where_least}`) to {most:.2f} (`{where_most}`) times as long as the system from "
        f"formulas. It is faster on {NUMBERS[faster]} of {NUMBERS[len(heyoka)]} problems. Its "
        f"compilation of a problem, {1e3 * min(compilation):.0f} to "
        f"{1e3 * max(compilation):.0f} ms, is not in these times."
    )


def of_steps(rows):
    """docs/speed.md: time of a step of a compiled system, and the machine."""
    found = sorted(
        (float(row["step_ns"]), row["problem"])
        for row in rows
        if row["solver"] == OURS and float(row["tolerance"]) == STEPS_AT and row["step_ns"]
    )
    (least, where_least), (most, where_most) = found[0], found[-1]
    name, cores = rows[0]["processor"], rows[0]["cores"]
    return (
        f"At a tolerance of {STEPS_AT:.0e} a step of a compiled system takes "
        f"{duration(1e-9 * least)} (`{where_least}`) to {duration(1e-9 * most)} (`{where_most}`), "
        f"with all that the run does between its steps. One of {cores} cores of an {name} did it."
    )


# What a user states once and runs once; the others are ensembles of orbits.
SINGLE_ORBITS = ("belt", "impact", "buck")


def of_readme(rows):
    """README.md: heyoka over the compiled system, and over the Python package on single orbits."""
    over = [
        float(row["over_stickslip"])
        for row in read("python.csv")
        if row["tool"] == "heyoka" and row["problem"] in SINGLE_ORBITS
    ]
    return (
        f"{of_heyoka(rows)} On single orbits from Python, it takes {min(over):.2f} to "
        f"{max(over):.2f} times as long as `stickslip`. [Speed](docs/speed.md) has all the times."
    )


def beside_python(rows):
    """docs/speed.md: what is behind the table of Python packages."""
    heyoka = {row["problem"]: row for row in rows if row["tool"] == "heyoka"}
    compiled = [float(heyoka[problem]["seconds_to_state"]) for problem in SINGLE_ORBITS]
    ours = [
        float(row["seconds_at_equal_error"])
        for row in rows
        if row["tool"] == "stickslip" and row["problem"] in SINGLE_ORBITS
    ]
    siconos = [row for row in rows if row["tool"] == "siconos"][-1]
    missed = sum(float(row["over_stickslip"]) < 1 for row in heyoka.values())
    lines = [int(row["lines"]) for row in rows if row["tool"] == "stickslip"]
    elsewhere = [int(row["lines"]) for row in rows if row["tool"] != "stickslip"]
    return (
        "heyoka is faster on single orbits once its compiled code exists. Stating a problem takes "
        f"it at least {duration(min(compiled))}, which is not in these times. A single orbit "
        f"here takes {duration(min(ours))} to {duration(max(ours))}. The aim was to be ahead of it "
        f"on each problem, which is missed on {NUMBERS[missed]}. The user's code is "
        f"{min(lines)} to {max(lines)} lines here, {min(elsewhere)} to {max(elsewhere)} elsewhere. "
        "Siconos steps in time: its row is at its own least error, "
        f"{float(siconos['that_error']):.0e}, by steps of {float(siconos['rtol']):.0e}."
    )


def from_python(rows):
    """docs/speed.md: times of the Python packages at equal error over that of ours."""
    names = {
        "belt": "belt oscillator",
        "impact": "impact oscillator",
        "table": "ball on a shaken table, 100 periods",
        "buck": "buck converter",
        "diagram": "bifurcation diagram",
        "basin": "basin of 200 × 200 starts",
        "valve": "relief valve with impacts, 3072 flows",
    }
    peers = {"scipy": "SciPy", "heyoka": "heyoka", "diffsol": "pydiffsol", "siconos": "Siconos"}
    over = {(row["problem"], row["tool"]): row["over_stickslip"] for row in rows}

    def shown(problem, peer):
        value = float(over.get((problem, peer), "nan"))
        digits = 2 if value < 2 else 1 if value < 10 else 0
        return "–" if math.isnan(value) else f"{value:.{digits}f}"

    lines = [
        f"| time over that of `stickslip` | {' | '.join(peers.values())} |",
        "|---|" + "--:|" * len(peers),
    ]
    for problem, name in names.items():
        lines.append(f"| {name} | {' | '.join(shown(problem, peer) for peer in peers)} |")
    return "\n".join(lines)


def of_valve(rows):
    """docs/speed.md: orbits and returns of the relief valve per second and core."""
    seconds = {row["tool"]: float(row["seconds"]) for row in rows if row["problem"] == "valve"}
    errors = {row["tool"]: float(row["error"]) for row in rows if row["problem"] == "valve"}
    rates = {tool: VALVE_ORBITS / spent for tool, spent in seconds.items()}
    return (
        f"On the valve, `ensemble` computes {rates['stickslip']:.0f} orbits a second and core at "
        f"1e-10: {rates['stickslip'] * VALVE_RETURNS:.0f} returns. heyoka computes "
        f"{rates['heyoka']:.0f} orbits, SciPy {rates['scipy']:.1f}. Orbits at some flows are chaotic: "
        "openings differ from those at 1e-12 by more than 1e-6 at "
        f"{100 * errors['stickslip']:.1f} % of the flows by `ensemble`, and at "
        f"{100 * errors['heyoka']:.1f} % by heyoka."
    )


def of_spectra(rows):
    """docs/speed.md: `stickslip spectrum` beside nolds and neurokit2."""
    ours, given = "spectrum", "spectrum, embedding given"
    # Packages that give a spectrum, and the fastest that give one exponent. The second of these
    # gets a straight part chosen in advance.
    spectra = ("nolds lyap_e", "neurokit2 eckmann1986")
    quick = ("neurokit2 makowski", "neurokit2 rosenstein1993, straight part")
    by = {(row["estimator"], row["series"]): row for row in rows}
    names = list(dict.fromkeys(row["series"] for row in rows))
    every = dict.fromkeys(row["estimator"] for row in rows)
    peers = [one for one in every if one not in (ours, given)]

    def number(estimator, name, column):
        return float(by[estimator, name][column])

    def less(one, other, column):
        return sum(number(one, name, column) < number(other, name, column) for name in names)

    others = [less(ours, peer, "error") for peer in peers if peer not in spectra]
    all_given = [less(given, peer, "error") for peer in peers]
    faster = sorted(
        min(number(peer, name, "seconds") for peer in spectra) / number(ours, name, "seconds")
        for name in names
    )
    quicker = [less(peer, ours, "seconds") for peer in quick]
    starved = sum(by[ours, name]["status"] == "starved" for name in names)
    return (
        "The error of the first exponent is smaller than that of nolds `lyap_e` on "
        f"{less(ours, spectra[0], 'error')} series and of neurokit2 `eckmann1986` on "
        f"{less(ours, spectra[1], 'error')}, the two that give a spectrum. It is smaller than "
        f"those of the others on {min(others)} to {max(others)}. With the embedding that the packages "
        f"are given, it is smaller than those of all on {min(all_given)} to {max(all_given)}. The "
        f"faster spectrum takes {statistics.median(faster):.0f} times the time of the processor "
        f"(median; {faster[0]:.0f} to {faster[-1]:.0f}), 20 times or more on "
        f"{sum(one >= 20 for one in faster)} of the {len(names)}. neurokit2's `makowski`, which "
        f"gives one exponent, is faster than `spectrum` on {quicker[0]}. Its fit of a straight "
        f"part that is given is faster on {quicker[1]}. On {starved} of the {len(names)} `spectrum` "
        "itself calls its first exponent `starved`: 5000 values of one column are few."
    )


def wrapped(text, width=100):
    """Lines of at most `width` columns. Code in backticks is not divided."""
    lines = [""]
    for word in re.findall(r"(?:`[^`]*`|\S)+", text):
        if len(lines[-1]) + 1 + len(word) > width:
            lines.append("")
        lines[-1] += (" " if lines[-1] else "") + word
    return "\n".join(lines)


# The generated parts of the pages: page, name, table, what it says.
PARTS = (
    ("README.md", "speed", "bench.csv", lambda rows: wrapped(of_readme(rows))),
    ("joss/paper.md", "speed", "bench.csv", lambda rows: wrapped(of_heyoka(rows))),
    ("docs/speed.md", "peers", "bench.csv", of_peers),
    ("docs/speed.md", "formulas", "bench.csv", lambda rows: wrapped(of_formulas(rows))),
    ("docs/speed.md", "steps", "bench.csv", lambda rows: wrapped(of_steps(rows))),
    ("docs/speed.md", "python", "python.csv", from_python),
    ("docs/speed.md", "heyoka", "python.csv", lambda rows: wrapped(beside_python(rows))),
    ("docs/speed.md", "valve", "python.csv", lambda rows: wrapped(of_valve(rows))),
    ("docs/speed.md", "spectra", "spectra.csv", lambda rows: wrapped(of_spectra(rows))),
)


def replaced(page, name, part):
    """A page with a part between its marks."""
    begin, end = f"<!-- {name}: written by `make bench-pages` -->\n", f"<!-- end of {name} -->\n"
    before, found, rest = page.partition(begin)
    _, closed, after = rest.partition(end)
    if not (found and closed):
        raise ValueError(f"the page has no marks {begin.strip()} and {end.strip()}")
    return f"{before}{begin}\n{part}\n\n{end}{after}"


def pages():
    """The pages as the committed tables say: path and text."""
    texts = {}
    for path, name, table, says in PARTS:
        text = texts.get(path) or (ROOT / path).read_text(encoding="utf-8")
        texts[path] = replaced(text, name, says(read(table)))
    return texts


def most_accurate(rows):
    """The row with the least error of each problem and solver that finds the events."""
    best = {}
    for row in rows:
        key = row["problem"], row["solver"]
        if row["error"] and (key not in best or float(row["error"]) < float(best[key]["error"])):
            best[key] = row
    return list(best.values())


def report(rows, head):
    """report/bench.txt from rows of report/bench.csv."""
    about = "error of event times, time of a run (median), compilation, whole process"
    lines = [head, "", f"Most accurate setting of every solver: {about}"]
    for row in most_accurate(rows):
        times = [row[name] for name in ("median_s", "compile_s", "process_s")]
        times = " ".join(f"{duration(float(one)) if one else '-':>10}" for one in times)
        lines.append(f"  {row['problem']:15} {row['solver']:22} {float(row['error']):8.1e} {times}")
    noted = [row for row in rows if row["note"]]
    lines += [f"  {row['problem']:15} {row['solver']:22} {row['note']}" for row in noted]
    lines.append("")
    at = f"{COMPARED_ERROR:.0e} or the peer's least if that is larger"
    lines.append(f"Times at equal error, {at}")
    solvers = dict.fromkeys(row["solver"] for row in rows)
    own = [solver for solver in solvers if solver.startswith("stickslip")]
    for solver in own:
        for problem, peer, error, theirs, ours in ratios(rows, solver):
            ratio = f"{duration(ours):>10} {theirs / ours:10.1f}" if ours else f"{'never':>10}"
            of_peer = f"{peer:22} {error:8.1e} {duration(theirs):>10}"
            lines.append(f"  {problem:15} {of_peer} {ratio}  ({solver})")
    return "\n".join(lines) + "\n"
