"""The analyses, against closed forms; Ctrl-C and processes that fork."""

import multiprocessing
import subprocess
import sys

import numpy as np
import pytest
import stickslip as ss


def rings(p=0.5):
    """s' = 2 s (p + 2 s - s^2) for s = r^2, and a turn takes 2 pi: cycles meet at p = -1."""
    x, y = ss.states("x y")
    s = x * x + y * y
    grows = ss.parameter("p", p) + 2 * s - s * s
    return ss.System({x: x * grows - y, y: y * grows + x})


OUTER = 1 + np.sqrt(1.5)
RATE = 2 * OUTER * (2 - 2 * OUTER)


def test_a_periodic_orbit_has_its_period_and_multiplier():
    orbit = ss.periodic_orbit(rings(), [1, 0], transient=10)
    assert orbit.period == pytest.approx(2 * np.pi, abs=1e-9)
    assert orbit.y @ orbit.y == pytest.approx(OUTER, abs=1e-9)
    assert orbit.multipliers[0] == pytest.approx(1, abs=1e-8) and orbit.stability == "stable"
    assert abs(orbit.multipliers[1]) == pytest.approx(np.exp(RATE * 2 * np.pi), abs=1e-9)


def test_returns_to_a_section_and_their_derivative():
    section = ss.event(ss.state("y"), direction=1)
    found = ss.poincare_map(rings(-0.5), section, [1.2, 0], returns=5, derivative=True)
    assert np.allclose(found.t, 2 * np.pi * np.arange(1, 6), rtol=0, atol=1e-9)
    s = 1 + np.sqrt(0.5)
    assert found.y.shape == (5, 2) and found.y[-1, 0] ** 2 == pytest.approx(s, abs=1e-9)
    contraction = np.exp(2 * s * (2 - 2 * s) * 2 * np.pi)
    assert found.derivatives[-1, 0, 0] == pytest.approx(contraction, abs=1e-9)


def test_a_branch_turns_at_its_fold():
    branch = ss.continuation(rings(), "p", (-1.5, 1), [1, 0], transient=10)
    folds = branch.special[branch.special["name"] == "fold"]
    assert len(folds) == 1 and folds["parameter"][0] == pytest.approx(-1, abs=1e-6)
    squares = (branch.y**2).sum(axis=1)
    assert np.allclose((squares - 1) ** 2, 1 + branch.parameter, atol=1e-6)


def test_exponents_of_a_cycle():
    found = ss.lyapunov_spectrum(rings(), [1, 0], transient=20, duration=200)
    assert found.exponents == pytest.approx([0, RATE], abs=1e-3)


def test_a_diagram_follows_the_attractor():
    values = np.linspace(0.5, -0.5, 5)
    found = ss.bifurcation_diagram(rings(), "p", values, [1, 0], longest=500)
    assert np.array_equal(found.parameter, values)
    sizes = [(points**2).sum(axis=1).mean() for points in found.points]
    assert np.allclose(sizes, 1 + np.sqrt(1 + values), atol=1e-6)


def basins(workers=-1):
    x = np.linspace(-1.5, 1.5, 8)
    starts = np.stack(np.meshgrid(x, x), axis=-1)
    found = ss.basins_of_attraction(rings(-0.5), starts, longest=500, workers=workers)
    return starts, found


def test_basins_are_told_apart():
    starts, found = basins()
    # The unstable cycle is the border.
    inside = (starts**2).sum(axis=-1) < 1 - np.sqrt(0.5)
    rest = next(k for k, kind in enumerate(found.kind) if kind.startswith("equilibrium"))
    assert len(found.kind) == 2 and np.array_equal(found.reached == rest, inside)
    assert found.shares.sum() == pytest.approx(1)
    assert np.array_equal(basins(workers=1)[1].reached, found.reached)


def test_exponents_of_a_series():
    series = [0.3]
    while len(series) < 4000:
        series.append(4 * series[-1] * (1 - series[-1]))
    found = ss.lyapunov_from_data(series)
    assert found.exponents[0] == pytest.approx(np.log(2), abs=0.02) and found.status[0] == "ok"
    with pytest.raises(ValueError, match=r"series\[3, 0\] = nan"):
        ss.lyapunov_from_data([0.1, 0.2, 0.3, np.nan])


def in_child(workers):
    return basins(workers)[1].reached.tolist()


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_processes_do_not_hang(method):
    wanted = in_child(2)
    with multiprocessing.get_context(method).Pool(1) as pool:
        assert pool.map_async(in_child, [2]).get(timeout=120) == [wanted]


LONG = """
import signal, threading, time, numpy as np, stickslip as ss
x, y = ss.states("x y")
system = ss.System({x: y, y: -x * x * x + 0.01 * np.cos(ss.t)}, period=2 * np.pi)
sent = []
def interrupt():
    time.sleep(0.7)
    sent.append(time.perf_counter())
    signal.raise_signal(signal.SIGINT)
threading.Thread(target=interrupt).start()
try:
    WORK
    print("it ended by itself")
except KeyboardInterrupt:
    print(time.perf_counter() - sent[0])
"""


@pytest.mark.parametrize(
    "work",
    [
        "ss.solve_ivp(system, (0, 1e9), [1, 0], t_eval=[1.0])",
        "ss.solve_ivp(system, (0, 1e9), [1, 0], t_eval=[], events=[x - 9, y - 9])",
        "ss.lyapunov_spectrum(system, [1, 0], duration=1e8)",
        "ss.basins_of_attraction(system, np.random.rand(500, 2), longest=1e7)",
    ],
)
def test_ctrl_c_ends_work_soon(work):
    run = [sys.executable, "-c", LONG.replace("WORK", work)]
    done = subprocess.run(run, capture_output=True, text=True, check=True, timeout=60)
    assert float(done.stdout) < 0.2


SAMPLE = """
import numpy as np
import stickslip as ss

x, v = ss.states("x v")
(vp,) = ss.parameters(vp=0.2)
belt = ss.Contact("belt", boundary=v - vp)
system = ss.System({x: v, v: -x - 0.4 * belt.side}, contacts=[belt])
sol = ss.solve_ivp(system, (0, 5), [0.5, 0], events=[ss.event(v, direction=-1)])
orbit: ss.PeriodicOrbit = ss.periodic_orbit(system, [0.5, 0.0])
print(float(sol.t[-1]), orbit.period, np.asarray(sol.y).shape, sol.success)
"""


def test_types_are_those_that_the_package_says(tmp_path):
    sample = tmp_path / "sample.py"
    sample.write_text(SAMPLE, encoding="utf-8")
    run = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path), str(sample)]
    done = subprocess.run(run, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout


def test_a_branch_of_a_driven_system_has_the_period_of_its_drive():
    """A damped spring with a drive has one cycle, x = sin(t)/c at w = 1, at any damping c."""
    x, v = ss.states("x v")
    system = ss.System({x: v, v: np.cos(ss.t) - ss.parameter("c", 0.5) * v - x}, period=2 * np.pi)
    branch = ss.continuation(system, "c", (0.3, 0.7), [0, 0], transient=100)
    assert branch.parameter.min() < 0.31 and branch.parameter.max() > 0.69
    assert np.allclose(branch.period, 2 * np.pi, rtol=0, atol=1e-12)
    wanted = np.stack([np.sin(branch.t), np.cos(branch.t)], axis=1) / branch.parameter[:, None]
    assert np.allclose(branch.y, wanted, rtol=0, atol=1e-8)


def test_a_diagram_along_the_frequency_of_a_drive():
    x, v = ss.states("x v")
    w = ss.parameter("w", 1.0)
    rate = np.cos(w * ss.t) - 0.5 * v - x
    system = ss.System({x: v, v: rate}, period=2 * ss.pi / w)
    values = np.array([1.0, 1.5, 2.0])
    found = ss.bifurcation_diagram(system, w, values, [0, 0], longest=500)
    response = 1 / (1 - values**2 + 0.5j * values)
    # At whole periods the drive is at its largest.
    for points, wanted in zip(found.points, response):
        assert len(points) == 1 and points[0, 0] == pytest.approx(wanted.real, abs=1e-5)
