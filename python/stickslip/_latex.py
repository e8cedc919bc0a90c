"""Formulas in LaTeX, for notebooks."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

# Precedence of operators, as formulas have it: `-x^2` is `-(x^2)`.
_SUM, _PRODUCT, _SIGN, _POWER, _ATOM = range(5)

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_TOKEN = re.compile(rf"\s*(?:({_NUMBER})|([^\W\d][\w.]*)|(.))")
_GREEK = {
    *"alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho".split(),
    *"sigma tau upsilon phi chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Phi Psi".split(),
    "Omega",
}
_NAMES = {
    **{name: f"\\{name}" for name in "sin cos tan sinh cosh tanh exp ln min".split()},
    **{"max": r"\max", "asin": r"\arcsin", "acos": r"\arccos", "atan": r"\arctan"},
    **{"log10": r"\log_{10}", "friction": "F"},
}


def symbol(name: str) -> str:
    """A name: Greek where it is the name of a letter, with digits and further words as an index."""
    head, _, tail = name.replace(".", "_").partition("_")
    digits = re.fullmatch(r"(\D+?)(\d+)", head)
    if digits and not tail:
        head, tail = digits.groups()
    text = f"\\{head}" if head in _GREEK else head if len(head) == 1 else rf"\mathrm{{{head}}}"
    return f"{text}_{{{_words(tail)}}}" if tail else text


def _words(text: str) -> str:
    plain = text.replace("_", r"\ ")
    return plain if text.isdigit() or len(text) == 1 else rf"\mathrm{{{plain}}}"


class _Parser:
    """Reads a formula and writes it again, each part with its precedence."""

    def __init__(self, text: str) -> None:
        self._tokens = [match.groups() for match in _TOKEN.finditer(text.strip())]
        self._at = 0

    def _peek(self) -> str:
        if self._at >= len(self._tokens):
            return ""
        return next(one for one in self._tokens[self._at] if one is not None)

    def _next(self) -> tuple[str | None, str | None, str | None]:
        self._at += 1
        number, name, sign = self._tokens[self._at - 1]
        return number, name, sign

    def sum(self) -> tuple[str, int]:
        left, binds = self._product()
        while self._peek() in ("+", "-"):
            sign = self._next()[2]
            right, inner = self._product()
            left, binds = f"{left} {sign} {_within(right, inner, _PRODUCT)}", _SUM
        return left, binds

    def _product(self) -> tuple[str, int]:
        left, binds = self._signed()
        while self._peek() in ("*", "/", "·", "×"):
            sign = self._next()[2]
            right, inner = self._signed()
            if sign == "/":
                left, binds = rf"\frac{{{left}}}{{{right}}}", _ATOM
            else:
                a, b = _within(left, binds, _PRODUCT), _within(right, inner, _POWER)
                left, binds = rf"{a} \cdot {b}" if b[:1].isdigit() else rf"{a}\,{b}", _PRODUCT
        return left, binds

    def _signed(self) -> tuple[str, int]:
        if self._peek() == "-":
            self._next()
            inner, binds = self._signed()
            return f"-{_within(inner, binds, _PRODUCT)}", _SIGN
        return self._power()

    def _power(self) -> tuple[str, int]:
        base, binds = self._atom()
        if self._peek() == "^":
            self._next()
            exponent = self._signed()[0]
            return f"{_within(base, binds, _ATOM)}^{{{exponent}}}", _POWER
        return base, binds

    def _atom(self) -> tuple[str, int]:
        number, name, sign = self._next()
        if number is not None:
            return _number(number), _ATOM
        if name is not None:
            return self._named(name)
        if sign != "(":
            return str(sign), _ATOM
        inner, binds = self.sum()
        self._next()
        return inner, binds

    def _named(self, name: str) -> tuple[str, int]:
        if self._peek() != "(":
            return symbol(name), _ATOM
        of = []
        while self._next()[2] in ("(", ","):
            of.append(self.sum()[0])
        return _call(name, of), _ATOM


def _call(name: str, of: list[str]) -> str:
    if name == "sqrt":
        return rf"\sqrt{{{of[0]}}}"
    if name == "abs":
        return rf"\left|{of[0]}\right|"
    if name == "friction":
        return rf"F_{{{of[0]}}}"
    if name == "by_side":
        below, above = (rf"{of[k]} & {of[0]} {sign} 0" for k, sign in ((1, "<"), (2, ">")))
        return rf"\begin{{cases}} {below} \\ {above} \end{{cases}}"
    known = _NAMES.get(name, rf"\operatorname{{{name}}}")
    return rf"{known}\left({', '.join(of)}\right)"


def _number(text: str) -> str:
    plain = text.removesuffix(".0")
    digits, _, power = plain.lower().partition("e")
    return rf"{digits} \cdot 10^{{{int(power)}}}" if power else plain


def _within(text: str, binds: int, least: int) -> str:
    return text if binds >= least else rf"\left({text}\right)"


def latex(text: str) -> str:
    """A formula in LaTeX."""
    return _Parser(text).sum()[0]


def _formula(value: Any) -> str:
    return latex(str(value))


def system_latex(file: Mapping[str, Any]) -> str:
    """The equations of a system, from the tables of its file."""
    rates = file["field"].items()
    lines = [rf"\dot{{{symbol(state)}}} &= {_formula(rate)}" for state, rate in rates]
    for name, value in file.get("definitions", {}).items():
        lines.append(rf"{symbol(name)} &= {_formula(value)}")
    for name, contact in file.get("contacts", {}).items():
        side = symbol(name)
        lines.append(rf"{side} &= \operatorname{{sgn}}\left({_formula(contact['boundary'])}\right)")
        if "friction" in contact:
            lines.append(rf"F_{{{side}}} &= {side}\left({_formula(contact['friction'])}\right)")
    for name, jump in file.get("jumps", {}).items():
        values = jump.get("set", {}).items()
        changes = [rf"{symbol(state)} \to {_formula(value)}" for state, value in values]
        what = ",\\ ".join(changes) or r"\text{end}"
        lines.append(rf"{_formula(jump['when'])} = 0 &: {what}")
    return "$$\\begin{aligned} " + r" \\ ".join(lines) + " \\end{aligned}$$"
