"""Taylor coefficients of functions of a polynomial, to 30 digits, by numerical differentiation (mpmath 1.3).

Writes coefficients.csv beside this file: function,order,coefficient. The argument is u(s) = 3/4 + s/2 - s^2/4 + s^3/8.
Everything is computed twice, with 200 and with 300 digits, and written only where the two agree.
"""

import pathlib

from mpmath import mp, mpf, nstr

ORDER = 24
FUNCTIONS = {
    "product": lambda u: u * (u * u),
    "quotient": lambda u: (u * u) / (1 + u),
    "recip": lambda u: 1 / u,
    "powi": lambda u: u ** -3,
    "powf": lambda u: u ** mpf("2.5"),
    "sqrt": mp.sqrt,
    "exp": mp.exp,
    "ln": mp.ln,
    "sin": mp.sin,
    "cos": mp.cos,
    "tan": mp.tan,
    "atan": mp.atan,
    "sinh": mp.sinh,
    "cosh": mp.cosh,
    "tanh": mp.tanh,
}


def argument(s):
    return mpf(3) / 4 + s / 2 - s**2 / 4 + s**3 / 8


def coefficients(function, digits):
    mp.dps = digits
    return mp.taylor(lambda s: function(argument(s)), 0, ORDER)


rows = ["function,order,coefficient"]
for name, function in FUNCTIONS.items():
    for k, (a, b) in enumerate(zip(coefficients(function, 300), coefficients(function, 200))):
        assert abs(a - b) <= mpf(10) ** -35 * max(abs(a), mpf(10) ** -10), (name, k)
        rows.append(f"{name},{k},{nstr(a, 30)}")
path = pathlib.Path(__file__).with_name("coefficients.csv")
path.write_text("\n".join(rows) + "\n")
