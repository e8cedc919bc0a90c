"""Stops from Python: impacts, rest, reactions and lift-off."""

import pickle

import numpy as np
import pytest

import stickslip as ss


def ball(restitution):
    h, w = ss.states("h w")
    floor = ss.Stop("floor", gap=h, acts={w: 1}, restitution=restitution)
    return ss.System({h: w, w: -10.0}, stops=[floor], start=[5, 0])


@pytest.mark.parametrize("method", ["Taylor", "DOP853"])
@pytest.mark.parametrize("e", [0.3, 0.8])
def test_a_ball_comes_to_rest(method, e):
    sol = ss.solve_ivp(ball(e), (0, 20), method=method)
    landed = sol.transitions[sol.transitions["contact"] == "floor.landing"]
    assert len(landed) == 1 and sol.status == 0
    assert abs(landed["t"][0] - (1 + e) / (1 - e)) < 1e-9
    assert np.allclose(sol.y[:, -1], [0, 0, 1], rtol=0, atol=1e-12)


def test_a_restitution_may_depend_on_the_approach():
    sol = ss.solve_ivp(ball(lambda speed: np.exp(-speed / 10)), (0, 1.001))
    assert abs(sol.y[1, -1] - (10 * np.exp(-1) - 0.01)) < 1e-9


def test_the_force_is_a_formula_and_the_system_a_text():
    x, v = ss.states("x v")
    table = ss.Stop("table", gap=x - 0.5 * np.sin(ss.t), acts={v: 2})
    system = ss.System({x: v, v: -1.0}, stops=[table], start=[0, 0.5])
    sol = ss.solve_ivp(system, (0, 9), events=[table.force - 0.6])
    # Twice the reaction is 1 minus half of the sine.
    assert np.allclose(np.sin(sol.t_events[0]), -0.4, rtol=0, atol=1e-9)
    again = pickle.loads(pickle.dumps(system))
    assert pickle.loads(pickle.dumps(table)).force.text == "table.force"


def test_what_is_wrong_is_told():
    h, w = ss.states("h w")
    with pytest.raises(TypeError, match="acts must be"):
        ss.Stop("floor", gap=h, acts={})
    with pytest.raises(ss.SystemError, match="does not move its gap"):
        g = ss.state("g")
        ss.System(
            {h: w, w: -1.0, g: 0.0}, stops=[ss.Stop("floor", gap=h, acts={g: 1})]
        )
    floor = ss.Stop("floor", gap=h, acts={w: 1})
    with pytest.raises(ValueError, match="is not among stops"):
        ss.System({h: w, w: -1.0 + floor.force})
    system = ss.System({h: w, w: -1.0}, stops=[floor])
    with pytest.raises(ss.StickslipError, match="gap of the stop"):
        ss.solve_ivp(system, (0, 1), [-1, 0])


@pytest.mark.parametrize("t_eval", [None, np.linspace(0, 20, 301)])
def test_reactions_and_impulses_are_part_of_a_solution(t_eval):
    sol = ss.solve_ivp(ball(0.5), (0, 20), t_eval=t_eval)
    assert np.array_equal(sol.forces[0], np.where(sol.y[2] == 1, 10.0, 0.0))
    assert not np.signbit(sol.forces).any()
    impacts = sol.transitions[sol.transitions["contact"] == "floor.impact"]
    speeds = 10 * 0.5 ** np.arange(len(impacts))
    assert impacts["impulse"].shape == (len(impacts), 1)
    assert np.allclose(impacts["impulse"][:, 0], 1.5 * speeds, rtol=0, atol=1e-9)
    h = ss.state("h")
    free = ss.solve_ivp(ss.System({h: -1.0}), (0, 1), [1])
    assert free.forces is None and "impulse" not in free.transitions.dtype.names
