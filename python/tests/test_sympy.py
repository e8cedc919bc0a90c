"""Systems from SymPy."""

import numpy as np
import pytest
import stickslip as ss
import sympy
from sympy.physics import mechanics


def test_rates_are_those_of_the_expressions():
    x, v, k, c, t = sympy.symbols("x v k c t")
    rate = -k * sympy.sin(x) ** 3 - c * v / 2 + sympy.exp(-(t**2)) * sympy.sqrt(1 + v**2) + sympy.pi
    made = ss.from_sympy({x: v, v: rate}, {k: 2.0, "c": 0.5})
    assert [one.name for one in made.states] == ["x", "v"]
    assert [(one.name, one.value) for one in made.parameters] == [("c", 0.5), ("k", 2.0)]
    sol = ss.solve_ivp(ss.System(made.rates), (0, 3), [0.3, -0.2], rtol=1e-10)
    f = sympy.lambdify((t, x, v), [v, rate.subs({k: 2.0, c: 0.5})])
    from scipy.integrate import solve_ivp

    other = solve_ivp(lambda t, y: f(t, *y), (0, 3), [0.3, -0.2], "DOP853", rtol=1e-11, atol=1e-12)
    assert np.allclose(sol.y[:, -1], other.y[:, -1], rtol=0, atol=1e-8)


def pendulum():
    q, u = mechanics.dynamicsymbols("q u")
    m, l, g = sympy.symbols("m l g")
    frame = mechanics.ReferenceFrame("N")
    arm = frame.orientnew("A", "Axis", [q, frame.z])
    arm.set_ang_vel(frame, u * frame.z)
    pivot = mechanics.Point("O")
    pivot.set_vel(frame, 0)
    bob = pivot.locatenew("P", l * arm.x)
    bob.v2pt_theory(pivot, frame, arm)
    body = mechanics.Particle("bob", bob, m)
    return frame, q, u, body, bob, (m, l, g)


def test_the_methods_of_kane_and_lagrange_make_a_pendulum():
    frame, q, u, body, bob, (m, l, g) = pendulum()
    weight = [(bob, m * g * frame.x)]
    kane = mechanics.KanesMethod(frame, [q], [u], kd_eqs=[q.diff() - u])
    kane.kanes_equations([body], weight)
    made = ss.from_sympy(kane, {m: 1.0, l: 2.0, g: 9.81})
    t = mechanics.dynamicsymbols._t
    x, y = l * sympy.cos(q), l * sympy.sin(q)
    energy = m * (x.diff(t) ** 2 + y.diff(t) ** 2) / 2 + m * g * x
    lagrange = mechanics.LagrangesMethod(sympy.simplify(energy), [q])
    lagrange.form_lagranges_equations()
    other = ss.from_sympy(lagrange, {m: 1.0, l: 2.0, g: 9.81})
    ends = [ss.solve_ivp(ss.System(one.rates), (0, 5), [1.0, 0]).y[:, -1] for one in (made, other)]
    a, b = ss.states("a b")
    plain = ss.solve_ivp(ss.System({a: b, b: -9.81 / 2 * np.sin(a)}), (0, 5), [1.0, 0]).y[:, -1]
    assert np.allclose(ends, [plain, plain], rtol=0, atol=1e-10)


def test_the_speeds_of_lagrange_are_states_of_their_own():
    q, p = mechanics.dynamicsymbols("q p")
    energy = (q.diff() ** 2 + p.diff() ** 2 - q**2) / 2 - 2 * p**2
    lagrange = mechanics.LagrangesMethod(energy, [q, p])
    lagrange.form_lagranges_equations()
    made = ss.from_sympy(lagrange)
    assert [one.name for one in made.states] == ["q", "p", "dq", "dp"]
    assert made[q.diff()] is made.states[2]
    sol = ss.solve_ivp(ss.System(made.rates), (0, 3), [1, 0, 0, 2])
    assert np.allclose(sol.y[:2, -1], [np.cos(3), np.sin(6)], rtol=0, atol=1e-10)


def test_the_derivative_of_a_state_is_its_rate():
    q, u, p = mechanics.dynamicsymbols("q u p")
    k, c = sympy.symbols("k c")
    values = {k: 4.0, c: 0.5}
    made = ss.from_sympy({q: u, u: -k * q - c * q.diff()}, values)
    plain = ss.from_sympy({q: u, u: -k * q - c * u}, values)
    assert ss.System(made.rates) == ss.System(plain.rates)
    assert made[q.diff()] is made[u]
    second = mechanics.dynamicsymbols._t, 2
    assert repr(made[q.diff(second)]) == repr(made.rates[made[u]])
    made = ss.from_sympy({q: q.diff(), q.diff(): -k * q - c * q.diff()}, values)
    assert [one.name for one in made.states] == ["q", "dq"]
    with pytest.raises(ValueError, match="depends on itself: solve the equations"):
        ss.from_sympy({q: u, u: -k * q - c * u.diff()}, values)
    with pytest.raises(ValueError, match="which is no state"):
        ss.from_sympy({q: u, u: -k * q - c * p.diff()}, values)


@pytest.mark.parametrize("values", [{}, {"q": 1}])
def test_two_symbols_of_one_name_are_refused(values):
    q, u = mechanics.dynamicsymbols("q u")
    with pytest.raises(ValueError, match="rename one"):
        ss.from_sympy({q: u, u: -sympy.Symbol("q")}, values)
    x, k = sympy.symbols("x k")
    for other in (x, k):
        same = sympy.Symbol(other.name, positive=True)
        with pytest.raises(ValueError, match="which have other assumptions: rename one"):
            ss.from_sympy({x: -k * same}, {"k": 2})
    with pytest.raises(ValueError, match="parameters has k twice"):
        ss.from_sympy({x: -k * x}, {k: 2, "k": 3})


def test_a_name_that_cannot_stand_in_formulas_is_refused_with_another():
    x, omega = sympy.symbols(r"x \omega_0")
    for rates, values in (({x: -omega * x}, {omega: 1}), ({omega: -omega}, {})):
        with pytest.raises(ValueError, match=r"rename it, as sympy.Symbol\('omega_0'\)"):
            ss.from_sympy(rates, values)


def test_formulas_and_expressions_of_sympy_are_not_mixed():
    x, k = ss.state("x"), sympy.Symbol("k")
    for make in (lambda: x * k, lambda: k * x, lambda: x**k, lambda: ss.System({x: k})):
        with pytest.raises(TypeError, match="from_sympy"):
            make()


def test_the_error_function():
    x = sympy.Symbol("x")
    (rate,) = ss.from_sympy({x: sympy.erf(x)}).rates.values()
    assert repr(rate) == "erf(x)"


def test_contacts_and_jumps_are_added():
    x, v, mu = sympy.symbols("x v mu")
    made = ss.from_sympy({x: v, v: -x}, {mu: 0.3})
    floor = ss.Contact("floor", boundary=made[v], friction=made[mu * (1 + x**2)])
    made.rates[made[v]] -= floor.friction
    wall = ss.Jump("wall", when=made[x - 1], set={made[v]: -made[v]}, direction=1)
    system = ss.System(made.rates, contacts=[floor], jumps=[wall])
    assert system.parameters == {"mu": 0.3} and system.jumps == ("wall",)
    assert set(ss.solve_ivp(system, (0, 5), [0.9, 2.0]).transitions["kind"]) >= {"jump"}


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda x, k: {x: k * x}, "the symbol k is no state and has no value"),
        (lambda x, k: {x: sympy.sign(x)}, "a sign is the side of a Contact"),
        (lambda x, k: {x: sympy.Piecewise((1, x > 0), (2, True))}, "contact.by_side"),
        (lambda x, k: {x: sympy.gamma(x)}, "gamma.* has no formula"),
        (lambda x, k: {x: sympy.Integral(x, x)}, "Integral.* has no formula"),
        (lambda x, k: {x: x > 0}, "x > 0 has no formula: two formulas are contact.by_side"),
    ],
)
def test_what_has_no_formula_is_refused(make, said):
    with pytest.raises(ValueError, match=said):
        ss.from_sympy(make(*sympy.symbols("x k")))


def test_other_things_are_no_equations():
    with pytest.raises(TypeError, match="equations must be"):
        ss.from_sympy(3)
    x = sympy.Symbol("x")
    with pytest.raises(TypeError, match="is no symbol of SymPy"):
        ss.from_sympy({x + 1: x})
