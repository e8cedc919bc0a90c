"""Basin of attraction of P16, points per second: the program `stickslip` on one thread beside SciPy's solve_ivp with events written by hand.

    python basins.py PROGRAM [POINTS]

Both answer the same question of each start, fixed point or stick-slip cycle, at a tolerance of 1e-8. SciPy's user knows the system: an orbit
that sticks twice is on the cycle, for stick forgets all; one within 1e-2 of the fixed point, which attracts there, has come to it. The program
knows neither. SciPy does a sample of the starts, POINTS of them, drawn from a fixed seed.
"""

import subprocess
import sys
import tempfile
import time

import numpy as np
from scipy.integrate import solve_ivp

VD, DAMPING = 1.5, 0.1
REST = 0.5 + 0.5 * np.exp(-2.0 * VD)
NEAR, LATEST, TOLERANCE = 1e-2, 2000.0, 1e-8
GRID = 60


def field(side):
    def slip(_t, y):
        friction = side * (0.5 + 0.5 * np.exp(-2.0 * abs(y[1] - VD)))
        return [y[1], -y[0] - DAMPING * y[1] - friction]

    return slip


def meets(_t, y):
    return y[1] - VD


def comes_to_rest(_t, y):
    return np.hypot(y[0] - REST, y[1]) - NEAR


def released(_t, y):
    return 1.0 - abs(y[0] + DAMPING * VD)


for event in (meets, comes_to_rest, released):
    event.terminal = True
comes_to_rest.direction = -1.0
released.direction = -1.0


def destination(x, v, method):
    """`rest` or `cycle`."""
    t, y, sticks = 0.0, np.array([x, v]), 0
    side = 1.0 if v > VD else -1.0
    while t < LATEST:
        run = solve_ivp(field(side), (t, LATEST), y, method, events=(meets, comes_to_rest), rtol=TOLERANCE, atol=TOLERANCE)
        t, y = run.t[-1], run.y[:, -1]
        if run.t_events[1].size:
            return "rest"
        if not run.t_events[0].size:
            break
        y[1] = VD
        if abs(y[0] + DAMPING * VD) < 1.0:
            sticks += 1
            if sticks == 2:
                return "cycle"
            stick = solve_ivp(lambda _t, _y: [VD, 0.0], (t, LATEST), y, method, events=released, rtol=TOLERANCE, atol=TOLERANCE)
            t, y = stick.t[-1], stick.y[:, -1]
            side = -1.0 if y[0] > 0.0 else 1.0
        else:
            side = -1.0 if y[0] + DAMPING * VD > 0.0 else 1.0
        # Off the boundary, so that the event does not see its own start.
        y[1] = VD + side * 1e-10
    return "undecided"


def by_program(program):
    """Points per second, and the share of the fixed point."""
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "basin", "basins", "--grid", f"{GRID}x{GRID}", "--tol", str(TOLERANCE), "--threads", "1", "--out", folder]
        begin = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        elapsed = time.perf_counter() - begin
        with open(f"{folder}/attractors.csv", encoding="utf-8") as table:
            names, *rows = [line.strip().split(",") for line in table]
    shares = [float(row[names.index("share")]) for row in rows if row[names.index("motion")] == "equilibrium"]
    return GRID * GRID / elapsed, sum(shares)


def by_scipy(method, points):
    random = np.random.default_rng(16)
    starts = np.column_stack([random.uniform(-2.0, 2.0, points), random.uniform(0.0, 2.0, points)])
    begin = time.perf_counter()
    found = [destination(x, v, method) for x, v in starts]
    elapsed = time.perf_counter() - begin
    return points / elapsed, found.count("rest") / points, found.count("undecided")


def main():
    program, points = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 100
    ours, share = by_program(program)
    print(f"stickslip, one thread  {ours:9.1f} points/s  share of the fixed point {share:.3f}")
    for method in ("RK45", "DOP853", "LSODA"):
        rate, share, undecided = by_scipy(method, points)
        error = np.sqrt(share * (1.0 - share) / points)
        print(f"SciPy {method:17s}{rate:9.1f} points/s  share {share:.3f} +- {error:.3f}, {undecided} undecided: {ours / rate:.0f} times slower")


if __name__ == "__main__":
    main()
