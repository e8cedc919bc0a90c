"""Solves one problem once and prints its events: what is timed as a whole process.

It imports only what its solver needs.

    python3 one.py problems.json --problem decay --solver heyoka --setting tol --tolerance 1e-12
"""

import argparse
import importlib

import systems

MODULES = {
    "SciPy": "with_scipy",
    "numba": "with_numba",
    "heyoka": "with_heyoka",
    "pydiffsol": "with_diffsol",
}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("problems")
    for name in ("problem", "solver", "setting"):
        parser.add_argument(f"--{name}", required=True)
    parser.add_argument("--tolerance", type=float, required=True)
    wanted = parser.parse_args()
    peer = importlib.import_module(MODULES[wanted.solver.split()[0]])
    problem = systems.load(wanted.problems)[wanted.problem]
    for solver, setting, tolerance, build in peer.curves(problem, systems.make(problem)):
        if (solver, setting, tolerance) == (wanted.solver, wanted.setting, wanted.tolerance):
            call, _ = build()
            for kind, t in call():
                print(f"{kind},{t!r}")
            return
    parser.error(
        f"{wanted.solver} has no setting '{wanted.setting}' with tolerance {wanted.tolerance}"
    )


if __name__ == "__main__":
    main()
