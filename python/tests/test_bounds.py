"""Numbers that are NaN, infinite or out of bounds: one exception, with the argument's name."""

import math

import numpy as np
import pytest
import stickslip as ss


def system():
    x, v = ss.states("x v")
    p = ss.parameter("p", 1.0)
    return ss.System({x: v, v: p - x - 0.1 * v}, start=[1, 0], name="spring")


SYSTEM, X, START = system(), ss.state("x"), [1, 0]
ORBIT = ss.PeriodicOrbit(
    t=0.0, y=np.array([1.0, 0.0]), period=6.0, residual=0.0, family=0, monodromy=np.eye(2),
    multipliers=np.ones(2, dtype=complex), stability="stable", phases="+", in_stick=0.0,
    y_min=np.array([-1.0, -1.0]), y_max=np.array([1.0, 1.0]), system=SYSTEM,
)  # fmt: skip
NUMBERS = [
    ("a number in a formula", lambda bad: X * bad),
    ("a number in a formula", lambda bad: np.array([1.0, bad]) * X),
    ("p", lambda bad: ss.parameters(p=bad)),
    ("p", lambda bad: SYSTEM.with_parameters(p=bad)),
    ("a number in a formula", lambda bad: ss.discrete(n=bad)),
    ("a number in a formula", lambda bad: ss.square("s", bad)),
    ("width", lambda bad: ss.pulse("s", 1.0, bad)),
    ("times[1]", lambda bad: ss.table("s", [0, bad], [1, 2])),
    ("values[0]", lambda bad: ss.table("s", [0, 1], [bad, 2])),
    ("direction", lambda bad: ss.event(X, bad)),
    ("terminal", lambda bad: ss.event(X, terminal=bad)),
    ("count", lambda bad: ss.Jump("j", X, count=bad)),
    ("a number in a formula", lambda bad: ss.System({X: -X}, start=[bad])),
    ("t_span[0]", lambda bad: ss.solve_ivp(SYSTEM, (bad, 1))),
    ("t_span[1]", lambda bad: ss.solve_ivp(SYSTEM, (0, bad))),
    ("y0[1]", lambda bad: ss.solve_ivp(SYSTEM, (0, 1), [1, bad])),
    ("y0[x]", lambda bad: ss.solve_ivp(SYSTEM, (0, 1), {X: bad})),
    ("t_eval[1]", lambda bad: ss.solve_ivp(SYSTEM, (0, 1), t_eval=[0, bad])),
    ("t", lambda bad: ss.solve_ivp(SYSTEM, (0, 1), dense_output=True).sol([0.5, bad])),
    ("rtol", lambda bad: ss.solve_ivp(SYSTEM, (0, 1), rtol=bad)),
    ("atol", lambda bad: ss.solve_ivp(SYSTEM, (0, 1), atol=bad)),
    ("atol[1]", lambda bad: ss.solve_ivp(SYSTEM, (0, 1), atol=[1e-9, bad])),
    ("most_events", lambda bad: ss.solve_ivp(SYSTEM, (0, 1), most_events=bad)),
    ("most_steps", lambda bad: ss.solve_ivp(SYSTEM, (0, 1), most_steps=bad)),
    ("t0", lambda bad: ss.periodic_orbit(SYSTEM, START, t0=bad)),
    ("period", lambda bad: ss.periodic_orbit(SYSTEM, START, period=bad)),
    ("transient", lambda bad: ss.periodic_orbit(SYSTEM, START, transient=bad)),
    ("longest", lambda bad: ss.periodic_orbit(SYSTEM, START, longest=bad)),
    ("points", lambda bad: ORBIT.solution(points=bad)),
    ("longest", lambda bad: ss.poincare_map(SYSTEM, X, START, longest=bad)),
    ("returns", lambda bad: ss.poincare_map(SYSTEM, X, START, returns=bad)),
    ("bounds[0]", lambda bad: ss.continuation(SYSTEM, "p", (bad, 2))),
    ("bounds[1]", lambda bad: ss.continuation(SYSTEM, "p", (0, bad))),
    ("step", lambda bad: ss.continuation(SYSTEM, "p", (0, 2), step=bad)),
    ("most_points", lambda bad: ss.continuation(SYSTEM, "p", (0, 2), most_points=bad)),
    ("bounds[1]", lambda bad: ss.equilibrium_continuation(SYSTEM, "p", (0, bad))),
    ("step", lambda bad: ss.equilibrium_continuation(SYSTEM, "p", (0, 2), step=bad)),
    ("transient", lambda bad: ss.equilibrium_continuation(SYSTEM, "p", (0, 2), transient=bad)),
    ("transient", lambda bad: ss.lyapunov_spectrum(SYSTEM, transient=bad)),
    ("duration", lambda bad: ss.lyapunov_spectrum(SYSTEM, duration=bad)),
    ("values[1]", lambda bad: ss.bifurcation_diagram(SYSTEM, "p", [1, bad])),
    ("longest", lambda bad: ss.bifurcation_diagram(SYSTEM, "p", [1], longest=bad)),
    ("duration", lambda bad: ss.bifurcation_diagram(SYSTEM, "p", [1], duration=bad)),
    ("starts[0, 1]", lambda bad: ss.basins_of_attraction(SYSTEM, [[0, bad]])),
    ("longest", lambda bad: ss.basins_of_attraction(SYSTEM, [[0, 1]], longest=bad)),
    ("workers", lambda bad: ss.basins_of_attraction(SYSTEM, [[0, 1]], workers=bad)),
    ("return_within", lambda bad: ss.basins_of_attraction(SYSTEM, [[0, 1]], return_within=bad)),
    ("largest", lambda bad: ss.least_push(SYSTEM, START, [[1, 0]], largest=bad)),
    ("directions[0, 1]", lambda bad: ss.least_push(SYSTEM, START, [[1, bad]], largest=1)),
    ("track", lambda bad: ss.edge_state(SYSTEM, START, START, track=bad)),
    ("near", lambda bad: ss.edge_state(SYSTEM, START, START, near=bad)),
    ("values[1]", lambda bad: ss.basin_shares(SYSTEM, "p", [1, bad], [[0, 1]])),
    ("series[2, 0]", lambda bad: ss.lyapunov_from_data([0.1, 0.2, bad])),
    ("dt", lambda bad: ss.lyapunov_from_data([0.1, 0.2, 0.3], dt=bad)),
    ("delay", lambda bad: ss.lyapunov_from_data([0.1, 0.2, 0.3], delay=bad)),
    ("dimension", lambda bad: ss.lyapunov_from_data([0.1, 0.2, 0.3], dimension=bad)),
]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, np.float32("nan")])
@pytest.mark.parametrize(("name", "call"), NUMBERS)
def test_what_is_not_finite_is_refused_by_name_and_bound(name, call, bad):
    with pytest.raises(ss.OptionError) as caught:
        call(bad)
    error = caught.value
    assert isinstance(error, ValueError) and error.name == name
    assert error.value == bad or np.isnan(bad) and np.isnan(error.value)
    assert error.bound and error.bound in str(error) and name in str(error)


@pytest.mark.parametrize("name", ["max_step", "escape"])
def test_two_options_may_be_infinite(name):
    assert ss.solve_ivp(SYSTEM, (0, 1), **{name: math.inf}).success
    with pytest.raises(ss.OptionError) as caught:
        ss.solve_ivp(SYSTEM, (0, 1), **{name: math.nan})
    assert caught.value.name == name


def test_order_is_a_bound():
    for call, name, value, bound in (
        (lambda: ss.continuation(SYSTEM, "p", (3, 0)), "bounds", 0, "bounds[0] = 3"),
        (lambda: ss.equilibrium_continuation(SYSTEM, "p", (3, 0)), "bounds", 0, "bounds[0] = 3"),
        (lambda: ss.solve_ivp(SYSTEM, (3, 3)), "t_span", 3, "t_span[0] = 3"),
        (lambda: ss.ensemble(SYSTEM, [[1.0, 0]], (3, 0)), "t_span", 0, "t_span[0] = 3"),
    ):
        with pytest.raises(ss.OptionError) as caught:
            call()
        error = caught.value
        assert (error.name, error.value) == (f"{name}[1]", value) and bound in error.bound


def test_results_do_not_change_with_the_arrays_they_were_made_of():
    starts, values = np.array([[0.5, 0.0], [1.0, 1.0]]), np.array([0.5, 1.0])
    basins = ss.basins_of_attraction(SYSTEM, starts)
    plane = ss.parameter_map(
        ss.System({X: ss.parameter("p", 1.0) - ss.parameter("q", 1.0) * X}),
        ("p", values), ("q", values), [0], duration=None,
    )  # fmt: skip
    starts[:], values[:] = -7, -7
    assert basins.starts.tolist() == [[0.5, 0.0], [1.0, 1.0]]
    assert plane.x.tolist() == plane.y.tolist() == [0.5, 1.0]
