"""Runs: SciPy's conventions, closed forms, and the program's bits."""

import json
import os
import pickle
import subprocess
import sys

import numpy as np
import pytest
import stickslip as ss
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp as of_scipy


def belt_system():
    x, v = ss.states("x v")
    belt = ss.Contact("belt", boundary=v - 0.2)
    rate = -x - belt.side * 0.4 / (1 + belt.side * (v - 0.2))
    return ss.System({x: v, v: rate}, contacts=[belt])


def oscillator():
    x, v = ss.states("x v")
    return ss.System({x: v, v: -x}, start=[1, 0])


@pytest.mark.parametrize("name", ["belt", "forced", "bracket", "leine", "basins", "den-hartog"])
def test_bits_are_those_of_the_program(name, tmp_path):
    program = os.environ.get("STICKSLIP")
    if not program:
        pytest.skip("STICKSLIP does not name the program; `make python-test` does")
    system = ss.System.from_toml(name)
    start = system.start or [0.3] * len(system.states)
    given = [f"--start={state}={value!r}" for state, value in zip(system.states, start)]
    options = [*given, "--t-end", "30", "--out", str(tmp_path), "--json"]
    done = subprocess.run([program, "simulate", name, *options], capture_output=True, check=True)
    told = json.loads(done.stdout)
    sol = ss.solve_ivp(system, (0, 30), start)
    assert len(told["transitions"]) == len(sol.transitions) and len(sol.t) > 20
    for wanted, found in zip(told["transitions"], sol.transitions):
        assert wanted["t"] == found["t"] and wanted["kind"] == found["kind"]
        assert wanted["contact"] == found["contact"]
        assert [wanted["x"][state] for state in system.states] == found["y"].tolist()
    steps = np.genfromtxt(tmp_path / "steps.csv", delimiter=",", skip_header=1)
    assert np.array_equal(steps, np.vstack([sol.t, sol.y]).T)
    assert told["phases"] == len(sol.phases)


def test_shapes_and_types_are_those_of_scipy():
    x, times = ss.state("x"), np.linspace(0, 5, 11)
    ours = ss.solve_ivp(oscillator(), (0, 5), t_eval=times, dense_output=True, events=[x, x - 9])
    theirs = of_scipy(
        lambda t, y: [y[1], -y[0]], (0, 5), [1, 0], t_eval=times, dense_output=True,
        events=[lambda t, y: y[0], lambda t, y: y[0] - 9], rtol=1e-10, atol=1e-10,
    )  # fmt: skip
    for name in ("t", "y"):
        one, other = getattr(ours, name), getattr(theirs, name)
        assert one.shape == other.shape and one.dtype == other.dtype
        assert np.allclose(one, other, atol=1e-8)
    assert [one.shape for one in ours.t_events] == [one.shape for one in theirs.t_events]
    assert ours.y_events[0].shape == theirs.y_events[0].shape
    assert np.allclose(ours.t_events[0], [np.pi / 2, 3 * np.pi / 2], rtol=0, atol=1e-12)
    for at in (1.3, times):
        assert ours.sol(at).shape == theirs.sol(at).shape
        assert np.allclose(ours.sol(at), theirs.sol(at), atol=1e-8)
    assert (ours.status, ours.success) == (theirs.status, theirs.success)
    assert isinstance(ours.nfev, int) and len(repr(ours)) < 120


def test_terminal_events_end_the_run_where_they_are():
    x = ss.state("x")
    up, down = ss.event(x, direction=1, terminal=True), ss.event(x, direction=-1)
    for events in ([up, down], [down, up]):
        sol = ss.solve_ivp(oscillator(), (0, 50), events=events, dense_output=True)
        ends = sol.t_events[events.index(up)]
        assert sol.status == 1 and len(ends) == 1 and sol.t[-1] == ends[0] == sol.sol.t_max
        assert ends[0] == pytest.approx(1.5 * np.pi, abs=1e-12)
        assert len(sol.t_events[events.index(down)]) == 1
    third = ss.event(x, terminal=3)
    assert len(ss.solve_ivp(oscillator(), (0, 50), events=third).t_events[0]) == 3


def test_events_do_not_change_the_orbit():
    x, v = ss.states("x v")
    plain = ss.solve_ivp(belt_system(), (0, 40), [0.5, 0])
    watched = ss.solve_ivp(belt_system(), (0, 40), [0.5, 0], events=[x - 0.1, v, x * v - 0.01])
    assert np.array_equal(plain.t, watched.t) and np.array_equal(plain.y, watched.y)
    assert all(len(found) > 3 for found in watched.t_events)


def test_events_of_one_run_are_those_of_runs_of_their_own():
    x, v = ss.states("x v")
    events = [ss.event(x - 0.1 * k, direction=k % 3 - 1) for k in range(12)] + [x * v, v - 0.2]
    together = ss.solve_ivp(belt_system(), (0, 40), [0.5, 0], events=events)
    for one, found in zip(events, together.t_events):
        alone = ss.solve_ivp(belt_system(), (0, 40), [0.5, 0], events=one)
        assert np.array_equal(alone.t_events[0], found)
    assert sum(map(len, together.t_events)) > 50


def test_a_stop_ends_the_run_wherever_it_stands_in_the_list():
    x = ss.state("x")
    stop = ss.event(x - 0.5, terminal=True)
    for events in ([ss.event(x - 0.2), stop], [stop, ss.event(x - 0.2)]):
        sol = ss.solve_ivp(oscillator(), (0, 1e9), [0, 1], events=events)
        assert sol.status == 1 and sol.t[-1] == pytest.approx(np.pi / 6, abs=1e-12)


def test_a_run_goes_on_from_a_solution_with_the_bits_of_one_run():
    x, v = ss.states("x v")
    (n,) = ss.discrete(n=0.0)
    # The function of the counter is left at zero: a plain state does not tell that it has counted.
    count = ss.Jump("count", when=x, direction="rising", set={n: n + 1})
    swing = ss.System({x: v, v: -x + 0 * n}, jumps=[count], start=[0, -1])
    for method in ("taylor", "dop853"):
        whole = ss.solve_ivp(swing, (0, 20), method=method)
        cuts = [0, 1, np.pi, 3 * np.pi, 12.3, 12.4, 20]
        sol = None
        for begin, end in zip(cuts, cuts[1:]):
            sol = ss.solve_ivp(swing, (begin, end), sol, method=method)
            again = pickle.loads(pickle.dumps(sol))
            assert np.array_equal(again.y, sol.y)
        assert np.array_equal(sol.y[:, -1], whole.y[:, -1])
    with pytest.raises(ValueError, match="another method, tolerance or option"):
        ss.solve_ivp(swing, (20, 21), sol, method="taylor")
    with pytest.raises(ValueError, match="t_span begins at 19"):
        ss.solve_ivp(swing, (19, 21), sol, method="dop853")
    stopped = ss.solve_ivp(swing, (0, 20), events=ss.event(v, terminal=True))
    with pytest.raises(ValueError, match="has not reached its end time"):
        ss.solve_ivp(swing, (stopped.t[-1], 21), stopped)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"y0": [np.nan, 0]}, r"y0\[0\] = nan"),
        ({"t_span": (0, np.inf)}, r"t_span\[1\] = inf"),
        ({"t_span": (1, 1)}, r"t_span\[1\] = 1: it must be other than t_span\[0\] = 1"),
        ({"y0": [1, 0, 0]}, "3 values.*2 states: x, v"),
        ({"t_eval": [0, 2]}, r"t_eval\[1\] = 2: it must be within t_span, 0 to 1"),
        ({"t_eval": [0, 0.5, 0.5]}, r"not sorted.*t_eval\[2\] = 0.5 follows 0.5"),
        ({"rtol": 1.0}, "rtol = 1 is not allowed"),
        ({"max_step": 0}, "max_step = 0 is not allowed"),
        ({"atol": [1e-9]}, "atol has 1 values: give one number for all states, or one for each"),
        ({"atol": [1e-9] * 3}, "atol has 3 values"),
        ({"atol": []}, "atol has 0 values"),
        ({"atol": [1e-9, -1e-9]}, "atol = -1e-9 is not allowed: it must be between 1e-280 and 0.1"),
        ({"t_span": (0, 1, 2)}, "t_span has 3 values"),
        ({"y0": {"x": 1, "u": 0}}, "a value of u, which is no state"),
        ({"y0": [[1, 0]]}, r"its shape is \(1, 2\)"),
        ({"method": "RK45"}, 'method = "RK45"'),
    ],
)
def test_what_cannot_be_is_refused_by_name(options, words):
    with pytest.raises(ValueError, match=words):
        ss.solve_ivp(oscillator(), **{"t_span": (0, 1), **options})


@pytest.mark.filterwarnings("ignore:the state y stays")
def test_each_state_may_have_its_own_absolute_tolerance(tmp_path):
    """The second state, exp(sin 40t - t) of 1e-8, is as exact as its own tolerance asks."""
    x, y = ss.states("x y")
    system = ss.System({x: -x, y: y * (40 * np.cos(40 * ss.t) - 1)}, start=[1, 1e-8])
    exact = 1e-8 * np.exp(np.sin(40) - 1)

    def error(atol, **options):
        sol = ss.solve_ivp(system, (0, 1), rtol=1e-12, atol=atol, **options)
        return abs(sol.y[1, -1] / exact - 1)

    for method in ("taylor", "dop853"):
        assert error([1e-6, 1e-18], method=method) < 1e-7
        assert min(error(1e-6, method=method), error([1e-18, 1e-6], method=method)) > 1e-5
    one, two = (ss.solve_ivp(system, (0, 1), atol=atol) for atol in (1e-9, np.full(2, 1e-9)))
    assert np.array_equal(one.y, two.y)
    # In a file, and of all functions that run orbits.
    text = system.to_toml().replace('x = ""', 'x = { unit = "", atol = 1e-5 }')
    assert "atol" in text
    path = tmp_path / "loose.toml"
    path.write_text(text, encoding="utf-8")
    loose, given = ss.System.from_toml(path), [1e-5, 1e-12]
    run = ss.solve_ivp
    assert np.array_equal(run(loose, (0, 1)).y, run(system, (0, 1), atol=given).y)
    assert not np.array_equal(run(loose, (0, 1), atol=1e-12).y, run(loose, (0, 1)).y)
    ends = [ss.ensemble(loose, [[1, 1e-8]], (0, 1)), ss.ensemble(system, None, (0, 1), atol=given)]
    assert np.array_equal(ends[0].y[:, 0], ends[1].y[:, 0])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"system": lambda t, y: y}, "System, not function; write the right-hand side"),
        ({"y0": [None, 0]}, "y0 must be real numbers, not None"),
        ({"rtol": "small"}, "rtol must be a number, not 'small'"),
        ({"most_steps": 1.5}, "most_steps must be a whole number, not 1.5"),
        ({"args": (1,)}, "'args' is no option: values are parameters"),
        ({"events": lambda t, y: y[0]}, "an event is a formula of symbols"),
    ],
)
def test_what_is_of_another_type_is_refused_by_name(options, words):
    with pytest.raises(TypeError, match=words):
        ss.solve_ivp(**{"system": oscillator(), "t_span": (0, 1), **options})


def test_a_start_may_be_given_by_the_states():
    x, v = ss.states("x v")
    wanted = ss.solve_ivp(oscillator(), (0, 1), [2, 3])
    assert np.array_equal(ss.solve_ivp(oscillator(), (0, 1), {v: 3, x: 2}).y, wanted.y)
    # The others start as the system says.
    wanted = ss.solve_ivp(oscillator(), (0, 1), [1, 3])
    assert np.array_equal(ss.solve_ivp(oscillator(), (0, 1), {"v": 3}).y, wanted.y)


def test_a_start_may_leave_out_discrete_states():
    x = ss.state("x")
    n, m = ss.discrete(n=2.0, m=ss.parameter("p", 0.5))
    jump = ss.Jump("hit", when=x - 9, set={x: 0, n: n + 1, m: 0})
    system = ss.System({x: n + m - x}, jumps=[jump])
    assert system.states == ("x", "m", "n") and system.start is None
    wanted = ss.solve_ivp(system, (0, 1), [0.1, 0.5, 2])
    for y0 in ([0.1], {x: 0.1}, {"x": 0.1, n: 2}):
        assert np.array_equal(ss.solve_ivp(system, (0, 1), y0).y, wanted.y)
    changed = ss.solve_ivp(system.with_parameters(p=1.5), (0, 0.1), [0.1])
    assert changed.y[1, 0] == 1.5
    for y0 in ([0.1, 2], [0.1, 2, 3, 4]):
        with pytest.raises(ValueError, match="the last 2, discrete, may be left out"):
            ss.solve_ivp(system, (0, 1), y0)
    starts = np.array([[0.1], [0.7]])
    found = ss.basins_of_attraction(system, starts, longest=50)
    assert found.starts.tolist() == [[0.1, 0.5, 2], [0.7, 0.5, 2]]
    all_given = ss.basins_of_attraction(system, found.starts, longest=50)
    assert np.array_equal(found.reached, all_given.reached) and found.kind == all_given.kind
    with pytest.raises(ValueError, match="3 states: x, m, n; the last 2, discrete, may"):
        ss.basins_of_attraction(system, [[0.1, 2]])


def test_words_of_options_are_taken_in_any_case():
    wanted = ss.solve_ivp(oscillator(), (0, 1), method="dop853")
    assert np.array_equal(ss.solve_ivp(oscillator(), (0, 1), method="DOP853").y, wanted.y)


def test_any_memory_layout_and_integers_are_taken():
    wanted = ss.solve_ivp(oscillator(), (0, 1), [1.0, 2.0], t_eval=[0.0, 0.5, 1.0])
    times = np.array([1.0, 0.5, 0.0])[::-1]
    fixed = np.array([1.0, 2.0])
    fixed.flags.writeable = False
    of_others = (np.array([1, 2], dtype=np.int32), np.array([1, 2], dtype=np.float32), fixed)
    swapped = np.array([1, 2], dtype=">f8")
    for y0 in (np.array([1.0, 9.0, 2.0, 9.0])[::2], [1, 2], swapped, *of_others):
        assert np.array_equal(ss.solve_ivp(oscillator(), (0, 1), y0, t_eval=times).y, wanted.y)
    with pytest.raises(TypeError, match="must be real numbers"):
        ss.solve_ivp(oscillator(), (0, 1), [1j, 0])


def test_a_bouncing_ball_lands_when_it_must():
    h, v = ss.states("h v")
    g, r = ss.parameters(g=10.0, r=0.5)
    bounce = ss.Jump("bounce", when=h, direction="falling", set={v: -r * v})
    sol = ss.solve_ivp(ss.System({h: v, v: -g}, jumps=[bounce]), (0, 2.6), [5, 0])
    # It falls for 1, and then flies for 1, 1/2, 1/4, ... of that.
    assert np.allclose(sol.transitions["t"], [1, 2, 2.5], rtol=0, atol=1e-13)
    assert set(sol.transitions["kind"]) == {"jump"}
    assert set(sol.transitions["contact"]) == {"bounce"}
    # Both sides of a jump are in the result.
    first = np.flatnonzero(sol.t == sol.transitions["t"][0])
    assert len(first) == 2 and np.allclose(sol.y[1, first], [-10, 5])
    assert np.array_equal(sol.transitions["y_before"][0], sol.y[:, first[0]])
    assert np.array_equal(sol.transitions["y"][0], sol.y[:, first[1]])
    # A run that ends at a jump ends behind it.
    short = ss.solve_ivp(ss.System({h: v, v: -g}, jumps=[bounce]), (0, 1), [5, 0])
    assert short.t[-1] == 1 and np.allclose(short.y[:, -1], [0, 5], rtol=0, atol=1e-13)
    with pytest.warns(ss.SolverWarning, match="at `bounce`.*what comes to rest needs a stop"):
        ss.solve_ivp(ss.System({h: v, v: -g}, jumps=[bounce]), (0, 4), [5, 0])


def test_a_thermostat_switches_when_it_must():
    temperature = ss.state("temperature")
    (heater,) = ss.discrete(heater=1.0)
    on = ss.Jump("on", when=temperature - 19, direction="falling", set={heater: 1})
    off = ss.Jump("off", when=temperature - 21, direction="rising", set={heater: 0})
    house = ss.System({temperature: 10 + 20 * heater - temperature}, jumps=[on, off])
    sol = ss.solve_ivp(house, (0, 3), [19, 1])
    assert house.states == ("temperature", "heater") and house.discrete == ("heater",)
    # What a discrete state starts with is part of the system.
    for y0 in ([19], {temperature: 19}):
        assert np.array_equal(ss.solve_ivp(house, (0, 3), y0).y, sol.y)
    with pytest.raises(ValueError, match="y0 has 3 values.*the last 1, discrete, may be"):
        ss.solve_ivp(house, (0, 3), [19, 1, 0])
    starts = np.array([[18.0], [20.0]])
    basins = ss.basins_of_attraction(house, starts, longest=100)
    assert basins.starts.tolist() == [[18, 1], [20, 1]] and basins.kind == ["periodic"]
    wanted = np.log(11 / 9) * np.arange(1, 15)
    assert np.allclose(sol.transitions["t"], wanted, rtol=0, atol=1e-12)
    assert list(sol.transitions["contact"][:3]) == ["off", "on", "off"]


def test_a_block_on_a_belt_sticks_until_the_spring_is_stronger():
    sol = ss.solve_ivp(belt_system(), (0, 50), [0.5, 0], dense_output=True)
    sticks = sol.phases[sol.phases["mode"] == "S"][:-1]
    assert len(sticks) > 3 and np.allclose(sticks["y_end"][:, 0], 0.4, rtol=0, atol=1e-13)
    way = sticks["y_end"][:, 0] - sticks["y_start"][:, 0]
    assert np.allclose(sticks["t_end"] - sticks["t_start"], way / 0.2, rtol=1e-12)
    middles = 0.5 * (sticks["t_start"] + sticks["t_end"])
    assert np.allclose(sol.sol(middles)[1], 0.2, rtol=0, atol=1e-13)


def test_forces_of_a_contact_balance_the_spring_in_stick_and_are_the_law_in_slip():
    x, v = ss.states("x v")
    belt = ss.Contact("belt", boundary=v - 0.2, friction=0.4, static=0.5)
    system = ss.System({x: v, v: -x - belt.friction}, contacts=[belt], start=[0, 0.5])
    sol = ss.solve_ivp(system, (0, 30))
    (force,) = sol.forces
    for phase in sol.phases:
        within = (sol.t > phase["t_start"]) & (sol.t < phase["t_end"])
        law = {"S": -sol.y[0], "+": 0.4, "-": -0.4}[phase["mode"]]
        assert np.allclose(force[within], np.broadcast_to(law, force.shape)[within], atol=1e-12)
    assert set(sol.phases["mode"]) == {"S", "+", "-"} and np.abs(force).max() <= 0.5 + 1e-12
    assert np.array_equal(sol.to_pandas()["belt.force"], force)
    at = ss.solve_ivp(system, (0, 30), t_eval=np.linspace(0, 30, 7))
    assert at.forces.shape == (1, 7)
    # The rate of the velocity is what the forces make it.
    slopes = ss.solve_ivp(system, (0, 30), dense_output=True).sol
    t = 0.5 * (sol.t[:-1] + sol.t[1:])
    inside = ss.solve_ivp(system, (0, 30), t_eval=t)
    rate = (slopes(t + 1e-6)[1] - slopes(t - 1e-6)[1]) / 2e-6
    far = np.abs(t[:, None] - sol.transitions["t"]).min(axis=1) > 1e-5
    assert np.allclose(rate[far], (-inside.y[0] - inside.forces[0])[far], atol=1e-6)


def test_inputs_and_switches_of_time():
    x = ss.state("x")
    ramp = ss.Switch("ramp", ss.t - 1.5)
    whole = ss.square("u", period=2) + ss.sawtooth("s", period=1) + ramp.side
    whole += ss.table("w", [0, 1, 3], [0, 2, 2]) + ss.pulse("p", period=1, width=0.25)
    end = ss.solve_ivp(ss.System({x: whole}), (0, 2), [0]).y[0, -1]
    # Of the square, the sawtooth, the switch, the table and the pulse.
    assert end == pytest.approx(0 + 1 - 1 + 3 + 0.5, abs=1e-12)


def test_a_failed_run_warns_and_keeps_what_it_has():
    x = ss.state("x")
    with pytest.warns(ss.SolverWarning, match="escaped"):
        sol = ss.solve_ivp(ss.System({x: x * x}), (0, 2), [1])
    assert sol.status == -1 and not sol.success
    assert sol.t[-1] == pytest.approx(1, abs=1e-4) and sol.y[0, -1] > 1e4


def test_a_pile_up_names_its_contacts_and_the_option():
    """Filippov's spiral: |u| + |v| falls at the rate 2, in ever shorter phases."""
    u, v = ss.states("u v")
    left, right = ss.Contact("left", boundary=u), ss.Contact("right", boundary=v)
    rates = {u: -left.side + 52 * right.side, v: -52 * left.side - right.side}
    system = ss.System(rates, contacts=[left, right])
    with pytest.warns(ss.SolverWarning, match="transitions at `left`, `right`") as caught:
        ss.solve_ivp(system, (0, 9), [3, 3])
    assert 'by at_pile_up="rest" they rest' in str(caught[0].message)
    assert ss.solve_ivp(system, (0, 9), [3, 3], at_pile_up="rest").success


def test_errors_have_time_and_state():
    x = ss.state("x")
    with pytest.raises(ss.StickslipError) as raised:
        ss.solve_ivp(ss.System({x: np.log(x)}), (0, 1), [-1])
    assert raised.value.t == 0 and raised.value.y == [-1]
    assert raised.value.kind == "StartOutsideDomain"
    again = pickle.loads(pickle.dumps(raised.value))
    assert str(again) == str(raised.value) and again.y == [-1]
    with pytest.raises(ss.SystemError, match="y"):
        ss.System.from_toml("name = 'a'\n[states]\nx = ''\n[field]\nx = 'y'\n")


def test_a_future_that_is_not_unique_has_a_status_of_its_own():
    x, y = ss.states("x y")
    wall = ss.Contact("wall", boundary=x)
    system = ss.System({x: wall.side, y: 1}, contacts=[wall])
    with pytest.warns(ss.SolverWarning, match="no unique future after t = 0"):
        sol = ss.solve_ivp(system, (0, 1), [0, 0])
    assert sol.status == 2 and not sol.success and "no unique future" in sol.message


def test_nine_contacts_at_zero_are_decided_only_where_their_friction_resists_them():
    def nine(coupling):
        states = ss.states(" ".join(f"v{i}" for i in range(9)))
        contacts = [ss.Contact(f"c{i}", boundary=v, friction=1) for i, v in enumerate(states)]
        rates = {v: 0.1 - contact.friction for v, contact in zip(states, contacts)}
        for i in (0, 1):
            rates[states[i]] = rates[states[i]] - coupling * contacts[1 - i].friction
        return ss.System(rates, contacts=contacts, start=[0.0] * 9)

    # All principal minors are positive, or that of the first two is -3.
    assert list(ss.solve_ivp(nine(0.5), (0, 1)).phases["mode"]) == ["|".join("S" * 9)]
    with pytest.raises(ss.StickslipError, match="more than eight are too many to try"):
        ss.solve_ivp(nine(2), (0, 1))


def test_an_event_has_the_values_of_the_system():
    x, v = ss.states("x v")
    k, u = ss.parameter("k", 1.0), ss.square("u", period=3)
    system = ss.System({x: v, v: -x + 0 * u + 0 * k})
    for event in (x - k, x - u, ss.event(x - k / 2), x - 0.5 * ss.square("u", period=3.0)):
        assert ss.solve_ivp(system, (0, 9), [0, 2], events=event).success
    other = system.with_parameters(k=1.5)
    for value in (1.0, 1.5):
        found = ss.solve_ivp(other, (0, 9), [0, 2], events=x - ss.parameter("k", value))
        assert np.allclose(found.y_events[0][:, 0], 1.5)
    for wrong in (ss.parameter("k", 0.5), ss.square("u", period=2), ss.pulse("u", 3, 0.5)):
        for call in (
            lambda event: ss.solve_ivp(system, (0, 9), [0, 2], events=[v, event]),
            lambda event: ss.poincare_map(system, event, [0, 2], returns=2),
        ):
            with pytest.raises(ValueError, match="in the system and .*use the system's symbol"):
                call(x - wrong)
    for wrong in (ss.parameter("v", 0.5), ss.state("k"), ss.parameter("u", 1.0)):
        with pytest.raises(ValueError, match="give one of them another name"):
            ss.solve_ivp(system, (0, 9), [0, 2], events=x - wrong)
    with pytest.raises(ss.SystemError, match="unknown name `w`"):
        ss.solve_ivp(system, (0, 9), [0, 2], events=x - ss.state("w"))
    # A text may write the same otherwise.
    text = system.to_toml().replace('period = "3.0"', "period = 3")
    assert ss.solve_ivp(ss.System.from_toml(text), (0, 9), [0, 2], events=x - u).success


def test_labelled_starts_go_by_their_names():
    system, (x, v) = oscillator(), ss.states("x v")
    wanted = ss.solve_ivp(system, (0, 5), {x: 1, v: 2}).y
    for data, index in (([2, 1], ["v", "x"]), ([2, 1], [v, x]), ([1, 2], range(2))):
        assert np.array_equal(ss.solve_ivp(system, (0, 5), labelled(data, index)).y, wanted)
    for index, words in (
        (["a", "b"], "y0 has a value of a|y0 has no value|y0 has a value of b"),
        ([1, 2], r"the index of y0 has 1: .*y0.to_numpy\(\)"),
        (["x", "x"], "a name twice"),
    ):
        with pytest.raises(ValueError, match=words):
            ss.solve_ivp(system, (0, 5), labelled([1, 2], index))
    for masked in (np.ma.masked_array([1.0, 2.0], [False, True]), np.ma.masked_array([1.0, 2.0])):
        with pytest.raises(TypeError, match=r"y0 is a masked array: .*y0.filled"):
            ss.solve_ivp(system, (0, 5), masked)


def labelled(data, index):
    """A series as pandas has it, as far as it matters here."""

    class Series(np.ndarray):
        pass

    series = np.asarray(data, dtype=float).view(Series)
    series.index = index
    return series


def test_times_of_any_shape_and_solutions_as_keys():
    sol = ss.solve_ivp(oscillator(), (0, 5), dense_output=True)
    times = np.array([[0.5, 1.0, 1.5], [2.0, 2.5, 5.0]])
    assert np.array_equal(sol.sol(times)[:, 1, 2], sol.sol(5.0))
    assert sol.sol(times).shape == (2, 2, 3) and sol.sol([]).shape == (2, 0)
    assert np.allclose(sol.sol(times)[0], np.cos(times), rtol=0, atol=1e-11)
    other = ss.solve_ivp(oscillator(), (0, 5))
    assert sol == sol and sol != other and len({sol, other, sol}) == 2
    orbit = ss.periodic_orbit(oscillator(), [1, 0])
    assert orbit == orbit and orbit in {orbit}


def test_bounds_are_told_in_digits_that_distinguish_them():
    with pytest.raises(ss.OptionError, match=r"t_eval\[1\] = 0.30000000000000004: .* 0 to 0.3$"):
        ss.solve_ivp(oscillator(), (0, 0.3), t_eval=[0.1, 0.1 + 0.2])
    with pytest.raises(ss.OptionError, match=r"t_span\[1\] = 0.1: .* t_span\[0\] = 0.1000000000000"):
        ss.ensemble(oscillator(), [1, 0], (np.nextafter(0.1, 1), 0.1))
    with pytest.raises(TypeError, match=r"not str; .*ss.System.from_toml\('belt'\)"):
        ss.solve_ivp("belt", (0, 1), [1, 0])


def test_events_end_a_run_in_any_order():
    x, v = ss.states("x v")
    early, late = ss.event(v, terminal=2), ss.event(x + 0.5, terminal=True)
    runs = [
        ss.solve_ivp(oscillator(), (0, 20), [0.9, 0.1], events=events, dense_output=True)
        for events in ([late, early, x], [early, x, late], [x, late])
    ]
    for sol in runs:
        assert sol.status == 1 and sol.y[0, -1] == pytest.approx(-0.5, abs=1e-13)
        assert np.array_equal(sol.t, runs[-1].t) and np.array_equal(sol.y, runs[-1].y)
    assert [len(found) for found in runs[0].t_events] == [1, 1, 1]
    assert sol.sol.t_max == sol.t[-1]


def test_derivatives_pass_events_and_stop_at_a_graze():
    x, v = ss.states("x v")
    mu, speed, k = ss.parameters(mu=0.6, speed=0.2, k=1.3)
    belt = ss.Contact("belt", boundary=v - speed, friction=lambda side: mu / (1 + side * v))
    system = ss.System({x: v, v: -k * x - belt.friction}, contacts=[belt])
    start, by = [0.1, 0.9], [mu, speed, k, x, "t0"]
    times = [3.0, 11.0]
    event = ss.event(x - 0.05, direction="rising")
    sol = ss.solve_ivp(system, (0, 12), start, t_eval=times, events=event, derivatives=by)
    plain = ss.solve_ivp(system, (0, 12), start, t_eval=times, events=event)
    assert np.array_equal(sol.y, plain.y) and plain.dy is None and plain.dt_events is None
    assert sol.dy.shape == (2, 2, 5) and sol.transitions["dy"].shape[1:] == (2, 5)
    assert sol.dt_events[0].shape == (len(sol.t_events[0]), 5)

    def moved(column, h):
        values = {"mu": 0.6, "speed": 0.2, "k": 1.3}
        if column < 3:
            values[by[column].name] += h
        y = [start[0] + h * (column == 3), start[1]]
        other = system.with_parameters(**values)
        return ss.solve_ivp(other, (h * (column == 4), 12), y, t_eval=times, events=event)

    h = 1e-5
    for column in range(5):
        plus, minus = moved(column, h), moved(column, -h)
        for own, one, two in [
            (sol.dy[..., column], plus.y, minus.y),
            (sol.transitions["dt"][:, column], plus.transitions["t"], minus.transitions["t"]),
            (sol.transitions["dy"][..., column], plus.transitions["y"], minus.transitions["y"]),
            (sol.dt_events[0][:, column], plus.t_events[0], minus.t_events[0]),
            (sol.dy_events[0][..., column], plus.y_events[0], minus.y_events[0]),
        ]:
            assert np.allclose(own, (one - two) / (2 * h), rtol=1e-5, atol=1e-5)

    edge = ss.Contact("edge", boundary=x - (1 - 1e-13))
    graze = ss.System({x: v, v: edge.by_side(-x, -x - 0.3)}, contacts=[edge])
    with pytest.warns(ss.SolverWarning, match="no derivatives from there on"):
        lost = ss.solve_ivp(graze, (0, 3), [0, 1], t_eval=[1, 2.5], derivatives=[x])
    assert np.isfinite(lost.dy[:, 0]).all() and np.isnan(lost.dy[:, 1]).all()
    with pytest.raises(ValueError, match="did you mean `speed`"):
        ss.solve_ivp(system, (0, 1), start, derivatives=["spede"])
    with pytest.raises(ValueError, match="goes on from another"):
        ss.solve_ivp(system, (12, 13), plain, derivatives=[mu])


def test_import_is_fast_and_needs_numpy_only():
    code = (
        # Time of the processor: other programs may be running.
        "import numpy, sys, time; t = time.process_time(); import stickslip; "
        "print(time.process_time() - t, len({'scipy', 'matplotlib'} & set(sys.modules)))"
    )
    run = [sys.executable, "-c", code]
    found = [subprocess.run(run, capture_output=True, check=True).stdout.split() for _ in range(3)]
    assert min(float(time) for time, _ in found) < 0.15 and found[0][1] == b"0"


def test_a_call_is_a_few_calls_of_functions():
    # Its cost without a clock: calls of functions, built-in ones included.
    system, x = oscillator(), ss.state("x")
    for events in (None, [ss.event(x - 9)]):
        calls = []
        sys.setprofile(lambda _, event, __: calls.append(event))
        try:
            ss.solve_ivp(system, (0, 0.01), [1, 0], events=events)
        finally:
            sys.setprofile(None)
        assert sum(event in ("call", "c_call") for event in calls) < 250


@st.composite
def small_systems(draw):
    """A linear oscillator with a belt, in random units."""
    number = st.floats(0.2, 2.0).map(lambda value: round(value, 2))
    k, c, mu, speed = (draw(number) for _ in range(4))
    x, v = ss.states("x v")
    belt = ss.Contact("belt", boundary=v - speed)
    return ss.System({x: v, v: -k * x - 0.1 * c * v - belt.side * mu}, contacts=[belt]), speed


@settings(max_examples=40, deadline=None)
@given(
    small_systems(),
    st.tuples(st.floats(-2, 2), st.floats(-2, 2)),
    st.lists(st.floats(0, 20), unique=True, max_size=8).map(sorted),
)
def test_runs_are_in_order_and_transitions_on_the_boundary(made, start, times):
    system, speed = made
    sol = ss.solve_ivp(system, (0, 20), start, dense_output=True)
    assert sol.t[0] == 0 and sol.t[-1] == 20 and (np.diff(sol.t) > 0).all()
    assert np.array_equal(sol.y[:, 0], start)
    found = sol.transitions
    assert (np.diff(found["t"]) >= 0).all()
    assert np.allclose(found["y"][:, 1], speed, rtol=0, atol=1e-12)
    phases = sol.phases
    assert np.array_equal(phases["t_end"][:-1], phases["t_start"][1:])
    inside = sol.sol(0.5 * (phases["t_start"] + phases["t_end"]))[1] - speed
    for mode, height in zip(phases["mode"], inside):
        assert {"-": height < 1e-12, "+": height > -1e-12, "S": abs(height) < 1e-12}[mode]
    asked = ss.solve_ivp(system, (0, 20), start, t_eval=times)
    assert np.array_equal(asked.t, times) and asked.y.shape == (2, len(times))
    assert np.array_equal(asked.y, sol.sol(times)) if times else True
