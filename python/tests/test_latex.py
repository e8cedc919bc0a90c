"""Formulas in LaTeX: exact texts, and the values that a reader of the LaTeX finds."""

import math
import re

import numpy as np
import pytest
import stickslip as ss

x, v = ss.states("x v")


@pytest.mark.parametrize(
    ("formula", "wanted"),
    [
        ((x / v) ** 2, r"\left(\frac{x}{v}\right)^{2}"),
        (np.sqrt(x) ** 2, r"\left(\sqrt{x}\right)^{2}"),
        (1e-30**x, r"\left(1 \cdot 10^{-30}\right)^{x}"),
        ((x**2) ** v, r"\left(x^{2}\right)^{v}"),
        (x ** (v**2), r"x^{v^{2}}"),
        (abs(x) ** 2, r"\left|x\right|^{2}"),
        (x * 1e-3, r"x \cdot 0.001"),
        (x * 1e-30, r"x \cdot 1 \cdot 10^{-30}"),
        (2 * (x / v), r"2 \cdot \frac{x}{v}"),
        (x * (x / v), r"x\,\frac{x}{v}"),
        (x - (-v), r"x - \left(-v\right)"),
        (-(-x), r"-\left(-x\right)"),
        (-(x**2), r"-x^{2}"),
        ((-x) ** 2, r"\left(-x\right)^{2}"),
        (x - (v - 1), r"x - \left(v - 1\right)"),
        (
            np.where(x < 1, x, v) ** 2,
            r"\left(\begin{cases} x & \text{if } x < 1 \\ v & \text{otherwise} \end{cases}"
            r"\right)^{2}",
        ),
        ((x < 1) & ~(x * 2 >= v + 1), r"x < 1 \land \lnot \left(x \cdot 2 \ge v + 1\right)"),
    ],
)
def test_a_formula_has_this_latex(formula, wanted):
    assert formula._repr_latex_() == f"${wanted}$"


def test_a_jump_says_where_and_what():
    wall = ss.Jump("wall", when=x, direction=-1, set={v: -0.8 * v}, condition=v < -0.1)
    assert wall._repr_latex_() == (
        r"$x = 0\ \text{(falling)}\ \text{if}\ v < -0.1: v \to -0.8\,v$"
    )
    end = ss.Jump("end", when=x - 3, stop=True)
    assert end._repr_latex_() == r"$x - 3 = 0: \text{end}$"
    system = ss.System({x: v, v: -1.0}, jumps=[wall, end])
    assert r"x - 3 = 0 &: \text{end}" in system._repr_latex_()


class Reader:
    """Reads LaTeX as TeX groups it and as it is read on paper, and evaluates it.

    A power has a base of one piece: a letter, a number, or what stands in brackets. A second
    exponent on the same base is an error, as in TeX.
    """

    TOKEN = re.compile(
        r"\s*(\\left[(|]|\\right[)|]|\\begin\{cases\}|\\end\{cases\}|\\text\{[^}]*\}"
        r"|\\operatorname\{\w+\}|\\log_\{10\}|\\[a-zA-Z]+|\\\\|\\,|\d+\.?\d*|[a-z]|[-+^_{}<>&,])"
    )
    FUNCTIONS = {r"\sin": math.sin, r"\cos": math.cos, r"\exp": math.exp, r"\max": max}
    FUNCTIONS[r"\operatorname{hypot}"] = math.hypot

    def __init__(self, text, values):
        found = [one.group(1) for one in self.TOKEN.finditer(text)]
        assert "".join(found).replace(" ", "") == text.replace(" ", ""), text
        self.tokens, self.values, self.at = [*found, ""], values, 0

    def peek(self):
        return self.tokens[self.at]

    def take(self, *wanted):
        found = self.tokens[self.at]
        assert not wanted or found in wanted, (found, wanted, self.tokens)
        self.at += 1
        return found

    def group(self, read):
        self.take("{")
        found = read()
        self.take("}")
        return found

    def whole(self):
        found = self.argument()
        assert self.peek() == "", self.tokens[self.at :]
        return found

    def sum(self):
        found = -self.product() if self.peek() == "-" and self.take() else self.product()
        while self.peek() in ("+", "-"):
            sign = 1 if self.take() == "+" else -1
            found += sign * self.product()
        return found

    def product(self):
        found, first = self.power()
        while self.peek() in (r"\cdot", r"\,"):
            is_side_by_side = self.take() == r"\,"
            other, second = self.power()
            # Side by side, a number would join another one or a fraction, and a bracket would
            # be the argument of a function.
            assert not (is_side_by_side and second == "number")
            assert not (is_side_by_side and second == "bracket")
            assert not (is_side_by_side and first == "number" and second == "fraction")
            found, first = found * other, second
        return found

    def power(self):
        found, kind = self.piece()
        if self.peek() == "^":
            assert kind in ("letter", "number", "bracket", "bars", "call"), kind
            self.take()
            found, kind = found ** self.group(self.argument), "power"
            assert self.peek() != "^"
        return found, kind

    def piece(self):
        token = self.take()
        if token == r"\frac":
            above = self.group(self.argument)
            return above / self.group(self.argument), "fraction"
        if token == r"\sqrt":
            return math.sqrt(self.group(self.argument)), "root"
        if token == r"\left(":
            found = self.argument()
            self.take(r"\right)")
            return found, "bracket"
        if token == r"\left|":
            found = abs(self.argument())
            self.take(r"\right|")
            return found, "bars"
        if token in self.FUNCTIONS:
            self.take(r"\left(")
            of = [self.argument()]
            while self.peek() == ",":
                self.take()
                of.append(self.argument())
            self.take(r"\right)")
            return self.FUNCTIONS[token](*of), "call"
        if token[0].isdigit():
            return float(token), "number"
        return self.values[token], "letter"

    def argument(self):
        return self.cases() if self.peek() == r"\begin{cases}" else self.sum()

    def cases(self):
        self.take(r"\begin{cases}")
        then = self.argument()
        self.take("&"), self.take(r"\text{if }")
        left = self.sum()
        is_less = self.take("<", ">") == "<"
        right = self.sum()
        holds = left < right if is_less else left > right
        self.take("\\\\")
        otherwise = self.argument()
        self.take("&"), self.take(r"\text{otherwise}"), self.take(r"\end{cases}")
        return then if holds else otherwise


def drawn(random, depth):
    """A formula of random parts, and its value as a function of x and v."""
    if depth == 0:
        which = int(random.integers(4))
        if which == 0:
            return x, lambda a, b: a
        if which == 1:
            return v, lambda a, b: b
        number = [0.5, 2.0, 3e-7, 4e20][int(random.integers(4))]
        return ss._symbols.expression(number), lambda a, b: number
    (one, f), (other, g) = (drawn(random, depth - 1) for _ in range(2))
    made = [
        (lambda: one + other, lambda a, b: f(a, b) + g(a, b)),
        (lambda: one - other, lambda a, b: f(a, b) - g(a, b)),
        (lambda: one * other, lambda a, b: f(a, b) * g(a, b)),
        (lambda: one / other, lambda a, b: f(a, b) / g(a, b)),
        (lambda: -one, lambda a, b: -f(a, b)),
        (lambda: one**2, lambda a, b: f(a, b) ** 2),
        (lambda: abs(one) ** other, lambda a, b: abs(f(a, b)) ** g(a, b)),
        (lambda: 3e-7**other, lambda a, b: 3e-7 ** g(a, b)),
        (lambda: np.sqrt(abs(one)) ** 3, lambda a, b: math.sqrt(abs(f(a, b))) ** 3),
        (lambda: np.sin(one), lambda a, b: math.sin(f(a, b))),
        (lambda: np.hypot(one, other), lambda a, b: math.hypot(f(a, b), g(a, b))),
        (lambda: np.maximum(one, other), lambda a, b: max(f(a, b), g(a, b))),
        (
            lambda: np.where(one < other, one, other),
            lambda a, b: f(a, b) if f(a, b) < g(a, b) else g(a, b),
        ),
    ]
    formula, value = made[int(random.integers(len(made)))]
    return formula(), value


def test_random_formulas_have_the_value_that_their_latex_has():
    random = np.random.default_rng(7)
    seen, finite = set(), 0
    for _ in range(1500):
        formula, value = drawn(random, int(random.integers(1, 5)))
        shown = formula._repr_latex_()
        seen |= set(re.findall(r"\\[a-z]+", shown))
        reader = Reader(shown[1:-1], {"x": 0.7, "v": 1.3})
        try:
            wanted = value(0.7, 1.3)
        except (OverflowError, ZeroDivisionError):
            continue
        found = reader.whole()
        assert found == wanted or math.isclose(found, wanted, rel_tol=1e-6), (shown, formula)
        finite += 1
    assert finite > 1000
    assert {r"\frac", r"\sqrt", r"\left", r"\begin", r"\cdot", r"\sin"} <= seen
