"""Formulas and systems of symbols."""

import copy
import math
import pickle

import numpy as np
import pytest
import stickslip as ss
from hypothesis import assume, given, settings
from hypothesis import strategies as st


def belt_system(**values):
    x, v = ss.states("x v")
    k, mu0, vp = ss.parameters(k=1.0, mu0=0.4, vp=0.2)
    belt = ss.Contact("belt", boundary=v - vp)
    rate = -k * x - belt.side * mu0 / (1 + belt.side * (v - vp))
    return ss.System({x: v, v: rate}, contacts=[belt]).with_parameters(**values)


FUNCTIONS = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / (b * b + 1),
    "max": np.maximum,
    "min": np.minimum,
    "neg": lambda a: -a,
    "cube": lambda a: a**3,
    "inverse": lambda a: (a * a + 1) ** -2,
    "root": lambda a: np.sqrt(abs(a) + 1),
    "power": lambda a: (abs(a) + 1) ** 1.5,
    "log": lambda a: np.log(a * a + 1),
    **{
        name: getattr(np, name)
        for name in ("sin", "cos", "tan", "arctan", "sinh", "cosh", "tanh", "exp", "square")
    },
}
BINARY = ["+", "-", "*", "/", "max", "min"]


def formulas():
    leaf = st.sampled_from(["x", "v"]) | st.floats(-4, 4).map(lambda value: round(value, 3))
    unary = sorted(set(FUNCTIONS) - set(BINARY))
    return st.recursive(
        leaf,
        lambda inner: st.one_of(
            st.tuples(st.sampled_from(BINARY), inner, inner),
            st.tuples(st.sampled_from(unary), inner),
        ),
        max_leaves=8,
    )


def evaluated(formula, names, on_the_way):
    if not isinstance(formula, tuple):
        return names.get(formula, formula)
    of = [evaluated(one, names, on_the_way) for one in formula[1:]]
    value = FUNCTIONS[formula[0]](*of)
    on_the_way.append(value)
    return value


@settings(max_examples=300, deadline=None)
@given(formulas())
def test_the_engine_reads_what_symbols_write(formula):
    x, v = ss.states("x v")
    of_symbols = evaluated(formula, {"x": x, "v": v}, [])
    x0, v0 = 0.3, -0.7
    numbers = {"x": np.float64(x0), "v": np.float64(v0)}
    with np.errstate(all="ignore"):
        wanted = float(evaluated(formula, numbers, on_the_way := [0.0]))
    # What is large on the way leaves few digits.
    assume(np.abs(np.array(on_the_way, dtype=float)).max() < 1e3)
    # The rate of y is the formula, of states that do not move.
    y = ss.state("y")
    system = ss.System({x: 0, v: 0, y: of_symbols})
    end = ss.solve_ivp(system, (0, 1), [x0, v0, 0]).y[2, -1]
    assert end == pytest.approx(wanted, rel=1e-11, abs=1e-11)


def test_numpy_works_on_symbols():
    x, v = ss.states("x v")
    K = np.array([[2.0, -1.0], [-1.0, 2.0]])
    assert [str(row) for row in K @ [x, v]] == ["2.0 * x + -1.0 * v", "-1.0 * x + 2.0 * v"]
    assert str(np.tanh(x)) == "tanh(x)"
    assert str(np.float64(2) * x) == "2.0 * x"
    assert [str(one) for one in np.array([1.0, 2.0]) * x] == ["1.0 * x", "2.0 * x"]
    assert str((x + 1) ** 2 / -v) == "(x + 1.0)^2.0 / -v"
    assert str(-(x**2)) == "-x^2.0"
    assert str((-x) ** 2) == "(-x)^2.0"
    assert str(x - (v - 1)) == "x - (v - 1.0)"


@pytest.mark.parametrize(
    ("misuse", "words"),
    [
        (lambda x: bool(x), "no truth value"),
        (lambda x: 1 if x else 2, "Contact"),
        (lambda x: 1 if x > 0 else 2, "by_side"),
        (lambda x: np.where(x, 1, 2), "by_side"),
        (lambda x: np.sign(x), r"\.side"),
        (lambda x: np.arcsinh(x), r"write np.log\(x \+"),
        (lambda x: np.frexp(x), "the functions are"),
        (lambda x: float(x), "not a number"),
        (lambda x: x + "1", "unsupported operand"),
        (lambda x: np.complex128(1j) * x, "operand type"),
        (lambda x: ss.Jump("hit", when=x, count=1.5), "count must be a whole number"),
        (lambda x: ss.System({x: x == 1}), "a comparison .*by_side"),
        (lambda x: ss.System({ss.states("x,"): 1}), "made by ss.states"),
        (lambda x: np.where(x == ss.state("v"), 1.0, -1.0), "a comparison .*by_side"),
        (lambda x: x + 1 == x, "a comparison .*by_side"),
        (lambda x: "x" != x, "a comparison .*by_side"),
        (lambda x: x == np.array([1.0, 2.0]), "a comparison .*by_side"),
        (lambda x: np.array([1.0, 2.0]) == x, "np.equal of a formula.*by_side"),
        (lambda x: ss.t == x, "a comparison .*by_side"),
        (lambda x: ss.System({x: 1}, contacts=["belt"]), "contacts must be made by ss.Contact"),
        (lambda x: ss.Jump("hit", when=x, set={"x": 1}), "'x' is no state"),
        (lambda x: ss.Jump("hit", when=x < 0), "with a direction"),
        (lambda x: x % 2, r"remainder .*ss.sawtooth\(name, period\).*ss.Jump\(name, when=x - 2"),
        (lambda x: 2 % x, "remainder .*ss.sawtooth"),
        (lambda x: x // 2, "floored quotient .*ss.discrete"),
        (lambda x: 7 // x, "floored quotient .*ss.discrete"),
        (lambda x: divmod(x, 2), "divmod.*ss.discrete"),
        (lambda x: divmod(2, x), "divmod.*ss.discrete"),
        (lambda x: round(x), "round.*ss.discrete"),
        (lambda x: round(x, 2), "round.*ss.discrete"),
        (lambda x: int(x), "not a number.*np.sin"),
        (lambda x: complex(x), "not a number.*np.sin"),
        (lambda x: range(x), "not a number.*np.sin"),
        (lambda x: [1, 2] * x, "not a number.*np.sin"),
        (lambda x: np.zeros(2).__setitem__(0, x), "dtype=object"),
        (lambda x: np.linalg.inv([[x, 1], [1, x]]), "Cannot cast|np.linalg"),
        (lambda x: ss.System({x: x < 1}), "a comparison .*np.minimum"),
        (lambda x: (1 >= x) * x, "a comparison .*np.minimum"),
        (lambda x: x + (1 >= x), "a comparison .*np.minimum"),
        (lambda x: np.sin(x < 1), "a comparison .*np.minimum"),
        (lambda x: (x < 1) < 2, "a comparison .*np.minimum"),
        (lambda x: (x < 1) & x, "joined by `and`: both must be comparisons"),
        (lambda x: np.select([x < 1], [x]), "a comparison|select"),
        (lambda x: ss.Jump("hit", when=x, stop=True, condition=x), "a comparison such as v < 0.1"),
        (lambda x: x == 0, "a comparison .*with a direction"),
        (lambda x: x + 1 != 0.5, "a comparison .*with a direction"),
        (lambda x: np.float64(1) == x, "a comparison|equal of a formula"),
        (lambda x: max(x, 0), "a comparison .*np.maximum"),
        (lambda x: sorted([x, 2 * x]), "a comparison"),
        (lambda x: x & 1, "a condition .*by_side"),
        (lambda x: 1 | x, "a condition .*by_side"),
        (lambda x: ~x, "a condition .*by_side"),
        (lambda x: x ^ 2, r"a power is x\*\*2"),
        (lambda x: 2 ^ x, r"a power is x\*\*2"),
        (lambda x: np.int64(2) ^ x, r"a power is x\*\*2"),
        (lambda x: 0 < x < 1, "a comparison"),
        (lambda x: np.round(x, 1), "ss.discrete"),
        (lambda x: np.interp(x, [0, 1], [2, 3]), "ss.table"),
        (lambda x: np.sum(x), r"a list of symbols, as np.sum\(\[x, v\]\)"),
    ],
)
def test_misuse_says_what_to_write_instead(misuse, words):
    with pytest.raises(TypeError, match=words):
        misuse(ss.state("x"))


@pytest.mark.parametrize(
    "arguments, words",
    [
        ({"when": ss.parameter("p", 1), "stop": True}, "is constant"),
        ({}, "sets no state"),
        ({"stop": True, "count": 2}, "say the same"),
    ],
)
def test_a_jump_that_cannot_work_is_refused_where_it_is_written(arguments, words):
    with pytest.raises(ValueError, match=words):
        ss.Jump("hit", **{"when": ss.state("x"), **arguments})


UFUNCS = sorted(
    {
        one.__name__
        for one in vars(np).values()
        if isinstance(one, np.ufunc) and hasattr(np, one.__name__)
        if one.nin <= 2 and not one.signature
    }
)
# Others take lists.
OF_MATH = sorted(
    name
    for name, one in vars(math).items()
    if callable(one) and name not in ("dist", "fsum", "prod", "sumprod") and name[0] != "_"
)


@pytest.mark.parametrize("name", UFUNCS)
def test_each_function_of_numpy_is_a_formula_or_says_what_to_write(name):
    function, values = getattr(np, name), (0.3, 0.7)
    # Of arrays of objects NumPy compares for the largest, and has no loop for float_power.
    has_loop = name not in ("maximum", "minimum", "fmax", "fmin", "float_power")
    x, v = ss.states("x v")
    of = (x, v)[: function.nin]
    try:
        formula = function(*of)
    except TypeError as error:
        assert f"np.{name} of a formula: " in str(error), error
        return
    if isinstance(formula, ss.Condition):
        assert name in ("less", "less_equal", "greater", "greater_equal")
        return
    formulas = [formula, *(function(*(np.array([one]) for one in of)) if has_loop else [])]
    for one in formulas:
        y = ss.state("y")
        end = ss.solve_ivp(ss.System({x: 0, v: 0, y: one}), (0, 1), [*values, 0]).y[2, -1]
        assert end == pytest.approx(function(*values[: function.nin]), rel=1e-14)


@pytest.mark.parametrize("name", OF_MATH)
def test_each_function_of_math_says_what_takes_symbols(name):
    function, x = getattr(math, name), ss.state("x")
    said = []
    for count in (1, 2, 3):
        with pytest.raises(TypeError) as caught:
            function(*[x] * count)
        said.append(str(caught.value))
    # With another number of arguments it says that.
    assert any("formula" in one for one in said), said


def test_what_replaces_a_remainder_is_one():
    """`%` is refused, and its message names these two."""
    x, y = ss.states("x y")
    clock = ss.sawtooth("clock", 0.7)
    turn = ss.Jump("turn", when=x - 2 * ss.pi, direction=1, set={x: x - 2 * ss.pi})
    system = ss.System({x: 1, y: 0.7 * clock}, jumps=[turn])
    sol = ss.solve_ivp(system, (0, 20), [0, 0], t_eval=np.linspace(0, 20, 9))
    assert np.allclose(sol.y[0], sol.t % (2 * np.pi), rtol=0, atol=1e-12)
    whole, part = np.divmod(sol.t, 0.7)
    assert np.allclose(sol.y[1], whole * 0.7**2 / 2 + part**2 / 2, rtol=0, atol=1e-12)


def test_a_number_that_is_none_is_refused_by_name():
    with pytest.raises(ValueError, match="the parameter mu0 = nan"):
        ss.parameters(mu0=float("nan"))
    with pytest.raises(ValueError, match="the parameter mu0 = inf"):
        belt_system(mu0=np.inf)
    with pytest.raises(ss.SystemError, match="mu0"):
        belt_system(mu=0.3)


def test_the_text_of_a_large_system_is_short():
    states = ss.states([f"x{k}" for k in range(40)])
    assert len(repr(ss.System({state: 1 for state in states}))) < 120


def test_what_is_missing_is_named():
    x, v = ss.states("x v")
    belt = ss.Contact("belt", boundary=v)
    with pytest.raises(ValueError, match="same on both sides of the contact belt: write belt.side"):
        ss.System({x: v, v: -x}, contacts=belt)
    with pytest.raises(ValueError, match="the friction of the contact belt acts nowhere"):
        ss.System({x: v, v: -x}, contacts=[ss.Contact("belt", boundary=v, friction=0.4)])
    with pytest.raises(ValueError, match="start has no value of the state v"):
        ss.System({x: v, v: -x}, start={"x": 1})
    with pytest.raises(ValueError, match="must have different names"):
        ss.states("x x")
    with pytest.raises(ValueError, match="the state v has no rate"):
        ss.System({x: v})
    with pytest.raises(ValueError, match="belt is not among contacts"):
        ss.System({x: v, v: -belt.side})
    with pytest.raises(ValueError, match="k is the name of two parameters"):
        ss.System({x: ss.parameter("k", 1.0) * v, v: ss.parameter("k", 2.0) * x})
    with pytest.raises(ValueError, match="v is the name of one parameter and one state"):
        ss.System({x: ss.parameter("v", 1.0) * v, v: -x})
    wall = ss.Jump("wall", when=x, set={v: -v})
    with pytest.raises(ValueError, match="jumps has two that are called wall"):
        ss.System({x: v, v: -x}, jumps=[wall, wall])
    with pytest.raises(ValueError, match="k is the name of two parameters"):
        ss.System({x: ss.parameter("k", 1.0) * x + ss.parameter("k", 2.0)})


def test_one_contact_or_jump_needs_no_list_and_directions_are_words_or_signs():
    x, v = ss.states("x v")
    falling = ss.Jump("hit", when=x, direction=-1, set={v: -v})
    assert ss.System({x: v, v: -1}, jumps=falling).jumps == ("hit",)
    assert falling.direction == ss.Jump("hit", x, direction="falling", stop=True).direction
    assert ss.event(x, "rising") == ss.event(x, 2) and ss.event(x, "falling").direction == -1
    with pytest.raises(ValueError, match="direction = 'up'"):
        ss.event(x, "up")
    assert belt_system().with_parameters({ss.parameter("mu0", 0): 0.1}).parameters["mu0"] == 0.1


def test_symbols_are_keys():
    x, v = ss.states("x v")
    k, other = ss.parameter("k", 1.0), ss.parameter("k", 2.0)
    named = {x: 1, v: 2, k: 3, other: 4, ss.t: 5, x + v: 6}
    assert (named[ss.state("x")], named[k], named[other], named[ss.t]) == (1, 3, 4, 5)
    assert {x, ss.state("x"), v} == {v, x} and x == ss.state("x")
    assert len({ss.Contact("c", v), ss.Contact("c", v), ss.Contact("c", v - 1)}) == 2


def test_names_may_be_greek():
    θ, ω = ss.states("θ ω")
    k = ss.parameter("κ₀", 4.0)
    floor = ss.Contact("μ", boundary=ω, friction=0.1)
    push, flip = ss.pulse("ü", period=2, width=0.5), ss.Switch("σ", ss.t - 1)
    wall = ss.Jump("ρ", when=θ - 2, set={ω: -ω})
    rate = -k * θ - floor.friction + 0 * push + 0 * flip.side
    system = ss.System({θ: ω, ω: rate}, contacts=[floor], jumps=[wall], start={θ: 1, "ω": 0})
    assert system.states == ("θ", "ω") and system.parameters == {"κ₀": 4.0}
    sol = ss.solve_ivp(system, (0, 1), {"θ": 1, ω: 0}, events=ω)
    assert sol.y[0, -1] < 0.9 and ss.System.from_toml(system.to_toml()) == system
    # The micro sign looks like the Greek letter and is the same name.
    assert ss.state("\u00b5").name == "μ"
    for name in ("x-1", "1x", "", "x̂", "a b"):
        with pytest.raises(ValueError, match="is no name: a letter"):
            ss.state(name)


def test_a_single_name_is_a_single_state():
    assert str(-ss.states("x")) == "-x"
    assert ss.states("x,") == (ss.state("x"),) == ss.states(["x"])


def test_a_formula_has_any_number_of_terms():
    x = ss.state("x")
    whole = sum((x for _ in range(30_000)), 0 * x)
    system = ss.System({x: -whole / 30_000})
    assert ss.solve_ivp(system, (0, 1), [1]).y[0, -1] == pytest.approx(np.exp(-1), rel=1e-9)


def test_friction_is_not_negative():
    v, mu = ss.state("v"), ss.parameter("mu", 0.4)
    for laws in ({"friction": -0.4}, {"friction": 0.4, "static": -1}, {"friction": lambda _: -0.4}):
        with pytest.raises(ss.OptionError, match="floor: (friction|static) = -.*at least 0"):
            ss.Contact("floor", boundary=v, **laws)
    floor = ss.Contact("floor", boundary=v, friction=mu * (2 - ss.t))
    system = ss.System({v: np.cos(ss.t) - floor.friction}, contacts=[floor])
    with pytest.warns(ss.SolverWarning, match="friction of floor is negative at t = ") as caught:
        ss.solve_ivp(system, (0, 6), [1])
    assert len(caught) == 1
    plain = ss.Contact("floor", boundary=v, friction=mu)
    plain = ss.System({v: np.cos(ss.t) - plain.friction}, contacts=[plain], start=[1])
    with pytest.raises(ss.SystemError, match="`floor` is -1, but must not be negative"):
        plain.with_parameters(mu=-1)
    gone = ss.Contact("floor", boundary=v, friction=mu * (2 - v))
    gone = ss.System({v: np.cos(ss.t) - gone.friction}, contacts=[gone])
    assert "negative at t = 0, -0.4" in gone.check([3])[0] and gone.check([1]) == []


def test_the_width_of_a_pulse_is_a_formula():
    x, w = ss.state("x"), ss.parameter("w", 0.3)
    system = ss.System({x: ss.pulse("u", period=2, width=w) - x}, period=2)
    for width in (0.1, 0.6):
        start = (np.exp(2 * width) - 1) / (np.exp(2) - 1)
        orbit = ss.periodic_orbit(system.with_parameters(w=width), [0.0], t0=0.0)
        assert orbit.period == 2 and orbit.y[0] == pytest.approx(start, abs=1e-10)
    branch = ss.continuation(system, w, (0.1, 0.9), [0.2])
    assert branch.parameter.min() == 0.1 and branch.parameter.max() == 0.9
    assert np.allclose(branch.period, 2, rtol=0, atol=1e-12)
    with pytest.raises(ss.SystemError, match="the width 1.2 is not between 0 and 1"):
        system.with_parameters(w=1.2)


def test_a_jump_has_a_condition_and_chooses():
    x, v = ss.states("x v")
    n, last = ss.discrete(n=0.0, last=0.0)
    condition = (n < 2.5) & ~(np.float64(0) > v)
    assert str(condition) == "(n < 2.5) and (not (0.0 > v))" and condition.parts == {n, v}
    chosen = np.where((v < 0.9) | (v > 2), 1, n + v)
    assert str(chosen) == "if((v < 0.9) or (v > 2.0), 1.0, n + v)"
    turn = ss.Jump("turn", when=x, set={n: n + 1, last: chosen}, condition=condition)
    system = ss.System({x: v, v: -x}, jumps=[turn], start=[-1, 0])
    assert 'if = "(n < 2.5) and (not (0.0 > v))"' in system.to_toml()
    sol = ss.solve_ivp(system, (0, 30), system.start)
    assert np.allclose(sol.transitions["t"], np.pi * np.array([0.5, 2.5, 4.5]), rtol=0, atol=1e-9)
    assert sol.y[3, -1] == 3 and sol.y[2, -1] == pytest.approx(3, abs=1e-9)
    with pytest.raises(ss.SystemError, match="a choice can stand only at a jump"):
        ss.System({x: v, v: np.where(x < 0, 1, -1)})


@pytest.mark.parametrize("between", ["linear", "monotone"])
def test_a_curve_is_the_interpolation_of_numpy_or_scipy(between):
    points = np.array([0.0, 0.5, 1.25, 2.0, 4.0])
    values = np.array([0.4, 0.3, 0.25, 0.1, -1.0])
    x, y = ss.states("x y")
    mu = ss.Curve("mu", points, values, between=between)
    system = ss.System({x: 1, y: mu(x)}, start=[-1, 0])
    assert ss.System.from_toml(system.to_toml()) == system
    assert copy.deepcopy(mu) == mu == pickle.loads(pickle.dumps(mu))
    assert len({mu, copy.copy(mu)}) == 1
    t = np.linspace(-1, 5, 61)
    sol = ss.solve_ivp(system, (-1, 5), [-1, 0], t_eval=t)
    if between == "linear":
        fine = np.sort(np.concatenate([t, points]))
        heights = np.interp(fine, points, values)
        areas = np.diff(fine) * (heights[1:] + heights[:-1]) / 2
        wanted = np.interp(t, fine, np.concatenate([[0], np.cumsum(areas)]))
    else:
        interpolate = pytest.importorskip("scipy.interpolate")
        area = interpolate.PchipInterpolator(points, values).antiderivative()
        inside = np.clip(t, 0, 4)
        wanted = area(inside) - area(0) + 0.4 * (np.minimum(t, 0) + 1) - np.maximum(t - 4, 0)
    assert np.allclose(sol.y[1], wanted, rtol=0, atol=1e-11)


def test_a_curve_that_cannot_be_is_refused():
    x = ss.state("x")
    with pytest.raises(ValueError, match="the curve mu has 2 values of x and 1 of y"):
        ss.Curve("mu", [0, 1], [1])
    for points in ([1, 0], [1, 1]):
        with pytest.raises(ValueError, match=f"1 comes before {points[1]}, as number 1 and 2 of 2"):
            ss.Curve("mu", points, [1, 2])
    with pytest.raises(ValueError, match="it needs two at least"):
        ss.Curve("mu", [0], [1])
    with pytest.raises(ValueError, match="between = 'cubic' of the curve mu.*linear, monotone"):
        ss.Curve("mu", [0, 1], [1, 2], between="cubic")
    with pytest.raises(ValueError, match="beyond = 'zero' of the curve mu.*hold, extend, error"):
        ss.Curve("mu", [0, 1], [1, 2], beyond="zero")
    with pytest.raises(ValueError, match="mu is the name of two curves"):
        ss.System({x: ss.Curve("mu", [0, 1], [1, 2])(x) + ss.Curve("mu", [0, 1], [1, 3])(x)})
    short = ss.System({x: ss.Curve("mu", [0, 1], [1, 2], beyond="error")(x)})
    with pytest.warns(ss.SolverWarning, match="is not a number where `x` is 1"):
        ss.solve_ivp(short, (0, 5), [0])
    # A formula of a section has the curves of its system.
    mu = ss.Curve("mu", [0, 1], [1, 2])
    system = ss.System({x: mu(x)})
    sol = ss.solve_ivp(system, (0, 1), [0], events=mu(x) - 1.5)
    assert sol.t_events[0] == pytest.approx([np.log(1.5)], abs=1e-11)
    with pytest.raises(ValueError, match="mu is .* in the system and"):
        ss.solve_ivp(system, (0, 1), [0], events=ss.Curve("mu", [0, 1], [1, 3])(x) - 1.5)


def test_functions_of_scipy_take_symbols():
    special = pytest.importorskip("scipy.special")
    x = ss.state("x")
    assert str(special.erf(x)) == str(ss.erf(x)) == "erf(x)"
    sol = ss.solve_ivp(ss.System({x: ss.erf(ss.t)}), (0, 2), [0])
    wanted = 2 * special.erf(2) + np.exp(-4) / np.sqrt(np.pi) - 1 / np.sqrt(np.pi)
    assert sol.y[0, -1] == pytest.approx(wanted, abs=1e-11)


def test_a_text_comes_back_as_it_is():
    system = belt_system()
    again = ss.System.from_toml(system.to_toml())
    assert again == system and again.to_toml() == system.to_toml()
    assert again.parameters == {"k": 1.0, "mu0": 0.4, "vp": 0.2}


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))]
)
def test_systems_and_symbols_are_copied(copied):
    system = belt_system(mu0=0.3)
    again = copied(system)
    assert again == system and again.parameters["mu0"] == 0.3
    one, other = (ss.solve_ivp(s, (0, 20), [0.5, 0]) for s in (system, again))
    assert np.array_equal(one.y, other.y)
    x = ss.state("x")
    formula = copied(np.tanh(x) + ss.t)
    assert str(formula) == "tanh(x) + t" and formula.parts == {x, ss.t}
    assert copied(ss.Contact("belt", x)).boundary.text == "x"


def test_static_friction_by_a_law_of_the_side():
    x, v = ss.states("x v")
    vp = ss.parameter("vp", 0.2)
    law = lambda side: 0.4 / (1 + side * (v - vp))
    belt = ss.Contact("belt", boundary=v - vp, friction=law, static=0.6)
    system = ss.System({x: v, v: -x - belt.friction}, contacts=[belt])
    sol = ss.solve_ivp(system, (0, 30), [0.5, 0])
    leaves = sol.transitions[sol.transitions["kind"] == "stick exit"]
    # It holds up to the static friction.
    assert np.allclose(np.abs(leaves["y"][:, 0]), 0.6, atol=1e-12) and len(leaves) > 2


def test_values_of_parameters_are_only_read():
    system = belt_system()
    values = system.parameters
    for change in (
        lambda: values.__setitem__("vp", 0.9),
        lambda: values.update(vp=0.9),
        lambda: values.pop("vp"),
        lambda: values.clear(),
        lambda: values.__delitem__("vp"),
    ):
        with pytest.raises(TypeError, match=r"system\.with_parameters\(name=value\)"):
            change()
    assert system.parameters == {"k": 1.0, "mu0": 0.4, "vp": 0.2} == copy.deepcopy(values)
    assert pickle.loads(pickle.dumps(values)) == values
    assert system.with_parameters(**(values | {"vp": 0.9})).parameters["vp"] == 0.9


def test_a_parameter_keeps_to_its_range():
    x = ss.state("x")
    p = ss.parameter("p", 0.5, range=(0, np.inf))
    system = ss.System({x: -p * x})
    assert "p = { value = 0.5, range = [0.0, inf] }" in system.to_toml()
    assert system.with_parameters(p=3).parameters["p"] == 3
    with pytest.raises(ss.SystemError, match="p = -1 is not allowed: its range"):
        system.with_parameters(p=-1)
    for again in (copy.deepcopy(p), pickle.loads(pickle.dumps(p))):
        assert again == p and again.range == (0.0, np.inf) and again != ss.parameter("p", 0.5)
    with pytest.raises(ValueError, match="p is the name of two parameters"):
        ss.System({x: -p * x + ss.parameter("p", 0.5)})
    with pytest.raises(ValueError, match="parameter p = 2: it must be within its range, 0 to 1"):
        ss.parameter("p", 2, range=(0, 1))
    with pytest.raises(ValueError, match="the lower end must come first"):
        ss.parameter("p", 2, range=(3, 1))
    with pytest.raises(ss.OptionError, match="must be a number"):
        ss.parameter("p", 2, range=(np.nan, 1))
    with pytest.raises(TypeError, match=r"must be \(lowest, highest\), not 3"):
        ss.parameter("p", 2, range=3)


def room(heater=0.0, start=(18,)):
    T = ss.state("T")
    heats = ss.DiscreteState("heats", heater)
    off = ss.Jump("off", when=T - 21, direction="rising", set={heats: 0})
    on = ss.Jump("on", when=T - 19, direction="falling", set={heats: 1})
    return ss.System({T: 2 * heats - (T - 10) / 10}, jumps=[off, on], start=start)


def test_a_start_may_have_the_discrete_states_or_not():
    p = ss.parameter("p", 0.25)
    heats = ss.DiscreteState("heats", 0.0)
    assert room().start == room(start={"T": 18}).start == (18.0, 0.0)
    for start in ((18, 1), {"T": 18, "heats": 1}, {heats: 1, "T": 18}):
        assert room(start=start).start == (18.0, 1.0)
    assert room(start=(18, 2 * p)).with_parameters(p=0.5).start == (18.0, 1.0)
    wanted = r"start must be 2 values, of the states T, heats; the last 1, discrete, may be left"
    with pytest.raises(ValueError, match=wanted):
        room(start=(1, 2, 3))
    with pytest.raises(ValueError, match="a value of u, which has no rate"):
        room(start={"T": 1, "u": 3})
    with pytest.raises(ValueError, match="has no value of the state T"):
        room(start={"heats": 1})


def test_friction_of_the_wrong_sign_and_jumps_past_zero_are_doubtful():
    x, v = ss.states("x v")
    for static, sign, words in (
        (None, 1, "the friction of floor drives the slip"),
        (0.1, -1, "static friction of floor is less than friction in slip"),
        (0.5, -1, None),
    ):
        floor = ss.Contact("floor", boundary=v, friction=0.4, static=static)
        system = ss.System({x: v, v: sign * floor.friction - x}, contacts=[floor])
        # Without a start there is no place to look at.
        assert system.check() == []
        assert [words in one for one in system.check([0, 1])] == ([True] if words else [])
        assert system.check({v: 1, x: 0}) == system.check([0, 1])
    assert "the jump on happens where T - 19.0 falls" in room().check()[0]
    assert room().check([18, 1]) == room().check([20]) == room(1).check() == []
    wrong = ss.System({x: np.cos(ss.t) - x}, period=3.0)
    assert "correct period=… of System" in wrong.check()[0]


def test_faults_come_with_a_remedy():
    v = ss.state("v")
    floor = ss.Contact("floor", boundary=v, friction=0.4, static=0.1)
    system = ss.System({v: np.sin(ss.t) - floor.friction}, contacts=[floor])
    with pytest.warns(ss.SolverWarning, match="raise it, or lower friction in slip"):
        ss.solve_ivp(system, (0, 30), [0.1])
    open_bracket = "name = 'open'\n[states]\nx = ''\n[field]\nx = 'sin(x'\n"
    with pytest.raises(ss.SystemError, match=r"not closed(.|\n)*it ends with `\)`"):
        ss.System.from_toml(open_bracket)
