"""Backwards in time: exact pasts, crossings, and slides that have none."""

import numpy as np
import pytest
import stickslip as ss

x, v = ss.states("x v")


def test_the_past_of_an_oscillator_is_exact():
    system = ss.System({x: v, v: -x})
    times = [2.0, 0.5, -1.0, -3.0]
    sol = ss.solve_ivp(system, (2, -3), [0.3, 1.0], t_eval=times, events=v, dense_output=True)
    back = np.array(times) - 2
    assert np.allclose(sol.y[0], 0.3 * np.cos(back) + np.sin(back), rtol=0, atol=1e-11)
    assert sol.t.tolist() == times and sol.status == 0 and (sol.sol.t_min, sol.sol.t_max) == (-3, 2)
    assert np.allclose(sol.sol(-1.0), sol.y[:, 2], rtol=0, atol=1e-14)
    # v = cos s - 0.3 sin s vanishes at tan s = 1 / 0.3, with s = t - 2.
    zeros = 2 + np.arctan(1 / 0.3) - np.pi * np.array([1, 2])
    assert np.allclose(sol.t_events[0], zeros[zeros > -3], rtol=0, atol=1e-11)
    assert sol.phases["t_start"][0] == 2 and sol.phases["t_end"][-1] == -3


def test_the_first_terminal_event_along_the_run_ends_it():
    stop = ss.event(v, direction=-1, terminal=True)
    sol = ss.solve_ivp(ss.System({x: v, v: -x}), (2, -9), [0.0, 1.0], events=[stop, x])
    # v = cos(t - 2) falls backwards through zero at t - 2 = -pi/2, x vanishes at 2 itself.
    assert sol.status == 1 and abs(sol.t[-1] - (2 - np.pi / 2)) < 1e-11
    assert sol.t_events[0].tolist() == [sol.t[-1]] and (np.diff(sol.t) < 0).all()
    assert sol.phases["t_end"][-1] == sol.t[-1]


def test_time_in_formulas_goes_backwards():
    system = ss.System({x: np.cos(3 * ss.t) - 0.5 * x})
    there = ss.solve_ivp(system, (1, 4), [0.7])
    back = ss.solve_ivp(system, (4, 1), there.y[:, -1])
    assert np.allclose(back.y[:, -1], 0.7, rtol=0, atol=1e-10)


def crossing():
    """Coulomb friction that is too weak to stick where the orbit crosses."""
    belt = ss.Contact("belt", boundary=v, friction=0.1)
    return ss.System({x: v, v: -x - belt.friction}, contacts=[belt])


def test_crossings_are_passed_backwards():
    # Between its zeros of v the orbit is a circle about ±0.1: each half turn it loses 0.2.
    sol = ss.solve_ivp(crossing(), (0, 7), [2.0, 0.0])
    assert (sol.transitions["kind"] == "crossing").sum() >= 2
    back = ss.solve_ivp(crossing(), (7, 0.5), sol.y[:, -1])
    assert back.status == 0
    exact = [0.1 + 1.9 * np.cos(0.5), -1.9 * np.sin(0.5)]
    assert np.allclose(back.y[:, -1], exact, rtol=0, atol=1e-9)
    there = sol.transitions[sol.transitions["kind"] == "crossing"]
    assert np.allclose(back.transitions["t"][::-1][-2:], there["t"][-2:], rtol=0, atol=1e-9)
    assert back.transitions["to_mode"][0] == there["from_mode"][-1]


def falling():
    mu0, vp = ss.parameters(mu0=0.4, vp=0.2)
    belt = ss.Contact("belt", v - vp, lambda side: mu0 / (1 + 3 * side * (v - vp)))
    return ss.System({x: v, v: -x - 0.05 * v - belt.friction}, contacts=[belt], start=[0.5, 0])


def test_a_slide_has_no_past_and_the_time_is_named():
    sol = ss.solve_ivp(falling(), (0, 9))
    exit = sol.transitions[sol.transitions["kind"] == "stick exit"][-1]
    # From the slip behind the slide.
    with pytest.warns(ss.SolverWarning, match=r"the past is not unique: at t = 6\.0089"):
        back = ss.solve_ivp(falling(), (9, 0), sol.y[:, -1])
    assert back.status == 2 and not back.success
    assert abs(back.t[-1] - exit["t"]) < 1e-5
    assert np.allclose(back.y[:, -1], exit["y"], rtol=0, atol=1e-5)
    # The run is the orbit as far as it goes.
    for t in (8.0, 7.0, 6.5):
        at = ss.solve_ivp(falling(), (0, t), t_eval=[t])
        own = ss.solve_ivp(falling(), (9, t), sol.y[:, -1], t_eval=[t])
        assert np.allclose(at.y, own.y, rtol=0, atol=1e-8)
    # From within the slide.
    sticks = ss.solve_ivp(falling(), (0, exit["t"] - 1))
    with pytest.raises(ss.StickslipError, match="comes from a slide along the boundary of belt") as e:
        ss.solve_ivp(falling(), (5, 0), sticks.y[:, -1])
    assert e.value.kind == "NoUniquePast" and e.value.t == 5


def test_static_friction_may_have_held_where_a_run_arrives():
    belt = ss.Contact("belt", v - 0.2, friction=0.3, static=0.5)
    system = ss.System({x: v, v: -x - belt.friction}, contacts=[belt], start=[0.9, 0])
    sol = ss.solve_ivp(system, (0, 12))
    exits = sol.transitions[sol.transitions["kind"] == "stick exit"]
    end = exits["t"][0] + 0.5
    at = ss.solve_ivp(system, (0, end), t_eval=[end])
    with pytest.warns(ss.SolverWarning, match="the past is not unique"):
        back = ss.solve_ivp(system, (end, 0), at.y[:, -1])
    assert abs(back.t[-1] - exits["t"][0]) < 1e-8


@pytest.mark.parametrize(
    ("system", "what"),
    [
        (lambda: ss.System({x: v, v: -x}, jumps=[ss.Jump("wall", x - 1, {v: -v})]), "jumps"),
        (lambda: ss.System({x: ss.square("s", 1.0) - x}), "inputs or switches"),
    ],
)
def test_what_stands_against_it_is_named(system, what):
    with pytest.raises(ValueError, match=f"backwards .* the system has {what}"):
        ss.solve_ivp(system(), (1, 0), [0.5, 0.0][: len(system().states)])


def test_what_is_not_known_backwards_is_refused():
    system = falling()
    with pytest.raises(ValueError, match="derivatives of a run backwards"):
        ss.solve_ivp(system, (1, 0), derivatives=["mu0"])
    with pytest.raises(ValueError, match="does not go on from another"):
        ss.solve_ivp(system, (1, 0), ss.solve_ivp(system, (0, 1)))
    with pytest.raises(ValueError, match="each smaller than the one before"):
        ss.solve_ivp(system, (1, 0), t_eval=[0.2, 0.5])


def two_blocks():
    y, w = ss.states("y w")
    one = ss.Contact("one", v - 0.2, lambda side: 0.4 / (1 + 2 * side * (v - 0.2)))
    other = ss.Contact("other", w - 0.3, lambda side: 0.5 / (1 + side * (w - 0.3)))
    rates = {x: v, v: y - 2 * x - one.friction, y: w, w: x - 2 * y - other.friction}
    return ss.System(rates, contacts=[one, other])


def held():
    belt = ss.Contact("belt", v - 0.2, lambda side: 0.4 / (1 + 3 * side * (v - 0.2)), static=0.5)
    return ss.System({x: v, v: -x - 0.05 * v - belt.friction}, contacts=[belt])


@pytest.mark.parametrize("make", [falling, held, two_blocks])
@pytest.mark.filterwarnings("ignore::stickslip.SolverWarning")
def test_random_orbits_end_at_their_last_slide_or_where_they_began(make):
    system, random = make(), np.random.default_rng(7)
    ends = {"slide": 0, "start": 0}
    for _ in range(60):
        start, end = random.normal(0, 1.2, len(system.states)), random.uniform(1, 10)
        sol = ss.solve_ivp(system, (0, end), start)
        if "S" in sol.phases["mode"][-1]:
            with pytest.raises(ss.StickslipError, match="the past is not unique"):
                ss.solve_ivp(system, (end, 0), sol.y[:, -1])
            continue
        exits = sol.transitions["t"][sol.transitions["kind"] == "stick exit"]
        back = ss.solve_ivp(system, (end, 0), sol.y[:, -1])
        ends["slide" if len(exits) else "start"] += 1
        if len(exits):
            assert back.status == 2 and abs(back.t[-1] - exits[-1]) < 1e-3
        else:
            assert back.status == 0 and np.allclose(back.y[:, -1], start, rtol=0, atol=1e-6)
    assert min(ends.values()) > 5
