"""Runs every example of the gallery by itself and keeps its pictures as PNG.

    python docs/gallery/check.py FOLDER [NAME...]

Names that are given select examples. The exit code is the number of examples that fail.
"""

import os
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
plt.style.use(sys.argv[1])
runpy.run_path(sys.argv[2], run_name="__main__")
for number in plt.get_fignums():
    plt.figure(number).savefig(f"{sys.argv[3]}-{number}.png")
"""


def main(folder, names):
    folder = Path(folder).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    failed = 0
    for example in sorted(HERE.glob("plot_*.py")):
        if names and not any(name in example.stem for name in names):
            continue
        begin = time.perf_counter()
        command = [sys.executable, "-W", "error", "-c", ONE, HERE / "gallery.mplstyle", example]
        done = subprocess.run([*command, folder / example.stem], cwd=HERE, env=os.environ)
        failed += done.returncode != 0
        word = "FAILED" if done.returncode else "ok"
        print(f"{example.stem}: {word}, {time.perf_counter() - begin:.1f} s\n", flush=True)
    return failed


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
