"""Results of the program, from Python: curves, branches, tangent points, shares, spectra."""

import csv
import os
import pickle
import subprocess

import numpy as np
import pytest
import stickslip as ss

PROGRAM = os.environ.get("STICKSLIP", "stickslip")
x, v, y = ss.states("x v y")


def run(folder, system, *command):
    (folder / "system.toml").write_text(system.to_toml(), encoding="utf-8")
    name, *options = command
    run = [PROGRAM, name, "system.toml", "--out", "out", *options]
    done = subprocess.run(run, cwd=folder, capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    return done


def table(folder, name):
    with open(folder / "out" / f"{name}.csv", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def bubble():
    """A circle of radius r with r² = 1 ± √(p + q), whose fold lies at p = -q."""
    p, q = ss.parameters(p=0.5, q=0.0)
    s = x * x + y * y
    grows = p + q + 2 * s - s * s
    # The fold of 2 s - s² is at s = 1: p + q = -1.
    return ss.System({x: x * grows - y, y: y * grows + x}, start=[1.5, 0]), p, q


def test_a_fold_is_followed_in_two_parameters(tmp_path):
    system, p, q = bubble()
    along = {"transient": 10.0}
    branch = ss.continuation(system, p, (-1.5, 1), also=(q, (-0.3, 0.3)), **along)
    (curve,) = [one for one in branch.curves if one.what == "fold"]
    assert len(curve.parameter) > 5 and curve.names == ("p", "q")
    assert np.allclose(curve.parameter + curve.other, -1, rtol=0, atol=1e-8)
    assert np.allclose(curve.period, 2 * np.pi, rtol=0, atol=1e-8)
    assert branch.special["name"][curve.begins] == "fold" and curve.stops == ("range", "range")
    assert len(curve.special) == 0 and set(branch.special["criticality"]) == {""}
    assert curve.plot().get_ylabel() == "q"
    assert list(curve.to_pandas())[:2] == ["p", "q"] and "y" in curve.to_xarray()
    run(tmp_path, system, "continue", "--parameter", "p=-1.5:1", "--also", "q=-0.3:0.3",
        "--transient", "10")  # fmt: skip
    rows = [row for row in table(tmp_path, "curves") if row["what"] == "fold"]
    assert [float(row["q"]) for row in rows] == curve.other.tolist()
    assert [float(row["period"]) for row in rows] == curve.period.tolist()
    orbits = table(tmp_path, "branch")
    uncertainties = [float(one["multiplier1_uncertainty"]) for one in orbits]
    assert uncertainties == [one[0] for one in branch.multiplier_uncertainties]
    with pytest.raises(ValueError, match="also = p: it is the parameter of the branch"):
        ss.continuation(system, p, (-1.5, 1), also=(p, (0, 1)), **along)
    with pytest.raises(TypeError, match="also must be a parameter and its bounds"):
        ss.continuation(system, p, (-1.5, 1), also="q", **along)


def test_branches_begin_at_special_orbits():
    # r' = r (p - r²) in the plane, and z' = z (p - 1 - z²): at p = 1 two branches z = ±√(p - 1)
    # begin at the circle.
    z = ss.state("z")
    p = ss.parameter("p", 0.5)
    s = x * x + y * y
    rates = {x: x * (p - s) - y, y: y * (p - s) + x, z: z * (p - 1 - z**2)}
    system = ss.System(rates, start=[0.7, 0, 0])
    branch = ss.continuation(system, p, (0.2, 2), branches=True, transient=20)
    assert "branch point" in branch.special["name"] and len(branch.branches) == 2
    ends = []
    for one in branch.branches:
        assert branch.special["name"][one.begins] == "branch point" and one.branches == []
        assert np.allclose(one.y[:, 2] ** 2, one.parameter - 1, rtol=0, atol=1e-7)
        ends.append(one.y[-1, 2])
    assert min(ends) < -0.9 and max(ends) > 0.9
    plain = ss.continuation(system, p, (0.2, 2), transient=20)
    assert plain.branches == [] == plain.curves and plain.begins is None
    assert np.array_equal(plain.parameter, branch.parameter)


def test_a_friction_force_is_fitted_as_by_the_program(tmp_path):
    mu, fall = ss.parameters(mu=0.44, fall=1.1)
    slip = v - 0.3
    belt = ss.Contact("belt", slip, friction=lambda side: mu / (1 + fall * side * slip))
    block = ss.System({x: v, v: -x - belt.friction}, contacts=[belt], start=[0.2, 0.9])
    t = np.linspace(0.25, 9, 60)
    sol = ss.solve_ivp(block.with_parameters(mu=0.5, fall=1.0), (0, 9), t_eval=t)
    data = np.c_[t, sol.forces[0] + np.random.default_rng(2).normal(0, 0.01, t.size)]
    np.savetxt(tmp_path / "data.csv", data, delimiter=",", header="t,f", comments="", fmt="%.17g")
    assert pickle.loads(pickle.dumps(belt)).force.text == "belt.force"
    found = ss.fit(block, {"t": data[:, 0], "f": data[:, 1]}, [mu, fall], {"f": belt.force})
    assert np.allclose(found.x, [0.5, 1.0], rtol=0, atol=0.05)
    run(tmp_path, block, "fit", "data.csv", "--fit", "mu,fall", "--observe", "f=belt.force")
    assert [float(row["value"]) for row in table(tmp_path, "parameters")] == found.x.tolist()
    with pytest.raises(ss.SystemError, match="known along an orbit alone"):
        ss.solve_ivp(block, (0, 9), events=[belt.force - 0.3])
    (other,) = ss.parameters(mu=0.9)
    with pytest.raises(ValueError, match="mu is 0.44 in the system and 0.9 in the formula"):
        ss.fit(block, {"t": t, "f": t}, [mu], {"f": other * belt.force})


def test_tangent_points_are_those_of_the_program(tmp_path):
    mu0, vp = ss.parameters(mu0=0.4, vp=0.2)
    belt = ss.Contact("belt", v - vp, lambda side: mu0 / (1 + 3 * side * (v - vp)))
    system = ss.System({x: v, v: -x - 0.05 * v - belt.friction}, contacts=[belt], start=[0.5, 0])
    found = ss.tangents(system, belt, along=x, bounds=(-1, 1))
    assert np.allclose(found.points["y.x"], [0.39, -0.41], rtol=0, atol=1e-12)
    assert (found.along, found.solved, found.contact) == ("x", "v", "belt")
    (zone,) = found.zones
    assert zone["kind"] == "stick"
    assert np.allclose([zone["low"], zone["high"]], [-0.41, 0.39], rtol=0, atol=1e-12)
    run(tmp_path, system, "tangents", "--from", "-1", "--to", "1")
    rows = table(tmp_path, "tangents")
    assert [float(row["x"]) for row in rows] == found.points["y.x"].tolist()
    assert [row["visibility"] for row in rows] == found.points["visibility"].tolist()
    axes = found.plot()
    assert axes.get_xlabel() == "x" and len(found.to_pandas()) == 2
    assert found.to_xarray().y.dims == ("point", "state")
    for given, said in (
        ({"contact": "wall"}, "there is no contact wall: they are belt"),
        ({"along": "z"}, "there is no state 'z'"),
        ({"bounds": None}, r"the range of x is missing: give bounds=\(lowest, highest\)"),
        ({"bounds": (1, -1)}, r"bounds\[1\] = -1"),
    ):
        with pytest.raises(ValueError, match=said):
            ss.tangents(**{"system": system, "bounds": (-1, 1), **given})
    with pytest.raises(ValueError, match="the system has no contact"):
        ss.tangents(ss.System({x: v, v: -x}), bounds=(-1, 1))


def test_standard_errors_of_shares_are_those_of_the_program(tmp_path):
    system = ss.System({x: v, v: x - x**3 - 0.3 * v}, start=[0, 0])
    centres = (np.arange(12) + 0.5) / 12
    grid = np.stack(np.meshgrid(-2 + 4 * centres, -1 + 2 * centres), axis=-1)
    basins = ss.basins_of_attraction(system, grid)
    run(tmp_path, system, "basin", "--x", "x=-2:2", "--y", "v=-1:1", "--grid", "12x12")
    rows = table(tmp_path, "attractors")
    assert sorted(float(row["share"]) for row in rows) == sorted(basins.shares.tolist())
    assert sorted(float(row["std_error"]) for row in rows) == sorted(basins.std_errors.tolist())
    assert basins.attractors["std_error"].tolist() == basins.std_errors.tolist()
    # Of independent starts it is the binomial one.
    starts = np.random.default_rng(1).uniform(-1, 1, (50, 2))
    random = ss.basins_of_attraction(system, starts)
    share = random.shares
    assert np.allclose(random.std_errors, np.sqrt(share * (1 - share) / 50), rtol=1e-14)


def logistic(count=3000):
    series = [0.3]
    while len(series) < count:
        series.append(4 * series[-1] * (1 - series[-1]))
    return np.array(series)


@pytest.mark.parametrize(
    ("given", "options"),
    [
        ({}, []),
        ({"estimator": "sano-sawada"}, ["--estimator", "sano-sawada"]),
        ({"degree": "linear", "theiler": 5}, ["--degree", "linear", "--theiler", "5"]),
        ({"neighbours": 30}, ["--neighbours", "30"]),
        ({"neighbours": (20, 40), "eps": 0.05}, ["--neighbours", "20-40", "--eps", "0.05"]),
        ({"affine": True, "ridge": 1e-6}, ["--affine", "--ridge", "1e-6"]),
        ({"dimension": 2, "delay": 1, "step": 1}, ["--dimension", "2", "--delay", "1", "--step", "1"]),
        (
            {"step": 2, "stride": 2, "references": 500, "rank": 1},
            ["--step", "2", "--stride", "2", "--references", "500", "--rank", "1"],
        ),
        ({"rank_tolerance": 1e-6, "dimension": 1}, ["--rank-tolerance", "1e-6", "--dimension", "1"]),
    ],
)  # fmt: skip
def test_options_of_a_spectrum_are_those_of_the_program(tmp_path, given, options):
    series = logistic()
    np.savetxt(tmp_path / "series.txt", series, fmt="%.17g")
    found = ss.lyapunov_from_data(series, **given)
    run = [PROGRAM, "spectrum", "series.txt", "--dt", "1", "--csv", *options]
    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=True)
    rows = list(csv.DictReader(done.stdout.splitlines()))
    assert [float(row["exponent"]) for row in rows] == found.exponents.tolist()
    assert [float(row["stderr"]) for row in rows] == found.std_errors.tolist()
    assert [row["status"] for row in rows] == found.status


def test_a_spectrum_is_compared_with_a_divergence_and_with_noise():
    series = logistic(1500)
    found = ss.lyapunov_from_data(series, dimension=1, divergence=np.log(2), surrogates=19)
    others, excess, error = found.balance
    assert others == 0 and abs(excess) < 5 * error < 0.5
    assert found.surrogate_p == pytest.approx(0.05) and found.surrogate_residuals.shape == (19,)
    assert found.residual_ratio < found.surrogate_residuals.min()
    assert ss.lyapunov_from_data(series, dimension=1).balance is None


def test_columns_of_a_series_are_chosen_by_number_and_by_name():
    import pandas as pd

    series = logistic(1500)
    frame = pd.DataFrame({"noise": np.zeros(1500), "x": series})
    wanted = ss.lyapunov_from_data(series, dimension=1).exponents
    for columns in ([1], ["x"]):
        found = ss.lyapunov_from_data(frame, columns=columns, dimension=1)
        assert np.array_equal(found.exponents, wanted)
    for given, said in (
        ({"columns": ["z"]}, "there is no column 'z' of series: they are noise, x"),
        ({"columns": [2]}, "columns = 2: it must be less than the 2 columns"),
        ({"neighbours": 5, "eps": 0.1}, "takes the nearest points and no ball"),
        ({"estimator": "wolf"}, "estimator = 'wolf': it is extrapolated or sano-sawada"),
        ({"surrogates": 3}, "surrogates = 3"),
    ):
        with pytest.raises(ValueError, match=said):
            ss.lyapunov_from_data(frame, **given)


def test_orbits_of_the_program_from_a_table_have_the_same_bits(tmp_path):
    mu0, vp = ss.parameters(mu0=0.4, vp=0.2)
    belt = ss.Contact("belt", v - vp, lambda side: mu0 / (1 + 3 * side * (v - vp)))
    system = ss.System({x: v, v: -x - 0.05 * v - belt.friction}, contacts=[belt], start=[0.5, 0])
    starts = np.linspace(-1, 1, 5)
    speeds = np.array([0.1, 0.2, 0.1, 0.3, 0.2])
    rows = [f"{a!r},{b!r}" for a, b in zip(starts.tolist(), speeds.tolist())]
    (tmp_path / "starts.csv").write_text("\n".join(["x,vp", *rows]), encoding="utf-8")
    run(tmp_path, system, "simulate", "--starts", "starts.csv", "--t-end", "20")
    both = np.stack([starts, np.zeros(5)], axis=-1)
    found = ss.ensemble(system, both, (0, 20), parameters={vp: speeds})
    ends = table(tmp_path, "orbits")
    assert [float(row["x_end"]) for row in ends] == found.y_end[0].tolist()
    assert [float(row["vp"]) for row in ends] == speeds.tolist()
    changes = table(tmp_path, "transitions")
    assert [int(row["orbit"]) - 1 for row in changes] == found.transitions["orbit"].tolist()
    assert [float(row["t"]) for row in changes] == found.transitions["t"].tolist()


@pytest.mark.parametrize(
    ("of", "exact"),
    [
        (lambda x, y: np.arctan2(x, y), np.arctan2),
        (lambda x, y: np.arcsin(x / 3) + y, lambda x, y: np.arcsin(x / 3) + y),
        (lambda x, y: np.arccos(x / 3) * y, lambda x, y: np.arccos(x / 3) * y),
        (lambda x, y: np.hypot(x, y), np.hypot),
        (lambda x, y: np.log10(2 + x * y), lambda x, y: np.log10(2 + x * y)),
        (lambda x, y: np.clip(x + y, -0.5, 0.5), lambda x, y: np.clip(x + y, -0.5, 0.5)),
    ],
)
def test_functions_of_numpy_have_their_values(of, exact):
    """Of constant states a third one grows by the value of the function."""
    z = ss.state("z")
    system = ss.System({x: 0.0, y: 0.0, z: of(x, y)})
    for a, b in ((0.3, 0.7), (-0.4, 0.2), (0.5, -0.9), (-0.8, -0.6), (0.1, -1.0)):
        end = ss.solve_ivp(system, (0, 1), [a, b, 0]).y[2, -1]
        assert abs(end - exact(a, b)) < 1e-13
