"""Orbits from many starts, with the bits of single runs."""

import numpy as np
import pytest
import stickslip as ss

x, v = ss.states("x v")
mu0, vp = ss.parameters(mu0=0.4, vp=0.2)
belt = ss.Contact("belt", boundary=v - vp, friction=lambda side: mu0 / (1 + 3 * side * (v - vp)))
BLOCK = ss.System({x: v, v: -x - 0.05 * v - belt.friction}, contacts=[belt], start=[0.5, 0])
STARTS = np.stack([np.linspace(-1, 1, 37), np.linspace(0.5, -0.5, 37)], axis=-1)


def bouncing():
    wall = ss.Jump("wall", when=x, direction=-1, set={v: -0.8 * v})
    return ss.System({x: v, v: -1.0}, jumps=[wall])


SYSTEMS = {
    "block": (BLOCK, STARTS),
    "smooth": (ss.System({x: v, v: -x - x**3}), STARTS),
    "jumps": (bouncing(), np.stack([np.linspace(1, 2, 20), np.zeros(20)], axis=-1)),
}


@pytest.mark.parametrize("method", ["taylor", "dop853"])
@pytest.mark.parametrize("name", SYSTEMS)
def test_each_orbit_has_the_bits_of_a_single_run(name, method):
    system, starts = SYSTEMS[name]
    times = np.linspace(0, 4, 9)
    options = {"method": method, "rtol": 1e-9}
    found = ss.ensemble(system, starts, (0, 4), times, events=v, **options)
    assert found.y.shape == (2, len(starts), 9) and found.success.all()
    for k, start in enumerate(starts):
        alone = ss.solve_ivp(system, (0, 4), start, t_eval=times, events=v, **options)
        assert found.y[:, k].tobytes() == alone.y.tobytes()
        assert found.t_events[0][k].tobytes() == alone.t_events[0].tobytes()
        assert found.y_events[0][k].tobytes() == alone.y_events[0].tobytes()
        for table in ("transitions", "phases"):
            own = getattr(found, table)
            own, wanted = own[own["orbit"] == k], getattr(alone, table)
            for column in wanted.dtype.names:
                assert np.array_equal(own[column], wanted[column]), column
        assert (found.nfev[k], found.status[k]) == (alone.nfev, alone.status)
    # Ends alone are the same, without the solution over steps.
    ends = ss.ensemble(system, starts, (0, 4), **options)
    assert ends.y.shape == (2, len(starts), 1)
    assert ends.y[:, :, 0].tobytes() == found.y[:, :, -1].tobytes() == ends.y_end.tobytes()


def test_the_number_of_threads_changes_no_bit():
    one, all = (ss.ensemble(BLOCK, STARTS, (0, 20), workers=workers) for workers in (1, -1))
    assert one.y.tobytes() == all.y.tobytes()
    assert one.transitions.tobytes() == all.transitions.tobytes()


def test_parameters_are_those_of_each_orbit():
    speeds = np.tile([0.1, 0.2, 0.3], 6)
    found = ss.ensemble(BLOCK, None, (0, 10), parameters={vp: speeds, "mu0": 0.3})
    assert found.y0.shape == (2, 18) and np.array_equal(found.parameters["vp"], speeds)
    for k in (0, 4, 17):
        alone = ss.solve_ivp(BLOCK.with_parameters(vp=speeds[k], mu0=0.3), (0, 10), t_eval=[10])
        assert found.y[:, k, 0].tobytes() == alone.y[:, -1].tobytes()
    single = ss.ensemble(BLOCK, [0.1, 0.0], (0, 10), parameters={vp: [0.1, 0.2]})
    assert single.y0.T.tolist() == [[0.1, 0.0], [0.1, 0.0]]


def test_a_start_that_depends_on_a_parameter_goes_with_it():
    p = ss.parameter("p", 1.0)
    system = ss.System({x: -p * x}, start=[2 * p])
    found = ss.ensemble(system, None, (0, 1), parameters={p: [1.0, 3.0]})
    assert np.allclose(found.y[0, :, 0], [2 * np.exp(-1), 6 * np.exp(-3)], rtol=1e-12)


def test_orbits_end_where_single_runs_end_and_nan_follows():
    stop = ss.event(x, direction=-1, terminal=2)
    times = np.linspace(0, 20, 41)
    found = ss.ensemble(BLOCK, STARTS, (0, 20), times, events=[stop, v])
    ended = found.status == 1
    assert ended.any()
    for k in np.flatnonzero(ended):
        behind = times > found.t_end[k]
        assert np.isnan(found.y[:, k, behind]).all() and np.isfinite(found.y[:, k, ~behind]).all()
        assert found.t_events[0][k][-1] == found.t_end[k] and len(found.t_events[0][k]) == 2


def test_a_failure_keeps_the_others():
    grows = ss.System({x: x * x})
    with pytest.warns(ss.SolverWarning, match=r"1 of 3 runs failed; the first, at orbit 1, from"):
        found = ss.ensemble(grows, [[0.1], [2.0], [-1.0]], (0, 1))
    assert found.status.tolist() == [0, -1, 0] and "escape" in found.message[1]
    assert np.isnan(found.y[0, 1, 0]) and np.isclose(found.y[0, 2, 0], -0.5)
    assert 0.4 < found.t_end[1] < 0.5 and np.isnan(found.nfev[1])


@pytest.mark.parametrize("starts", [None, [0.3, 0.0]])
def test_the_orbit_of_a_value_that_is_not_allowed_is_named(starts):
    text = BLOCK.to_toml().replace("vp = 0.2", "vp = { value = 0.2, range = [0.05, 1] }")
    ranged = ss.System.from_toml(text)
    with pytest.raises(ss.SystemError, match="^orbit 2: vp = 5 is not allowed: its range"):
        ss.ensemble(ranged, starts, (0, 1), parameters={vp: [0.1, 0.2, 5, 0.3]})


def test_what_is_reduced_is_that_of_single_runs():
    def measure(sol):
        return [sol.t.size, len(sol.transitions), sol.y[0].max()]

    found = ss.ensemble(BLOCK, STARTS[:5], (0, 10), reduce=measure)
    assert found.y is None and found.reduced.shape == (5, 3)
    alone = [measure(ss.solve_ivp(BLOCK, (0, 10), start)) for start in STARTS[:5]]
    assert np.array_equal(found.reduced, alone)
    ragged = ss.ensemble(BLOCK, STARTS[:5], (0, 10), reduce=lambda sol: sol.transitions["t"])
    assert [len(one) for one in ragged.reduced] == found.reduced[:, 1].tolist()


def test_an_error_of_the_function_is_raised():
    with pytest.raises(ZeroDivisionError):
        ss.ensemble(BLOCK, STARTS[:2], (0, 1), reduce=lambda sol: 1 / 0)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"starts": [[0.0]]}, "the last axis of starts must be the 2 states"),
        ({"parameters": {"vp": [0.1, 0.2]}}, "2 of vp and 3 starts"),
        ({"parameters": {"nu": 1.0}}, "there is no parameter nu: there are"),
        ({"t_eval": [0, 2]}, r"t_eval\[1\] = 2: it must be within t_span"),
        ({"t_eval": [0.5, 0.5]}, "t_eval are not sorted"),
        ({"t_span": (1, 0)}, r"t_span\[1\] = 0"),
        ({"workers": 0}, "workers"),
    ],
)
def test_wrong_arguments_are_refused(given, said):
    with pytest.raises(ValueError, match=said):
        ss.ensemble(**{"system": BLOCK, "starts": STARTS[:3], "t_span": (0, 1), **given})


def test_tables_of_an_ensemble():
    times = [0.5, 1.0]
    found = ss.ensemble(BLOCK, STARTS[:4], (0, 1), times, parameters={vp: [0.1, 0.2, 0.3, 0.4]})
    frame = found.to_pandas()
    assert frame.shape == (8, 2) and frame.loc[(3, 1.0), "v"] == found.y[1, 3, 1]
    data = found.to_xarray()
    assert data.y.dims == ("state", "orbit", "t") and data.vp.dims == ("orbit",)
    assert float(data.y.sel(state="v", t=1.0)[3]) == found.y[1, 3, 1]
    assert "<table>" in found._repr_html_()
