"""The analyses, against closed forms and the program's bits."""

import json
import os
import subprocess

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


def test_a_periodic_orbit_has_the_derivatives_of_its_closed_form():
    p = ss.parameter("p", 0.5)
    orbit = ss.periodic_orbit(
        rings(), [1, 0], transient=10, derivatives=p, rtol=1e-12, atol=1e-12
    )
    # The square of the radius is s = 1 + √(1 + p), and the multiplier exp(2s (2 - 2s) 2π).
    of_square = 0.5 / np.sqrt(1.5)
    assert orbit.dperiod == pytest.approx([0], abs=1e-9)
    assert orbit.y_max == pytest.approx(np.sqrt([OUTER, OUTER]), abs=1e-9)
    assert orbit.dy_max[:, 0] == pytest.approx([0.5 * of_square / np.sqrt(OUTER)] * 2, abs=1e-9)
    assert orbit.dy_min == pytest.approx(-orbit.dy_max, abs=1e-9)
    assert 2 * orbit.y @ orbit.dy[:, 0] == pytest.approx(of_square, abs=1e-9)
    of_multiplier = orbit.multipliers[1] * (4 - 8 * OUTER) * 2 * np.pi * of_square
    assert orbit.dmultipliers.shape == (2, 1)
    assert orbit.dmultipliers[:, 0] == pytest.approx([0, of_multiplier], abs=1e-6)
    assert ss.periodic_orbit(rings(), [1, 0], transient=10).dperiod is None
    with pytest.raises(ValueError, match="is a state, on which a periodic orbit does not depend"):
        ss.periodic_orbit(rings(), [1, 0], derivatives=["p", "x"])


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
    exact = np.exp(4 * np.pi * squares * (2 - 2 * squares))
    for wanted, found, of in zip(exact, branch.multipliers, branch.multiplier_uncertainties):
        assert of.shape == found.shape == (1,) and of[0] < 1e-6
        # The radius is known to some 1e-12 itself.
        assert abs(found[0] - wanted) <= of[0] + 1e-10


def circle(p=0.5):
    """r' = r (p - r^2), and a turn takes 2 pi: a cycle of radius sqrt(p) from p = 0 on."""
    x, y = ss.states("x y")
    grows = ss.parameter("p", p) - x * x - y * y
    return ss.System({x: x * grows - y, y: y * grows + x}, start=[1, 0])


def test_a_branch_has_the_extremes_of_its_orbits_and_ends_in_words():
    branch = ss.continuation(circle(), "p", (-0.2, 2), transient=20)
    radius = np.sqrt(branch.parameter)[:, None]
    assert np.allclose(branch.y_max, radius, rtol=0, atol=1e-13)
    assert np.allclose(branch.y_min, -radius, rtol=0, atol=1e-13)
    assert branch.stops == ("equilibrium", "range")
    (end,) = branch.special
    assert (end["name"], end["behind"]) == ("Hopf", 0) and abs(end["parameter"]) < 1e-12
    assert end["period"] == pytest.approx(2 * np.pi, abs=1e-9) and np.isnan(end["y"]).all()
    # In the figure the two curves of the stable cycle, and the mark where they meet.
    high, low, *_, mark = branch.plot(what="y").lines
    drawn = np.stack([low.get_ydata(), high.get_ydata()])
    assert np.array_equal(drawn, np.stack([branch.y_min[:, 1], branch.y_max[:, 1]]))
    assert mark.get_label() == "Hopf" and abs(mark.get_xydata()).max() < 0.1


def test_a_branch_is_that_of_the_program(tmp_path):
    file = tmp_path / "circle.toml"
    file.write_text(circle().to_toml(), encoding="utf-8")
    settings = ["--parameter", "p=-0.2:2", "--transient", "20", "--json"]
    told = program("continue", str(file), *settings, "--out", str(tmp_path))
    found = ss.continuation(circle(), "p", (-0.2, 2), transient=20)
    assert [end["stop"] for end in told["ends"]] == list(found.stops)
    table = np.genfromtxt(tmp_path / "branch.csv", delimiter=",", names=True, dtype=None)
    for name, wanted in (("p", found.parameter), ("period", found.period), ("t", found.t)):
        assert np.array_equal(table[name], wanted)
    for k, state in enumerate("xy"):
        assert np.array_equal(table[state], found.y[:, k])
        assert np.array_equal(table[f"{state}_low"], found.y_min[:, k])
        assert np.array_equal(table[f"{state}_high"], found.y_max[:, k])


def block(v0=2.0):
    """A block on a belt of speed w, whose friction falls with the slip speed: damping 0.1 is less
    than its slope, exp(-2 w), below w = ln(10)/2."""
    x, v = ss.states("x v")
    w = ss.parameter("w", v0)
    law = lambda side: 0.5 + 0.5 * np.exp(-2 * side * (v - w))
    belt = ss.Contact("belt", boundary=v - w, friction=law)
    return ss.System({x: v, v: -x - 0.1 * v - belt.friction}, contacts=[belt], start=[0.5, 0])


def test_an_equilibrium_is_followed_through_its_bifurcations():
    branch = ss.equilibrium_continuation(block(), "w", (0.5, 2.5))
    assert np.allclose(branch.y[:, 0], 0.5 + 0.5 * np.exp(-2 * branch.parameter), atol=1e-12)
    assert np.allclose(branch.y[:, 1], 0, rtol=0, atol=1e-12) and set(branch.mode) == {"-"}
    (hopf,) = branch.special
    assert hopf["name"] == "Hopf" and hopf["parameter"] == pytest.approx(np.log(10) / 2, abs=1e-12)
    assert hopf["frequency"] == pytest.approx(1, abs=1e-12)
    before = branch.parameter[hopf["behind"] - 1 : hopf["behind"] + 1]
    assert before[0] < hopf["parameter"] < before[1]
    is_stable = [one == "stable" for one in branch.stability]
    assert np.array_equal(is_stable, branch.parameter > hopf["parameter"])
    real = [max(values.real) for values in branch.eigenvalues]
    assert np.array_equal(np.array(real) < 0, is_stable)
    assert branch.stops == ("range", "range")


def test_an_equilibrium_of_sliding_leaves_its_boundary():
    """Where |q| < 1 both sides of x' = q - x - side(x) lead to x = 0."""
    x, y = ss.states("x y")
    q = ss.parameter("q", 0.0)
    wall = ss.Contact("wall", boundary=x)
    system = ss.System({x: q - x - wall.side, y: -y}, contacts=[wall])
    branch = ss.equilibrium_continuation(system, q, (-2, 2), [0.5, 1])
    wanted = np.sign(branch.parameter) * np.maximum(np.abs(branch.parameter) - 1, 0)
    assert np.allclose(branch.y[:, 0], wanted, rtol=0, atol=1e-12)
    low, high = branch.special
    assert (low["name"], low["contact"], low["before"], low["after"]) == (
        "boundary equilibrium", "wall", "-", "S",
    )  # fmt: skip
    assert (high["before"], high["after"]) == ("S", "+")
    assert [low["parameter"], high["parameter"]] == pytest.approx([-1, 1], abs=1e-12)
    changes = ss.bifurcation_diagram(system, q, [-1.5, 0.25, 1.5], [0.5, 1]).changes
    assert changes["name"].tolist() == ["boundary-equilibrium bifurcation"] * 2
    assert changes["parameter"] == pytest.approx([-1, 1], abs=1e-12)


def test_a_branch_of_equilibria_is_that_of_the_program(tmp_path):
    file = tmp_path / "block.toml"
    file.write_text(block().to_toml(), encoding="utf-8")
    settings = ["--parameter", "w=0.5:2.5", "--equilibrium", "--json", "--out", str(tmp_path)]
    told = program("continue", str(file), *settings)
    found = ss.equilibrium_continuation(block(), "w", (0.5, 2.5))
    assert [end["stop"] for end in told["ends"]] == list(found.stops)
    table = np.genfromtxt(tmp_path / "equilibria.csv", delimiter=",", names=True, dtype=None)
    assert np.array_equal(table["w"], found.parameter)
    assert np.array_equal(table["x"], found.y[:, 0])
    assert np.array_equal(table["eigenvalue1_re"], [one[0].real for one in found.eigenvalues])
    assert [at["parameter"] for at in told["special"]] == found.special["parameter"].tolist()


def test_special_equilibria_are_followed_in_two_parameters():
    """`x' = p + q x - x³` has folds at 27 p² = 4 q³ and a cusp at 0."""
    x = ss.state("x")
    p, q = ss.parameters(p=0.0, q=1.0)
    system = ss.System({x: p + q * x - x**3})
    branch = ss.equilibrium_continuation(system, p, (-1, 1), [1], transient=0, also=(q, (-1, 2)))
    assert branch.special["name"].tolist() == ["fold", "fold"]
    assert [curve.begins for curve in branch.curves] == [0, 1]
    for curve in branch.curves:
        assert (curve.what, curve.names, curve.stops) == ("fold", ("p", "q"), ("range", "range"))
        off = 27 * curve.parameter**2 - 4 * curve.other**3
        assert np.abs(off).max() < 1e-11 and np.isnan(curve.frequency).all()
        assert np.allclose(3 * curve.y[:, 0] ** 2, curve.other, rtol=0, atol=1e-11)
        (cusp,) = curve.special
        assert cusp["name"] == "cusp" and abs(cusp["other"]) <= cusp["other_uncertainty"] < 1e-9
        assert len(curve.to_pandas()) == len(curve.other)
    assert ss.equilibrium_continuation(system, p, (-1, 1), [1], transient=0).curves == []


def test_where_there_is_no_equilibrium_it_is_said():
    with pytest.raises(ss.StickslipError, match="a motion of kind `periodic`.*transient=0") as one:
        ss.equilibrium_continuation(rings(), "p", (-1.5, 1), [1, 0])
    assert one.value.kind == "NotFound"
    # Without a run it is the one near the start.
    branch = ss.equilibrium_continuation(rings(), "p", (-1.5, 1), [0.01, 0], transient=0)
    assert branch.special["name"].tolist() == ["Hopf"] and np.allclose(branch.y, 0, atol=1e-12)
    x, v = ss.states("x v")
    driven = ss.System({x: v, v: np.cos(ss.t) - ss.parameter("p", 1.0) * v - x})
    with pytest.raises(ValueError, match="depends on time, so that it has no equilibrium"):
        ss.equilibrium_continuation(driven, "p", (0, 2), [0, 0])
    damped = ss.System({x: v, v: -ss.parameter("p", 1.0) * v - x})
    with pytest.raises(ss.StickslipError, match="follow it by equilibrium_continuation"):
        ss.continuation(damped, "p", (0.5, 2), [1, 0], transient=50)


def test_a_driven_orbit_that_rests_is_followed():
    """It rests at x = p whatever the drive."""
    x, v = ss.states("x v")
    p = ss.parameter("p", 1.0)
    rate = (p - 0.5 * v - x) * (2 + np.cos(ss.t))
    system = ss.System({x: v, v: rate}, period=2 * np.pi)
    assert ss.periodic_orbit(system, [0.1, 0]).y[0] == pytest.approx(1, abs=1e-12)
    branch = ss.continuation(system, p, (0.5, 1.5), [0.1, 0])
    assert branch.stops == ("range", "range")
    assert np.allclose(branch.y[:, 0], branch.parameter, rtol=0, atol=1e-9)
    moves = ss.System({x: v, v: rate + 0.3 * np.cos(ss.t)}, period=2 * np.pi)
    assert ss.continuation(moves, p, (0.5, 1.5), [0.1, 0]).stops == ("range", "range")


def test_a_branch_along_the_frequency_of_a_drive_is_in_its_time():
    x, v = ss.states("x v")
    w = ss.parameter("w", 1.0)
    system = ss.System({x: v, v: np.cos(w * ss.t) - 0.5 * v - x}, period=2 * ss.pi / w)
    branch = ss.continuation(system, w, (0.7, 1.6), {x: 0, v: 0}, t0=0.3, transient=100)
    values = branch.parameter
    assert np.allclose(branch.period, 2 * np.pi / values, rtol=1e-14)
    response = 1 / (1 - values**2 + 0.5j * values)
    wanted = np.abs(response)[:, None] * np.stack([np.ones_like(values), values], axis=1)
    assert np.allclose(branch.y_max, wanted, rtol=0, atol=1e-9)
    phase = np.exp(1j * values * branch.t) * response
    assert np.allclose(branch.y[:, 0], phase.real, rtol=0, atol=1e-8)


def test_a_closed_branch_is_there_once():
    """Cycles of r^2 = 2 + q with p^2 + q^2 = 1: along p their branch is a closed curve."""
    x, y, q = ss.states("x y q")
    p = ss.parameter("p", 0.0)
    grows = 2 + q - x * x - y * y
    rates = {x: x * grows - y, y: y * grows + x, q: (1 - p * p - q * q) / 4}
    branch = ss.continuation(ss.System(rates), p, (-2, 2), [1, 0, 1], transient=60, step=0.05)
    assert "closed" in branch.stops
    assert np.allclose(branch.parameter**2 + branch.y[:, 2] ** 2, 1, atol=1e-6)
    places = np.stack([branch.parameter, branch.y[:, 2]], axis=1).round(6)
    assert len(np.unique(places[1:], axis=0)) == len(places) - 1


def test_a_branch_keeps_the_change_at_which_it_ends():
    """A ball that hits a wall from one side: beyond the graze no cycle of these phases exists."""
    x, v = ss.states("x v")
    w = ss.parameter("w", 2.5)
    wall = ss.Jump("wall", when=x - 1, direction="rising", set={v: -0.8 * v})
    rate = np.cos(w * ss.t) - x - 0.1 * v
    system = ss.System({x: v, v: rate}, jumps=[wall], period=2 * ss.pi / w)
    branch = ss.continuation(system, w, (1.2, 3), [0, 0])
    # The free oscillator reaches the wall where its amplitude is 1.
    graze = branch.special[0]
    assert graze["behind"] == 0 and "graz" in graze["name"]
    w2 = graze["parameter"] ** 2
    assert (1 - w2) ** 2 + 0.01 * w2 == pytest.approx(1, abs=1e-9)
    assert branch.y_max[0, 0] == pytest.approx(1, abs=0.05)


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
    # Neighbours diverge as fast, until they are as far apart as any two points.
    value, error = found.diverging_neighbours["rosenstein"]
    assert abs(value - np.log(2)) < 4 * error < 0.2
    curve = found.diverging_neighbours["rosenstein_curve"]
    assert curve["straight"]["slope"] == value and len(curve["t"]) == len(curve["log_distance"])
    assert curve["log_distance"].max() < found.diverging_neighbours["saturation"] + 0.3
    assert ss.lyapunov_from_data(series[:45], dimension=1).diverging_neighbours is None
    with pytest.raises(ValueError, match=r"series\[3, 0\] = nan"):
        ss.lyapunov_from_data([0.1, 0.2, 0.3, np.nan])


def roessler(points):
    x, y, z = ss.states("x y z")
    system = ss.System({x: -y - z, y: x + 0.2 * y, z: 0.2 + z * (x - 5.7)})
    times = 100 + 0.2 * np.arange(points)
    return ss.solve_ivp(system, (0, 101 + 0.2 * points), [1, 1, 0], t_eval=times, rtol=1e-9).y


@pytest.mark.parametrize("given", [{}, {"delay": 5}, {"dimension": 4}, {"dimension": 1}])
def test_a_sensor_is_embedded_as_by_the_program(given, tmp_path):
    sensor = roessler(2500)[0]
    np.save(tmp_path / "sensor.npy", sensor)
    options = [f"--{name}={value}" for name, value in given.items()]
    told = program("spectrum", str(tmp_path / "sensor.npy"), "--dt", "0.2", *options, "--json")
    found = ss.lyapunov_from_data(sensor, dt=0.2, **given)
    of_program = {name: [one[name] for one in told["exponents"]] for name in told["exponents"][0]}
    assert of_program["exponent"] == found.exponents.tolist()
    assert of_program["stderr"] == found.std_errors.tolist()
    assert of_program["status"] == found.status
    embedding = told["embedding"] and (told["embedding"]["delay"], told["embedding"]["dimension"])
    assert embedding == found.embedding and told["dimension"] == found.dimension
    assert (found.embedding is None) == (given == {"dimension": 1})
    ours, theirs = found.diverging_neighbours, told["diverging_neighbours"]
    for method in ("rosenstein", "kantz"):
        of_program = theirs[method] and (theirs[method]["exponent"], theirs[method]["stderr"])
        assert ours[method] == of_program
    curves = [ours["rosenstein_curve"], *ours["kantz_curves"]]
    for one, other in zip(curves, [theirs["rosenstein_curve"], *theirs["kantz_curves"]]):
        assert np.column_stack([one["t"], one["log_distance"]]).tolist() == other["curve"]
        for key in ("radius", "references", "straight"):
            assert one[key] == other[key]


def test_whole_states_are_not_embedded():
    found = ss.lyapunov_from_data(roessler(2500).T, dt=0.2)
    assert found.embedding is None and len(found.exponents) == 3
    with pytest.raises(ValueError, match=r"a row for each point; of a solution it is sol\.y\.T"):
        ss.lyapunov_from_data(roessler(50))
    with pytest.raises(ss.OptionError, match="dt") as caught:
        ss.lyapunov_from_data([1.0, 2.0, 3.0], dt=0)
    assert (caught.value.name, caught.value.value) == ("dt", 0.0)


def test_failed_runs_are_counted_by_one_warning():
    x = ss.state("x")
    a, b = ss.parameters(a=0.5, b=1.0)
    # The logarithm has no value at the start where a is large.
    system, values = ss.System({x: -b * np.log(x - a)}, start=[1]), [0.2, 0.5, 3.0, 3.5, 0.4]
    with pytest.warns(RuntimeWarning) as caught:
        found = ss.bifurcation_diagram(system, "a", values)
    (warning,) = caught
    assert warning.category is ss.SolverWarning and warning.filename == __file__
    message = str(warning.message)
    assert message.startswith("2 of 5 runs failed; the first, at a = 3: cannot start at t = 0")
    assert [kind == "failure" for kind in found.kind] == [value > 2 for value in values]
    match = "2 of 6 runs failed; the first, at a = 3, b = 1"
    with pytest.warns(RuntimeWarning, match=match) as one:
        plane = ("a", [0.1, 0.2, 3.0]), ("b", [1, 2])
        ss.parameter_map(system, *plane, longest=100, duration=None)
    assert len(one) == 1


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


def program(*arguments):
    path = os.environ.get("STICKSLIP")
    if not path:
        pytest.skip("STICKSLIP does not name the program; `make python-test` does")
    done = subprocess.run([path, *arguments], capture_output=True, check=True)
    return json.loads(done.stdout)


FORCED = ["--start", "x=-0.269", "--start", "v=-1.52", "--json"]


def test_a_map_is_that_of_the_program(tmp_path):
    planes = {"--x": "mu0=0.122:0.134", "--y": "omega=3.76:3.86"}
    given = [text for pair in planes.items() for text in pair]
    settings = ["--grid", "3x2", "--until", "300", "--duration", "30", "--out", str(tmp_path)]
    program("map", "forced", *given, *settings, *FORCED)
    table = np.genfromtxt(tmp_path / "map.csv", delimiter=",", names=True, dtype=None)
    middles = lambda low, high, cells: low + (high - low) * (np.arange(cells) + 0.5) / cells
    x, y = ("mu0", middles(0.122, 0.134, 3)), ("omega", middles(3.76, 3.86, 2))
    forced = ss.System.from_toml("forced")
    found = ss.parameter_map(forced, x, y, [-0.269, -1.52], longest=300, duration=30)
    assert found.kind.shape == (2, 3) and (found.kind == "periodic").any()
    assert np.array_equal(found.kind.ravel(), table["motion"])
    assert np.array_equal(found.exponent.ravel(), table["lambda1"], equal_nan=True)
    assert np.array_equal(found.std_error.ravel(), table["std_error"], equal_nan=True)
    assert np.array_equal(found.uncertainty.ravel(), table["uncertainty"], equal_nan=True)
    again = ss.parameter_map(forced, x, y, [-0.269, -1.52], longest=300, duration=30, workers=1)
    assert np.array_equal(found.exponent, again.exponent, equal_nan=True)


def test_a_diagram_and_its_changes_are_those_of_the_program(tmp_path):
    settings = ["--values", "4", "--until", "500", "--duration", "20", "--out", str(tmp_path)]
    told = program("bifurcation", "forced", "--parameter", "mu0=0.127:0.130", *settings, *FORCED)
    # As the program makes them.
    values = [0.127 + (0.130 - 0.127) * (k / 3) for k in range(4)]
    forced = ss.System.from_toml("forced")
    found = ss.bifurcation_diagram(forced, "mu0", values, [-0.269, -1.52], longest=500, duration=20)
    table = np.genfromtxt(tmp_path / "changes.csv", delimiter=",", names=True, dtype=None)
    up = np.atleast_1d(table)
    up = up[up["way"] == "up"]
    assert len(up) == len(found.changes) == len(told["up"]["changes"]) > 0
    assert np.array_equal(up["what"], found.changes["name"])
    assert np.array_equal(up["mu0"], found.changes["parameter"], equal_nan=True)
    rows = np.genfromtxt(tmp_path / "bifurcation.csv", delimiter=",", names=True, dtype=None)
    firsts = rows[rows["way"] == "up"]
    for value, exponent in zip(found.parameter, found.exponent):
        assert exponent in firsts[firsts["mu0"] == value]["lambda1"]


def test_a_change_is_located_where_it_is():
    x = ss.state("x")
    p = ss.parameter("p", 1.0)
    found = ss.bifurcation_diagram(rings(), "p", [-0.5, -0.9, -1.3], [1.2, 0], longest=500)
    assert found.kind[0] == "periodic" and found.kind[2].startswith("equilibrium")
    fold = found.changes[found.changes["name"] == "fold"]
    assert len(fold) == 1 and fold["parameter"][0] == pytest.approx(-1, abs=1e-6)
    assert (fold["from_value"][0], fold["to_value"][0]) == (-0.9, -1.3)
    assert fold["criticality"][0] == ""
    none = ss.bifurcation_diagram(rings(), "p", [-0.9, -1.3], [1.2, 0], longest=500, locate=False)
    assert len(none.changes) == 0
    for locate in ("all", True):
        again = ss.bifurcation_diagram(
            rings(), "p", [-0.9, -1.3], [1.2, 0], longest=500, locate=locate
        )
        assert again.changes["name"].tolist() == found.changes["name"].tolist()
    with pytest.raises(ValueError, match="it is periodic, all or none"):
        ss.bifurcation_diagram(rings(), "p", [-0.9, -1.3], [1.2, 0], locate="some")
    stiff = ss.System({x: -p * x + 1}, start={x: 1 / p})
    assert ss.bifurcation_diagram(stiff, p, [1.0, 2.0]).kind == ["equilibrium"] * 2


def test_a_start_outside_the_domain_is_an_outcome_of_its_own():
    x = ss.state("x")
    with pytest.warns(ss.SolverWarning, match="1 of 3 runs failed"):
        found = ss.basins_of_attraction(ss.System({x: -np.log(x)}), [[0.5], [-1.0], [2.0]])
    assert found.reached.tolist() == [0, 1, 0] and found.kind == ["equilibrium", "failure"]
    assert np.allclose(found.points[0], 1)


def test_a_section_without_a_return_has_a_remedy():
    x = ss.state("x")
    with pytest.raises(ss.StickslipError, match="larger `longest`, or another section") as raised:
        ss.poincare_map(ss.System({x: -x}), x - 5, [1.0], longest=10)
    assert raised.value.kind == "NotFound" and raised.value.t == 0


def test_the_shortest_period_is_found_and_rest_is_told():
    x, v = ss.states("x v")
    driven = ss.System({x: v, v: np.cos(ss.t) - 0.5 * v - x}, period=2 * np.pi)
    orbit = ss.periodic_orbit(driven, [0, 0])
    assert orbit.period == pytest.approx(2 * np.pi)
    double = ss.periodic_orbit(driven, [0, 0], periods=2)
    assert double.period == pytest.approx(4 * np.pi)
    with pytest.raises(ss.StickslipError, match="comes to the equilibrium") as raised:
        ss.periodic_orbit(ss.System({x: v, v: -v - x}), [1, 0], transient=50)
    assert raised.value.kind == "NotFound"
    with pytest.raises(ss.SystemError, match="what is its period"):
        ss.periodic_orbit(ss.System({x: v, v: np.cos(ss.t) - v - x}), [1, 0])


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda s: ss.basins_of_attraction(s, [[1, 0]], workers=0), "workers = 0"),
        (lambda s: ss.basins_of_attraction(s, [1, 0, 0]), "last axis of starts"),
        (lambda s: ss.basins_of_attraction(s, [[np.nan, 0]]), r"starts\[0, 0\] = nan"),
        (lambda s: ss.parameter_map(s, ("p", [1]), ("p", [1]), [1, 0]), "both p"),
        (lambda s: ss.bifurcation_diagram(s, "p", [0.1, np.inf], [1, 0]), r"values\[1\] = inf"),
        (lambda s: ss.bifurcation_diagram(s, "q", [0.1], [1, 0]), "parameter `q`; there are p"),
        (lambda s: ss.continuation(s, "q", (0, 1), [1, 0]), "parameter `q`; there are p"),
        (lambda s: s.with_parameters(q=1), "parameter `q`; there are p"),
        (lambda s: ss.bifurcation_diagram(s, "p", [], [1, 0]), "values is empty: give"),
        (lambda s: ss.parameter_map(s, ("p", []), ("q", [1]), [1, 0]), r"x\[1\] is empty: give"),
        (lambda s: ss.basins_of_attraction(s, np.empty((0, 2))), "starts is empty"),
        (lambda s: ss.continuation(s, "p", (0, 1), [1, 0], step=2.0), "step = 2 is not allowed"),
        (lambda s: ss.periodic_orbit(s, [1, 0], periods=0), "periods = 0"),
        (lambda s: ss.periodic_orbit(s, [1, 0], periods=2), "does not depend on time"),
        (lambda s: ss.continuation(s, "p", (1, 1), [1, 0]), r"must be larger than bounds\[0\] = 1"),
        (lambda s: ss.continuation(s, "p", (3, 0), [1, 0]), r"bounds\[1\] = 0.*bounds\[0\] = 3;"),
        (lambda s: ss.basins_of_attraction(s, np.meshgrid([1, 2], [3, 4, 5])), "meshgrid: stack"),
        (lambda s: ss.poincare_map(s, ss.parameter("p", 1.0), [1, 0]), "neither a state nor time"),
    ],
)
def test_what_cannot_be_is_refused_by_name(call, words):
    with pytest.raises(ValueError, match=words):
        call(rings())


def test_an_option_out_of_bounds_has_typed_fields():
    with pytest.raises(ss.OptionError) as raised:
        ss.lyapunov_spectrum(rings(), [1, 0], rtol=2.0)
    error = raised.value
    assert (error.name, error.value) == ("rtol", 2.0) and error.bound in str(error)
    with pytest.raises(TypeError, match="'rtoll' is no option"):
        ss.lyapunov_spectrum(rings(), [1, 0], rtoll=1e-9)


def test_a_branch_begins_within_its_bounds():
    x = ss.state("x")
    p = ss.parameter("p", 2.0)
    system = ss.System({x: p - x})
    with pytest.raises(ss.OptionError, match="p = 2: it must be in the bounds 0 to 1") as caught:
        ss.continuation(system, p, (0, 1), [0.5])
    assert (caught.value.name, caught.value.value) == ("p", 2.0)


def test_an_exponent_that_cannot_be_measured_is_told():
    x, v = ss.states("x v")
    s, r = ss.discrete(s=0, r=1)
    A, q = ss.parameters(A=1, q=1)
    top = ss.Jump("top", when=x - A, direction="rising", set={s: 1})
    turn = ss.Jump("turn", when=s - 0.5, direction="rising", set={r: -1, s: 0})
    bottom = ss.Jump("bottom", when=x + A, direction="falling", set={r: 1})
    chain = ss.System({x: r, v: x - q * v}, jumps=[top, turn, bottom], start=[0, 0])
    with pytest.warns(ss.SolverWarning, match="no exponent: the jump"):
        found = ss.bifurcation_diagram(chain, A, [1, 1.2], duration=50, locate="none")
    assert np.isnan(found.exponent).all() and set(found.kind) == {"periodic"}
    with pytest.warns(ss.SolverWarning, match="2 of 2 runs failed"):
        plane = ss.parameter_map(chain, (A, [1, 1.2]), (q, [1]), duration=50)
    assert np.isnan(plane.exponent).all()
