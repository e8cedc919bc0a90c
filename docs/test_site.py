"""The reference names every error, key, function and name that there is, and every block is run."""

import collections
import csv
import inspect
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import stickslip

HERE = Path(__file__).parent
CRATES = HERE.parent / "crates"


def page(name):
    return (HERE / "reference" / name).read_text(encoding="utf-8")


def test_every_error_of_the_library_has_a_section():
    def variants(file, name):
        source = (CRATES / "stickslip/src" / file).read_text(encoding="utf-8")
        body = source.split(f"pub enum {name} {{")[1].split("\n}\n")[0]
        return re.findall(r"^    ([A-Z]\w+) \{", body, re.M)

    errors, faults = variants("error.rs", "Error"), variants("contact_fault.rs", "ContactFault")
    assert len(errors) > 20 and len(faults) >= 5
    # `Contacts` carries one of the faults, and each has its section.
    errors.remove("Contacts")
    assert sorted(errors + faults) == sorted(re.findall(r"^### (\w+)$", page("errors.md"), re.M))


def test_every_key_of_a_file_is_in_a_table():
    folder = CRATES / "stickslip-model/src/file"
    source = "".join(file.read_text(encoding="utf-8") for file in sorted(folder.glob("*.rs")))
    lists = re.findall(r"\.only\(&\[(.*?)\]\)|const ENTRIES[^=]*= \[(.*?)\];", source, re.S)
    keys = {key for pair in lists for key in re.findall(r'"(\w+)"', "".join(pair))}
    assert {"boundary", "between", "ranges"} <= keys
    told = page("file.md")
    assert not [key for key in keys if not re.search(rf"`\[?{key}\b", told)]


def test_every_function_of_expressions_is_listed():
    folder = CRATES / "stickslip-model/src/expression"
    source = (folder / "functions.rs").read_text(encoding="utf-8")
    functions = re.findall(r'\("(\w+)", Function::', source)
    row = next(line for line in page("file.md").splitlines() if line.startswith("| functions"))
    assert len(functions) > 9 and set(functions) <= set(re.findall(r"\w+", row))


def test_every_name_of_the_package_is_listed():
    listed = re.findall(r"^   (\w+)$|`ss\.(t|pi)`", page("python.md"), re.M)
    listed = [one or other for one, other in listed]
    # A name that is listed twice would be two things.
    assert sorted(listed) == sorted(name for name in stickslip.__all__ if name[0] != "_")


def test_a_name_of_the_package_means_one_thing():
    """What a module calls by the name of a thing at top level is that thing, and every result is
    at top level and in the table of results."""
    modules = {key: one for key, one in sys.modules.items() if key.startswith("stickslip._")}
    del modules["stickslip._core"]
    own = {
        (module, name): one
        for module, of in modules.items()
        for name, one in vars(of).items()
        if getattr(one, "__module__", None) == module and name[0] != "_"
    }
    assert len(own) > 100
    for (module, name), one in own.items():
        if inspect.isclass(one) and name in stickslip.__all__:
            assert getattr(stickslip, name) is one, f"{module}.{name}"
    told = (HERE / "how-to/tables.md").read_text(encoding="utf-8")
    rows = "".join(re.findall(r"^\| (`.*?) \|", told, re.M))
    results = {one for one in own.values() if inspect.isclass(one) and hasattr(one, "_columns")}
    results = {one.__name__ for one in results} - {"Result"}
    assert len(results) > 18 and results <= set(stickslip.__all__)
    assert not [name for name in results if f"`{name}`" not in rows]


def help_of(*command):
    program = shutil.which(os.environ.get("STICKSLIP", "stickslip"))
    assert program, "STICKSLIP names no program: build it by cargo build -p stickslip-cli"
    done = subprocess.run([program, *command, "--help"], capture_output=True, text=True, check=True)
    return done.stdout


def argument_exists(name, argument):
    """Whether a function, class or method of the package takes an argument."""
    found = stickslip
    for part in name.split("."):
        found = getattr(found, part)
    if found is stickslip.Options:
        return argument in found.__annotations__
    return argument is None or argument in inspect.signature(found).parameters


def test_every_option_of_the_program_has_its_argument_in_python():
    text = page("program-python.md")
    sections = dict(re.findall(r"^## (.+?)\n(.*?)(?=^## |\Z)", text, re.M | re.S))
    rows = {
        title: dict(re.findall(r"^\| `([^`]+)` \| ([^|]+) \|", body, re.M))
        for title, body in sections.items()
    }
    without = re.findall(r"^\| `[^`]+` \| — \| ?(.*?) \|$", text, re.M)
    assert without and all(without), "an option without an argument needs its reason"
    shared = rows.pop("Options of several commands")
    alone = rows.pop("In Python alone")
    commands = re.findall(r"^  ([a-z]+) ", help_of().split("Commands:")[1].split("Options:")[0], re.M)
    commands.remove("help")
    assert len(commands) > 10 and {f"`{name}`" for name in commands} == set(rows)
    used = set()
    for name in commands:
        own = rows[f"`{name}`"]
        # Options begin a line; further text may name others.
        options = set(re.findall(r"^ {2,6}(?:-\w, )?(--[a-z-]+)", help_of(name), re.M))
        assert options, name
        assert not [one for one in options if one not in own and one not in shared], name
        assert not [one for one in own if one != name and one not in options], name
        used |= options & set(shared)
    assert used == set(shared)
    cells = [cell for table in (shared, *rows.values()) for cell in table.values()]
    cells += [f"`{name}`" for name in alone]
    named = set()
    for cell in cells:
        if cell == "—":
            continue
        name, argument = re.fullmatch(r"`([\w.]+)(?:\((\w+)\))?`", cell).groups()
        assert argument_exists(name, argument), cell
        named.add(name)
    functions = {
        name
        for name in stickslip.__all__
        if inspect.isfunction(one := getattr(stickslip, name))
        and one.__module__.removeprefix("stickslip._") not in ("symbols", "core")
    }
    assert functions - named <= {"event"}


def test_every_block_is_run_or_is_text():
    run = {"python", "sh", "console", "toml"}
    for file in sorted(HERE.rglob("*.md")):
        blocks = re.findall(r"^```([^\n]+)$", file.read_text(encoding="utf-8"), re.M)
        languages = {block.split("} ")[1] for block in blocks if block.startswith("{code-block}")}
        languages |= {block for block in blocks if not block.startswith("{")}
        assert languages <= run | {"text"}, file


def test_every_bifurcation_is_in_a_table():
    folder = CRATES / "stickslip/src/analysis"
    names = []
    types = {
        "cycle/sequence_change.rs": "SequenceBifurcation",
        "continuation/mod.rs": "CycleBifurcation",
    }
    for file, type_name in types.items():
        source = (folder / file).read_text(encoding="utf-8")
        body = source.split(f"Display for {type_name} ")[1].split("\n}\n")[0]
        names += re.findall(r'"([\w -]+)"', body)
    assert len(names) > 11
    assert not [name for name in names if f"| `{name}` |" not in page("bifurcations.md")]


def names_of_the_readme(file):
    text = (HERE.parent / file).read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", text, re.S)
    names = {}
    exec(compile(block, file, "exec"), names)
    return names


def test_the_readme_runs_as_it_stands():
    names = names_of_the_readme("README.md")
    first = names["sol"].phases[names["sol"].phases["mode"] == "S"][0]
    assert abs(first["t_start"] - 0.2446888017832978) < 1e-11


def test_the_readme_of_the_python_package_runs_and_names_what_there_is():
    names = names_of_the_readme("python/README.md")
    assert list(names["sol"].phases["mode"][:3]) == ["-", "S", "-"]
    # Stick takes the direction across the belt away.
    assert sorted(abs(names["orbit"].multipliers).round(9)) == [0, 1]
    text = (HERE.parent / "python/README.md").read_text(encoding="utf-8")
    called = set(re.findall(r"`([a-z_]+)(?:\(.*\))?`", text)) - {"stickslip"}
    fields = {"t_eval", "events", "dense_output", "status", "message"}
    extras = {"plot", "pandas", "xarray", "progress", "sympy"}
    assert not [name for name in called - fields - extras if not hasattr(stickslip, name)]


def test_the_article_says_what_the_tables_hold():
    root = HERE.parent
    text = (root / "joss/paper.md").read_text(encoding="utf-8")
    text = " ".join(text.split("# First use")[1].split())
    with open(root / "report/claims.csv", encoding="utf-8") as file:
        found = collections.Counter(row["verdict"] for row in csv.DictReader(file))
    del found["identity"]
    words = {
        "reproduced": "As stated, {} are reproduced.",
        "reproduced with corrected equations": "{} need corrected equations",
        "reproduced under an added assumption": "{} an added assumption",
        "reproduced as printed only": "{} hold as printed only",
        "in part only": "{} in part",
        "not reproduced": "{} are not reproduced",
        "undeterminable": "{} cannot be determined",
    }
    assert sorted(words) == sorted(found)
    wanted = [words[verdict].format(count) for verdict, count in found.items()]
    wanted.append(f"judges {sum(found.values())} claims")
    with open(root / "figures/fig08.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    # Lengths and durations of the two sticks.
    rows = [row for row in rows if re.match(r"fig08.stick_(length|duration)", row["id"])]
    agree = collections.Counter(row["reading"] for row in rows if row["agrees"] == "true")
    total = collections.Counter(row["reading"] for row in rows)
    wanted.append(f"gives {agree['as-printed']} of {total['as-printed']} published numbers")
    wanted.append(f"give {agree['exact']} of {total['exact']}:")
    assert not [words for words in wanted if words not in text]
