"""Runs every example of the gallery by itself and keeps its pictures as PNG.

    python docs/gallery/check.py FOLDER [NAME...]

Names that are given select examples. The exit code is the number of examples that fail.
sphinx-gallery takes the look of the pictures from `apply_style`.
"""

import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ONE = """
import runpy, sys
import matplotlib
matplotlib.use("agg")
import matplotlib.pyplot as plt
import check
check.apply_style()
runpy.run_path(sys.argv[1], run_name="__main__")
for number in plt.get_fignums():
    plt.figure(number).savefig(f"{sys.argv[2]}-{number}.png")
"""


def apply_style(_conf=None, _name=None):
    """The look of every picture; sphinx-gallery calls it before each example."""
    import matplotlib.pyplot as plt

    plt.style.use(HERE / "gallery.mplstyle")


def main(folder, names):
    folder = Path(folder).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    failed = 0
    for example in sorted(HERE.glob("plot_*.py")):
        if names and not any(name in example.stem for name in names):
            continue
        begin = time.perf_counter()
        command = [sys.executable, "-W", "error", "-c", ONE, example, folder / example.stem]
        done = subprocess.run(command, cwd=HERE)
        failed += done.returncode != 0
        word = "FAILED" if done.returncode else "ok"
        print(f"{example.stem}: {word}, {time.perf_counter() - begin:.1f} s\n", flush=True)
    return failed


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
