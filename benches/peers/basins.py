"""Basin of attraction of a friction oscillator, in points per second, each on one thread.

The library, whose user writes two functions, and the program `stickslip`, which reads them from a
file, are compared with heyoka's integrator and with SciPy's solve_ivp, with events written by hand.
Also: cells per second of a map of two parameters by the program.

    python basins.py PROGRAM EXAMPLE TABLE [POINTS]

EXAMPLE is the library's example `basin`, a basin on the same starts. TABLE is the CSV file to
write. All answer the same question of each start, fixed point or stick-slip cycle, at a tolerance
of 1e-8. The peers' user knows the system: an orbit that sticks twice is on the cycle, since stick
forgets the past; one within 1e-2 of the fixed point, which attracts there, ends at it. Library and
program use neither. The peers compute a sample of the starts, drawn from a fixed seed: SciPy POINTS
of them, and heyoka a hundred times as many. heyoka's stick phase is in closed form, and its time to
compile is reported separately.
"""

import csv
import os
import subprocess
import sys
import tempfile
import time

import heyoka as hy
import numpy as np
from scipy.integrate import solve_ivp

VD, DAMPING = 1.5, 0.1
FIXED_POINT = 0.5 + 0.5 * np.exp(-2.0 * VD)
ATTRACTING_RADIUS, END_TIME, TOLERANCE = 1e-2, 2000.0, 1e-8
# A phase starts this far off the boundary, so that an event function does not see its own start.
START_OFFSET = 1e-10
GRID = 60
# The program also starts, and writes tables and a figure. With so many starts that is negligible.
PROGRAM_GRID = 240
MAP = ["map", "forced", "--x", "mu0=0.122:0.134", "--y", "omega=3.76:3.86"]
MAP += ["--start", "x=-0.269", "--start", "v=-1.52"]
MAP += ["--grid", "12x9", "--until", "400", "--duration", "60"]


def field(side):
    def slip(_t, y):
        friction = side * (0.5 + 0.5 * np.exp(-2.0 * abs(y[1] - VD)))
        return [y[1], -y[0] - DAMPING * y[1] - friction]

    return slip


def meets(_t, y):
    return y[1] - VD


def settles(_t, y):
    return np.hypot(y[0] - FIXED_POINT, y[1]) - ATTRACTING_RADIUS


def released(_t, y):
    return 1.0 - abs(y[0] + DAMPING * VD)


for event in (meets, settles, released):
    event.terminal = True
settles.direction = -1.0
released.direction = -1.0


def destination(x, v, slip, stick):
    """`rest`, `cycle` or `undecided`.

    `slip` and `stick` go from a time and state to the next event. `slip` also returns whether it
    settles on the fixed point.
    """
    t, y, sticks = 0.0, np.array([x, v]), 0
    side = 1.0 if v > VD else -1.0
    while t < END_TIME:
        t, y, settled = slip(side, t, y)
        if settled:
            return "rest"
        if t >= END_TIME:
            break
        if abs(y[0] + DAMPING * VD) < 1.0:
            sticks += 1
            if sticks == 2:
                return "cycle"
            t, y = stick(t, y)
            side = -1.0 if y[0] > 0.0 else 1.0
        else:
            side = -1.0 if y[0] + DAMPING * VD > 0.0 else 1.0
        y[1] = VD + side * START_OFFSET
    return "undecided"


def with_scipy(method):
    settings = {"method": method, "rtol": TOLERANCE, "atol": TOLERANCE}

    def ride(_t, _y):
        return [VD, 0.0]

    def slip(side, t, y):
        run = solve_ivp(field(side), (t, END_TIME), y, events=(meets, settles), **settings)
        if run.status < 0:
            raise RuntimeError(f"solve_ivp stopped: {run.message}")
        return run.t[-1], run.y[:, -1], bool(run.t_events[1].size)

    def stick(t, y):
        run = solve_ivp(ride, (t, END_TIME), [y[0], VD], events=released, **settings)
        return run.t[-1], run.y[:, -1]

    return slip, stick


def with_heyoka():
    x, v = hy.make_vars("x", "v")
    distance = (x - FIXED_POINT) ** 2 + v**2 - ATTRACTING_RADIUS**2
    near = hy.t_event(distance, direction=hy.event_direction.negative)
    integrators = {}
    for side in (1.0, -1.0):
        friction = side * (0.5 + 0.5 * hy.exp(-2.0 * side * (v - VD)))
        towards = hy.event_direction.negative if side > 0.0 else hy.event_direction.positive
        met = hy.t_event(v - VD, direction=towards)
        equations = [(x, v), (v, -x - DAMPING * v - friction)]
        integrators[side] = hy.taylor_adaptive(
            equations, [0.0, 0.0], tol=TOLERANCE, t_events=[met, near]
        )

    def slip(side, t, y):
        ta = integrators[side]
        ta.time = t
        ta.state[:] = y
        ta.reset_cooldowns()
        outcome = ta.propagate_until(END_TIME)[0]
        if outcome == hy.taylor_outcome.time_limit:
            return END_TIME, ta.state.copy(), False
        # Terminal events are numbered downwards from -1.
        if int(outcome) not in (-1, -2):
            raise RuntimeError(f"heyoka stopped with {outcome}")
        return ta.time, ta.state.copy(), int(outcome) == -2

    def stick(t, y):
        release = 1.0 - DAMPING * VD
        return t + (release - y[0]) / VD, np.array([release, VD])

    return slip, stick


def by_program(program):
    """Points per second, and the share of the fixed point."""
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "basin", "basins", "--grid", f"{PROGRAM_GRID}x{PROGRAM_GRID}"]
        command += ["--tol", str(TOLERANCE), "--threads", "1", "--out", folder]
        begin = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        elapsed = time.perf_counter() - begin
        with open(f"{folder}/attractors.csv", encoding="utf-8") as table:
            names, *rows = [line.strip().split(",") for line in table]
    share, motion = names.index("share"), names.index("motion")
    shares = [float(row[share]) for row in rows if row[motion] == "equilibrium"]
    return PROGRAM_GRID * PROGRAM_GRID / elapsed, sum(shares)


def by_library(example):
    """Points per second, and the share of the fixed point."""
    one_thread = os.environ | {"RAYON_NUM_THREADS": "1"}
    settings = {"check": True, "capture_output": True, "text": True, "env": one_thread}
    # A run is short, so that the median of some runs is taken.
    times = []
    for _ in range(9):
        begin = time.perf_counter()
        run = subprocess.run([example], **settings)
        times.append(time.perf_counter() - begin)
    lines = run.stdout.splitlines()
    shares = [float(line.split()[0]) for line in lines if line.endswith(": equilibrium")]
    return GRID * GRID / sorted(times)[len(times) // 2], sum(shares)


def by_peer(slip, stick, points):
    random = np.random.default_rng(16)
    starts = np.column_stack([random.uniform(-2.0, 2.0, points), random.uniform(0.0, 2.0, points)])
    begin = time.perf_counter()
    ends = [destination(x, v, slip, stick) for x, v in starts]
    elapsed = time.perf_counter() - begin
    return points / elapsed, ends.count("rest") / points, ends.count("undecided")


def peer_row(name, points, peer, ours):
    """Measures a peer, prints its rate, and returns its row of the table."""
    rate, share, undecided = by_peer(*peer, points)
    error = np.sqrt(share * (1.0 - share) / points)
    compiled, file = (one / rate for one in ours)
    print(
        f"{name:23s}{rate:9.1f} points/s  share {share:.3f} +- {error:.3f}, {undecided} undecided: "
        f"stickslip does {compiled:.2f} times as many compiled, {file:.2f} from a file"
    )
    return [name, f"{rate:.4g}", f"{share:.3f}", f"{compiled:.3g}", f"{file:.3g}"]


def cells(program):
    """Cells of a map per second."""
    with tempfile.TemporaryDirectory() as folder:
        begin = time.perf_counter()
        command = [program, *MAP, "--threads", "1", "--out", folder]
        subprocess.run(command, check=True, capture_output=True)
        elapsed = time.perf_counter() - begin
        with open(f"{folder}/map.csv", encoding="utf-8") as table:
            number = sum(1 for _ in table) - 1
    return number / elapsed


def main():
    program, example, table = sys.argv[1:4]
    points = int(sys.argv[4]) if len(sys.argv) > 4 else 100
    head = "solver points_per_second share_of_fixed_point compiled_over_it file_over_it"
    ours, rows = [], [head.split()]
    both = (("compiled", by_library(example)), ("from a file", by_program(program)))
    for name, (rate, share) in both:
        ours.append(rate)
        print(f"stickslip, {name:12s}{rate:9.1f} points/s  share of the fixed point {share:.3f}")
        ratio = f"{ours[0] / rate:.3g}"
        rows.append([f"stickslip {name}", f"{rate:.4g}", f"{share:.3f}", ratio, ""])
    rows[-1][-1] = "1"
    begin = time.perf_counter()
    heyoka = with_heyoka()
    compiled = time.perf_counter() - begin
    rows.append(peer_row("heyoka", 100 * points, heyoka, ours))
    print(f"                       {compiled:9.1f} s to compile its functions")
    for method in ("RK45", "DOP853", "LSODA"):
        rows.append(peer_row(f"SciPy {method}", points, with_scipy(method), ours))
    rate = cells(program)
    print(f"{'stickslip map':23s}{rate:9.1f} cells/s on one thread, attractor and exponent of each")
    with open(f"{table}.part", "w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)
    os.replace(f"{table}.part", table)
    print(f"wrote {table}")


if __name__ == "__main__":
    main()
