"""Formulas and systems of symbols."""

import copy
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
        (lambda x: x > 0, "by_side"),
        (lambda x: np.where(x, 1, 2), "by_side"),
        (lambda x: np.sign(x), r"\.side"),
        (lambda x: np.arcsin(x), "the functions are"),
        (lambda x: float(x), "not a number"),
        (lambda x: x + "1", "unsupported operand"),
        (lambda x: np.complex128(1j) * x, "operand type"),
        (lambda x: np.clip(x, 0, 1), r"np.minimum\(np.maximum"),
        (lambda x: ss.Jump("hit", when=x, count=1.5), "count must be a whole number"),
        (lambda x: ss.System({x: x == 1}), "False cannot stand in a formula"),
        (lambda x: ss.System({ss.states("x"): 1}), "returns a tuple"),
        (lambda x: ss.System({x: 1}, contacts=["belt"]), "contacts must be made by ss.Contact"),
        (lambda x: ss.Jump("hit", when=x, set={"x": 1}), "'x' is no state"),
        (lambda x: ss.Jump("hit", when=x < 0), "with a direction"),
    ],
)
def test_misuse_says_what_to_write_instead(misuse, words):
    with pytest.raises(TypeError, match=words):
        misuse(ss.state("x"))


def test_a_number_that_is_none_is_refused_by_name():
    with pytest.raises(ValueError, match="the parameter mu0 = nan"):
        ss.parameters(mu0=float("nan"))
    with pytest.raises(ValueError, match="the parameter mu0 = inf"):
        belt_system(mu0=np.inf)
    with pytest.raises(ss.SystemError, match="mu0"):
        belt_system(mu=0.3)


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
    with pytest.raises(ValueError, match="two different things are called k"):
        ss.System({x: ss.parameter("k", 1.0) * v, v: ss.parameter("k", 2.0) * x})
    with pytest.raises(ValueError, match="two different things are called k"):
        ss.System({x: ss.parameter("k", 1.0) * x + ss.parameter("k", 2.0)})


def test_one_contact_or_jump_needs_no_list_and_directions_are_words_or_signs():
    x, v = ss.states("x v")
    falling = ss.Jump("hit", when=x, direction=-1, set={v: -v})
    assert ss.System({x: v, v: -1}, jumps=falling).jumps == ("hit",)
    assert falling.direction == ss.Jump("hit", when=x, direction="falling").direction
    assert ss.event(x, "rising") == ss.event(x, 2) and ss.event(x, "falling").direction == -1
    with pytest.raises(ValueError, match="direction = 'up'"):
        ss.event(x, "up")
    assert belt_system().with_parameters({ss.parameter("mu0", 0): 0.1}).parameters["mu0"] == 0.1


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
