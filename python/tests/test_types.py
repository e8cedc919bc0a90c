"""Types: those that the package says, to a strict checker; the examples of its docstrings run."""

import doctest
import importlib
import subprocess
import sys

import numpy as np
import pytest
import stickslip

SAMPLE = """
import numpy as np
import stickslip as ss

x, v = ss.states("x v")
(vp,) = ss.parameters(vp=0.2)
belt = ss.Contact("belt", boundary=v - vp)
system = ss.System({x: v, v: -x - 0.4 * belt.side}, contacts=[belt])
sol = ss.solve_ivp(system, (0, 5), [0.5, 0], events=[ss.event(v, direction=-1)])
orbit: ss.PeriodicOrbit = ss.periodic_orbit(system, [0.5, 0.0])
basins: ss.Basins = ss.basins_of_attraction(system, [[0.5, 0.0]], rtol=1e-9, workers=1)
many: ss.Ensemble = ss.ensemble(system, [[0.5, 0.0]], (0, 1), reduce=lambda one: one.y[0, -1])
print(many.reduced, sol.transitions["y"], sol["t"], orbit.keys())
print(basins.shares, float(sol.t[-1]), orbit.period, np.asarray(sol.y).shape, sol.success)
"""


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """A strict check of a program; what is read of NumPy is kept from one to the next."""
    folder = tmp_path_factory.mktemp("mypy")

    def check(text):
        sample = folder / "sample.py"
        sample.write_text(text, encoding="utf-8")
        run = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", "cache", "sample.py"]
        return subprocess.run(run, capture_output=True, text=True, cwd=folder)

    return check


def test_types_are_those_that_the_package_says(checked):
    done = checked(SAMPLE)
    assert done.returncode == 0, done.stdout


def test_an_option_that_is_none_is_refused_by_the_checker(checked):
    done = checked(SAMPLE.replace("rtol=1e-9", "rtoll=1e-9"))
    assert done.returncode == 1 and "rtoll" in done.stdout


def test_the_stubs_are_those_of_the_engine(tmp_path):
    run = [sys.executable, "-m", "mypy.stubtest", "stickslip._core"]
    done = subprocess.run(run, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


MODULES = [
    *("", "._attractors", "._basins", "._ensemble", "._errors", "._exponents", "._orbits", "._run"),
    *("._sympy", "._system"),
]


@pytest.mark.parametrize("name", MODULES)
def test_examples_of_docstrings_run(name):
    module = importlib.import_module("stickslip" + name)
    failed, tried = doctest.testmod(module, extraglobs={"np": np})
    assert failed == 0 and tried > 0


def test_every_function_has_its_reference():
    functions = [getattr(stickslip, name) for name in stickslip.__all__]
    for one in functions:
        modules = {"stickslip._attractors", "stickslip._exponents", "stickslip._orbits"}
        modules |= {"stickslip._run", "stickslip._ensemble", "stickslip._sympy"}
        if getattr(one, "__module__", "") in modules:
            if callable(one) and not isinstance(one, type):
                assert "Parameters" in one.__doc__ and "Returns" in one.__doc__, one.__name__
