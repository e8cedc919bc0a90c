"""Runs the code blocks of the site, in order, each page in an empty folder of its own.

Python blocks of a page share their names. Shell blocks run with `stickslip` on the path, and the
output of a `console` block is compared line by line, with `...` for what may differ. A block with
a caption is written to the file of that name. Pictures that pages show go to `$PICTURES`.
"""

import doctest
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
from sybil import Sybil
from sybil.parsers.myst import CodeBlockParser, PythonCodeBlockParser

matplotlib.use("svg")
# Two builds make the same pictures.
matplotlib.rcParams["svg.hashsalt"] = "stickslip"

HERE = Path(__file__).parent
PICTURES = HERE / "_pictures"


def environment():
    program = shutil.which(os.environ.get("STICKSLIP", "stickslip"))
    assert program, "STICKSLIP names no program: build it by cargo build -p stickslip-cli"
    path = f"{Path(program).resolve().parent}{os.pathsep}{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "PICTURES": str(PICTURES), "REPOSITORY": str(HERE.parent)}


def shell(commands):
    run = ["bash", "-euo", "pipefail", "-c", commands]
    done = subprocess.run(
        run, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    return done.returncode, done.stdout


def run_shell(example):
    status, output = shell(example.parsed)
    assert status == 0, f"exit code {status}:\n{output}"


def run_console(example):
    """Compares what each command prints, errors among it; a last line `[1]` is its exit code."""
    for part in re.split(r"^\$ ", example.parsed, flags=re.M)[1:]:
        command, _, wanted = part.partition("\n")
        while command.endswith("\\"):
            line, _, wanted = wanted.partition("\n")
            command += "\n" + line.removeprefix("> ")
        status, output = shell(command)
        if status:
            output += f"[{status}]\n"
        flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
        matches = doctest.OutputChecker().check_output(wanted, output, flags)
        assert matches, f"{command}\nprints\n{output}\ninstead of\n{wanted}"


def write_file(example):
    name = example.region.lexemes.get("options", {}).get("caption")
    assert name, "a block of TOML needs a :caption: with the name of its file"
    Path(name).write_text(example.parsed.lstrip("\n"), encoding="utf-8")


def save(name, figure, size=(6, 3)):
    """Saves a picture that a page shows; the date is left out, so that it is always the same."""
    figure.set_size_inches(size)
    figure.savefig(PICTURES / name, bbox_inches="tight", metadata={"Date": None})


def setup(namespace):
    namespace["_was"] = Path.cwd()
    namespace["_folder"] = tempfile.mkdtemp()
    namespace.update(save=save, REPOSITORY=HERE.parent)
    PICTURES.mkdir(exist_ok=True)
    os.chdir(namespace["_folder"])


def teardown(namespace):
    plt.close("all")
    os.chdir(namespace["_was"])
    shutil.rmtree(namespace["_folder"])


pytest_collect_file = Sybil(
    parsers=[
        PythonCodeBlockParser(),
        CodeBlockParser("sh", run_shell),
        CodeBlockParser("console", run_console),
        CodeBlockParser("toml", write_file),
    ],
    patterns=["*.md"],
    excludes=["reference/_program.md"],
    setup=setup,
    teardown=teardown,
).pytest()
