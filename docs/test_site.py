"""The reference names every error, key, function and name that there is, and every block is run."""

import re
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
    listed = set(re.findall(r"^   (\w+)$|`ss\.(t|pi)`", page("python.md"), re.M))
    listed = {one or other for one, other in listed}
    assert listed == {name for name in stickslip.__all__ if not name.startswith("_")}


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


def test_the_readme_runs_as_it_stands():
    text = (HERE.parent / "README.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", text, re.S)
    names = {}
    exec(compile(block, "README.md", "exec"), names)
    first = names["sol"].phases[names["sol"].phases["mode"] == "S"][0]
    assert abs(first["t_start"] - 0.2446888017832978) < 1e-11
