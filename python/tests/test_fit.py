"""Fits: truth from records of exact runs, SciPy's least squares, refusals."""

from dataclasses import replace

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
import stickslip as ss
from scipy.optimize import least_squares

matplotlib.use("agg")

x, v = ss.states("x v")
mu, fall, speed = ss.parameters(mu=0.44, fall=1.1, speed=0.3)
belt = ss.Contact("belt", boundary=v - speed)
FALLING = mu / (1 + fall * belt.side * (v - speed))
BLOCK = ss.System({x: v, v: -x - belt.side * FALLING}, contacts=[belt], start=[0.2, 0.9])
TIMES = np.linspace(0.25, 15, 60)


def record(seed=None, sigma=0.002):
    sol = ss.solve_ivp(BLOCK.with_parameters(mu=0.5, fall=1.0), (0, 15), t_eval=TIMES)
    noise = 0.0 if seed is None else np.random.default_rng(seed).normal(0, sigma, TIMES.size)
    return {"t": TIMES, "x": sol.y[0] + noise, "v": sol.y[1] + 3 * noise}


def test_an_exact_record_gives_back_what_made_it():
    found = ss.fit(BLOCK, record(), [mu, "fall", x], {"x": x, "v": v})
    assert found.success and found.names == ["mu", "fall", "x"]
    assert np.allclose(found.x, [0.5, 1.0, 0.2], rtol=0, atol=1e-8)
    assert found[mu] == found["mu"] == found.values["mu"]


@pytest.mark.parametrize(
    ("loss", "scale"), [("squares", 1.0), ("soft_l1", 1.2), ("huber", 1.5)]
)
def test_the_minimum_is_that_of_scipy(loss, scale):
    data = record(seed=3)
    data["x"][[7, 30]] += 0.05
    bounds = {mu: (0.1, 0.9), fall: (0.2, 0.97)}
    start = {fall: 0.9}
    ours = ss.fit(
        BLOCK, data, [mu, fall], {"x": x}, sigma=0.002, bounds=bounds, start=start, loss=loss,
        loss_scale=scale,
    )  # fmt: skip

    def run(p):
        system = BLOCK.with_parameters(mu=p[0], fall=p[1])
        return ss.solve_ivp(system, (0, 15), t_eval=TIMES, derivatives=[mu, fall])

    theirs = least_squares(
        lambda p: (run(p).y[0] - data["x"]) / 0.002,
        [0.44, 0.9],
        jac=lambda p: run(p).dy[0] / 0.002,
        bounds=([0.1, 0.2], [0.9, 0.97]),
        loss={"squares": "linear"}.get(loss, loss),
        f_scale=scale,
        xtol=1e-14,
        ftol=1e-14,
        gtol=1e-12,
    )
    assert np.allclose(ours.x, theirs.x, rtol=0, atol=2e-7)
    assert abs(ours.cost - theirs.cost) < 1e-6 * theirs.cost


def test_standard_errors_are_those_of_the_derivatives():
    data = record(seed=5)
    found = ss.fit(BLOCK, data, [mu, fall], {"x": x}, sigma=0.002)
    system = BLOCK.with_parameters(**found.values)
    slopes = ss.solve_ivp(system, (0, 15), t_eval=TIMES, derivatives=[mu, fall]).dy[0]
    covariance = 0.002**2 * np.linalg.inv(slopes.T @ slopes)
    assert np.allclose(found.covariance, covariance, rtol=1e-6)
    assert np.allclose(found.std_errors, np.sqrt(np.diag(covariance)), rtol=1e-6)
    assert np.allclose(np.diag(found.correlations), 1)
    half = 1.959964 * found.std_errors
    assert np.allclose(found.intervals, np.c_[found.x - half, found.x + half], rtol=1e-6)


def test_offsets_missing_values_and_several_records():
    off, = ss.parameters(off=0.0)  # fmt: skip
    first, second = record(seed=1), record(seed=2)
    first["x"] = first["x"] + 0.1
    first["x"][4] = np.nan
    records = [first, ss.Record(second)]
    found = ss.fit(BLOCK, records, [mu, fall, off], {"x": x + off}, each=[off])
    assert found.names == ["mu", "fall", "off@1", "off@2"]
    assert abs(found["off@1"] - 0.1) < 0.01 and abs(found["off@2"]) < 0.01
    assert np.isnan(found.residuals[0]["x"][4]) and len(found.t) == 2
    axes = found.plot(1)
    assert len(axes) == 2
    told = repr(found)
    assert "off@1" in told and "±" in told and "rms" in told


def test_phases_of_the_data_stand_beside_those_of_the_fit():
    found = ss.fit(BLOCK, record(seed=1), [mu, fall], {"x": x, "v": v})
    shown = found.seen[0]["belt"]
    assert shown.same and shown.sticks[0] == sum("S" in phase[2] for phase in found.phases[0])
    for one, other in zip(shown.data, shown.fit):
        assert abs(one[1] - other[1]) <= TIMES[2] - TIMES[0]
    assert "belt from v: " in repr(found) and "as at the fit" in repr(found)
    axes = found.plot()
    assert "sticks in the data" in axes[2].get_legend_handles_labels()[1]
    assert found.phases_off[0]["x"] == []
    # Friction that is too low sticks less.
    wrong = ss.fit(BLOCK.with_parameters(mu=0.3), record(seed=1), [x], {"x": x}, sigma=0.002)
    assert wrong.phases_off[0]["x"] and "too large in" in repr(wrong)
    alone = ss.fit(BLOCK, record(seed=1), [mu, fall], {"x": x * v})
    assert alone.seen == [{}]


def test_a_fit_prints_what_the_program_prints():
    found = ss.fit(BLOCK, record(seed=1), [mu, fall], {"x": x}, most_runs=2)
    assert not found.success and found.ending == "not converged"
    told = repr(found)
    assert ", no minimum:" in told and "not converged: " in told
    assert not found.doubtful and "doubtful" not in told and "mismatch" not in told
    more = {"no_errors": None, "bend": 0.42, "doubtful": True, "mismatch": 2e-3}
    found = replace(found, **more, changes=(2, 1, 3), others=[([0.4, 0.9], 3.0)])
    told = repr(found)
    for words in (
        "errors doubtful: within one of them the model departs from a linear one by 42 %",
        "another minimum: mu = 0.4, fall = 0.9, cost 3.0000e+00",
        "changed in 2 steps; the residuals jumped at 1 changes; grazing impacts",
        "at which they have a square root: 3",
        "mismatch 2e-03 of the spread",
    ):
        assert words in told, told


def test_values_of_other_minima_on_their_bounds_are_marked():
    # The data are those of k² = 1: both signs of k are minima, and the bounds cut one of them off.
    (k,) = ss.parameters(k=0.5)
    spring = ss.System({x: v, v: -k * k * x}, start=[1, 0])
    t = np.linspace(0.1, 4, 40)
    bounds = {k: (-0.9, 1.5)}
    found = ss.fit(spring, {"t": t, "x": np.cos(t)}, [k], {"x": x}, bounds=bounds, search=20)
    assert found.bounds.tolist() == [[-0.9, 1.5]] and found.at_bound == [False]
    assert abs(found["k"] - 1) < 1e-9
    assert [-0.9] in [values for values, _ in found.others]
    assert "another minimum: k = -0.9 (on its bound), cost" in repr(found)
    frame = found.to_pandas()
    assert frame["lower_bound"].tolist() == [-0.9] and frame["upper_bound"].tolist() == [1.5]
    inside = replace(found, others=[([-0.5], 3.0)])
    assert "another minimum: k = -0.5, cost" in repr(inside)


def test_values_at_impacts_have_no_standard_error_and_the_event_is_named():
    h, w = ss.states("h w")
    g, = ss.parameters(g=10.0)  # fmt: skip
    bounce = ss.Jump("bounce", when=h, direction="falling", set={w: -0.8 * w})
    ball = ss.System({h: w, w: -g}, jumps=[bounce], start=[1, 0])
    fall = np.sqrt(2 / 9.81)
    after = 9.81 * fall * 0.8 ** np.arange(1, 7)
    times = fall + np.concatenate([[0], np.cumsum(2 * after[:-1] / 9.81)])
    noise = [-0.004, 0.007, -0.01, -0.002, 0.005, -0.001]
    data = {"t": times, "w": after + noise}
    found = ss.fit(ball, data, [g], {"w": w}, sigma=0.01)
    assert abs(found["g"] - 9.81) < 0.03 and np.isnan(found.std_errors).all()
    assert "the value of w at " in found.no_errors
    assert "the event `bounce` at " in repr(found)


def test_a_record_has_an_input_of_its_own():
    gain, = ss.parameters(gain=1.0)  # fmt: skip
    u = ss.table("u", [0, 4], [1, 1])
    integrator = ss.System({x: gain * u}, start=[0])
    t = np.array([1.0, 2.0, 4.0])
    one, two = {"t": t, "x": 3 * t}, {"t": t, "x": 6 * t}
    for key in (u, "u"):
        own = ss.Record(two, inputs={key: ([0, 4], [2, 2])})
        found = ss.fit(integrator, [one, own], [gain], {"x": x}, sigma=0.01)
        assert abs(found["gain"] - 3) < 1e-9 and found.cost < 1e-9
    for inputs, error, said in [
        ({"w": ([0, 4], [2, 2])}, ss.SystemError, "there is no input `w`"),
        ({"u": ([0, 4], [2])}, ss.SystemError, "2 times and 1 values"),
        ({"u": 3}, TypeError, r"inputs\[u\] must be \(times, values\), not 3"),
        ({"u": ([0, 4], [0, np.nan])}, ValueError, r"inputs\[u\]"),
        ([3], TypeError, "inputs must be a dict"),
    ]:
        with pytest.raises(error, match=said):
            ss.fit(integrator, ss.Record(two, inputs=inputs), [gain], {"x": x})


def test_what_cannot_be_fitted_is_refused():
    data = record(seed=1)
    for given, said in [
        ({"fit": ["nu"]}, "neither a parameter nor a state"),
        ({"observe": {"y": x}}, "has no column 'y'"),
        ({"bounds": {"x": (0, 1)}}, "which is not among fit"),
        ({"sigma": {"y": 1.0}}, "no column of observe"),
        ({"loss": "cauchy"}, "it must be one of"),
        ({"search": 3}, "has no bounds to search within"),
        ({"data": {"t": TIMES[::-1], "x": data["x"]}}, "does not come after"),
        ({"data": {"t": TIMES, "x": data["x"][1:]}}, "one for each time"),
        ({"data": {"t": TIMES[:2], "x": [np.nan, 0.1]}}, "cannot determine"),
    ]:
        arguments = {"data": data, "fit": [mu], "observe": {"x": x}} | given
        with pytest.raises(ValueError, match=said):
            ss.fit(BLOCK, **arguments)
    with pytest.raises(TypeError, match="observe must be a dict"):
        ss.fit(BLOCK, data, [mu], x)
    with pytest.raises(TypeError, match="neither a parameter"):
        ss.fit(BLOCK, data, [3], {"x": x})
    escaping = ss.System({x: x * x}, start=[1])
    a, = ss.parameters(a=1.0)  # fmt: skip
    with pytest.raises(ss.StickslipError, match="start elsewhere"):
        ss.fit(escaping, data, [a], {"x": a * x})


def test_records_of_pandas_are_records():
    data = record()
    wanted = ss.fit(BLOCK, data, [mu], {"x": x}).x
    frame = pd.DataFrame(data)
    series = frame.set_index("t")["x"]
    for same in (
        frame,
        frame.set_index("t"),
        frame.rename(columns={"t": "time"}),
        frame.rename(columns={"t": "time"}).set_index("time"),
        frame.to_records(),
        series,
        series.rename(None),
    ):
        assert np.array_equal(ss.fit(BLOCK, same, [mu], {"x": x}).x, wanted)
    with pytest.raises(ValueError, match=r"data.rename_axis\(\"t\"\)"):
        ss.fit(BLOCK, frame.set_index("t").rename_axis(None), [mu], {"x": x})
    with pytest.raises(ValueError, match="is a Series called 'x'"):
        ss.fit(BLOCK, series, [mu], {"v": v})


def test_the_start_of_a_record_has_names_or_the_order_of_the_states():
    data = record()
    wanted = ss.fit(BLOCK, data, [mu], {"x": x}).x
    for y0 in ([0.2, 0.9], np.array([0.2, 0.9]), {x: 0.2}, pd.Series([0.2, 0.9], ["x", "v"])):
        found = ss.fit(BLOCK, ss.Record(data, y0=y0), [mu], {"x": x})
        assert np.array_equal(found.x, wanted)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"bounds": [(0, 1)]}, r'bounds must be a dict, as \{"mu": \(0, 1\)\}'),
        ({"bounds": {mu: 1}}, r"bounds\[mu\] must be \(lowest, highest\)"),
        ({"start": [0.3]}, r'start must be a dict, as \{"mu": 0.5\}'),
        ({"data": "data.csv"}, r"pandas.read_csv\('data.csv'\)"),
        ({"data": (TIMES, TIMES)}, r"record 1 must be a dict.*, not ndarray"),
        ({"data": ss.Record(record(), y0=3)}, r'y0 must be a dict, as \{"x": 0.1\}'),
        ({"data": ss.Record(record(), y0=[1])}, "y0 has 1 values, and there are 2 states"),
        ({"data": ss.Record(record(), parameters=[3])}, "parameters must be a dict"),
    ],
)
def test_arguments_of_another_kind_are_refused_with_an_example(given, said):
    arguments = {"data": record(), "fit": [mu], "observe": {"x": x}} | given
    with pytest.raises((TypeError, ValueError), match=said):
        ss.fit(BLOCK, **arguments)


def test_values_and_axes_of_a_fit():
    found = ss.fit(BLOCK, record(), [mu], {"x": x})
    with pytest.raises(KeyError, match="there is no fitted value 'nu': they are mu"):
        found["nu"]
    figure, axes = plt.subplots(2)
    assert list(found.plot(axes=axes)) == list(axes)
    with pytest.raises(TypeError, match="plot.axes=axes"):
        found.plot(axes)
    with pytest.raises(ValueError, match="has 2, data and residuals"):
        found.plot(axes=axes[0])
    with pytest.raises(ValueError, match="record = 1"):
        found.plot(1)
    plt.close(figure)
