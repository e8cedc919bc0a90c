"""What stands between this tree and a release, and the one edit that makes it one.

    python3 archive/release.py check                   what is left; `make release-check`
    python3 archive/release.py version 0.3.0 [DATE]    writes version and date wherever they stand

Exit codes of `check`: 0, ready; 1, something is wrong or left; 75, a tool is missing, so that not
all was checked. `version` changes files and commits nothing.
"""

import datetime
import json
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent
UNCHECKED = 75
# Heading of a version in the changelog, with its date or what stands for it.
HEADING = re.compile(r"^## (\d+\.\d+\.\d+) \((.+)\)$", re.M)
NOT_RELEASED = "not released"
# Where the version and the date are written, as patterns with the value between two groups.
VERSIONS = {
    "Cargo.toml": [
        r'(^\[workspace\.package\]\nversion = ")[^"]*(")',
        r'(^numerics = \{.*version = ")[^"]*(")',
    ],
    "CITATION.cff": [r"(^version: )\S+()$"],
    "codemeta.json": [r'(^  "version": ")[^"]*(")'],
}
DATES = {
    "CITATION.cff": [r"(^date-released: )\S+()$"],
    "codemeta.json": [r'(^  "datePublished": ")[^"]*(")'],
}
TOOLS = {
    "cargo-deny": "cargo install --locked cargo-deny",
    "cargo-semver-checks": "cargo install --locked cargo-semver-checks",
}


def text_of(file):
    return (HERE / file).read_text(encoding="utf-8")


def run(*command):
    return subprocess.run(command, cwd=HERE, text=True, capture_output=True, check=False)


def values(patterns):
    """File and value of each place that has one."""
    for file, places in patterns.items():
        for place in places:
            found = re.search(place, text_of(file), re.M)
            if found is None:
                sys.exit(f"{file}: no place matches {place}")
            yield file, text_of(file)[found.end(1) : found.start(2)]


def write(patterns, value):
    for file, places in patterns.items():
        text = text_of(file)
        for place in places:
            text = re.sub(place, rf"\g<1>{value}\g<2>", text, count=1, flags=re.M)
        (HERE / file).write_text(text, encoding="utf-8")


def set_version(version, date):
    if not re.fullmatch(r"\d+\.\d+\.\d+", version):
        sys.exit(f"{version} is no version; write three numbers, as in 0.3.0")
    datetime.date.fromisoformat(date)
    heading = HEADING.search(text_of("CHANGELOG.md"))
    if heading is None or heading[1] != version:
        sys.exit(f"CHANGELOG.md does not begin with `## {version} ({NOT_RELEASED})`")
    write(VERSIONS, version)
    write(DATES, date)
    dated = text_of("CHANGELOG.md").replace(heading[0], f"## {version} ({date})", 1)
    (HERE / "CHANGELOG.md").write_text(dated, encoding="utf-8")
    # The lock files name the crates of the workspace with their versions.
    for manifest in ["Cargo.toml", "fuzz/Cargo.toml"]:
        there = ["--offline", "--manifest-path", manifest]
        done = run("cargo", "update", "--workspace", *there)
        if done.returncode:
            sys.exit(done.stderr)
    print(f"{version}, {date}. Run `make report`, whose page cites the version, and commit.")


def steps_of_version():
    """What is left before version and date are those of a release."""
    heading = HEADING.search(text_of("CHANGELOG.md"))
    if heading is None:
        return ["CHANGELOG.md has no heading of the form `## 0.3.0 (2026-01-31)`"]
    version, date = heading.groups()
    left = []
    if date == NOT_RELEASED:
        left.append(
            f"version {version} has no date: `python3 archive/release.py version {version}` "
            "writes version and date, then `make report`"
        )
    else:
        wrong = [f"{file} has {at}" for file, at in values(VERSIONS) if at != version]
        left += [f"CHANGELOG.md has version {version}, but {one}" for one in wrong]
        wrong = [f"{file} has {at}" for file, at in values(DATES) if at != date]
        left += [f"CHANGELOG.md has the date {date}, but {one}" for one in wrong]
    own = {at for _, at in values(VERSIONS)}
    if len(own) != 1:
        left.append(f"versions are not in step: {sorted(values(VERSIONS))}")
    if len({at for _, at in values(DATES)}) != 1:
        left.append(f"dates are not in step: {sorted(values(DATES))}")
    locked = tomllib.loads(text_of("Cargo.lock"))["package"]
    members = [one for one in locked if "source" not in one]
    wrong = [f"{one['name']} {one['version']}" for one in members if one["version"] not in own]
    if wrong:
        left.append(f"Cargo.lock has {', '.join(wrong)}: `cargo update --workspace`")
    if run("git", "status", "--porcelain").stdout:
        left.append("there are changes that are not committed")
    return left


def absent_fields():
    """Fields of the packages' descriptions that have no true value, and stay out until they do."""
    crate = tomllib.loads(text_of("crates/stickslip/Cargo.toml"))["package"]
    wheel = tomllib.loads(text_of("pyproject.toml"))["project"]
    meta = json.loads(text_of("codemeta.json"))
    citation, paper = text_of("CITATION.cff"), text_of("joss/paper.md")
    wanted = {
        "crates/stickslip/Cargo.toml": (crate, ["repository", "homepage"]),
        "pyproject.toml": (wheel, ["urls"]),
        "codemeta.json": (meta, ["codeRepository", "issueTracker", "identifier"]),
    }
    for file, (there, fields) in wanted.items():
        yield from (f"{file}: {field}" for field in fields if field not in there)
    cited = citation.split("references:")[0]
    for field in ["doi", "repository-code", "url", "family-names", "orcid", "affiliation"]:
        if not re.search(rf"^\W*{field}:", cited, re.M):
            yield f"CITATION.cff: {field}"
    for field in ["orcid", "affiliations"]:
        if not re.search(rf"^\W*{field}:", paper, re.M):
            yield f"joss/paper.md: {field}"
    if "@" not in text_of("SECURITY.md"):
        yield "SECURITY.md: an address for reports in private"


def baseline(version):
    """The last commit that wrote another version than this one into Cargo.toml."""
    commits = run("git", "log", "--format=%H", "-G", '^version = "', "--", "Cargo.toml").stdout
    for commit in commits.split():
        there = tomllib.loads(run("git", "show", f"{commit}:Cargo.toml").stdout)
        before = there["workspace"]["package"]["version"]
        if before != version:
            return commit, before
    return None


def public_names(version):
    """Whether the crate's public names allow that version after the one before: (ok, words)."""
    found = baseline(version)
    if found is None:
        return True, "no version before this one is in the history"
    commit, before = found
    base = ["semver-checks", "--package", "stickslip", "--baseline-rev", commit]
    done = run("cargo", *base, "--release-type", "minor")
    words = done.stdout + done.stderr
    against = f"of {version} against {before} ({commit[:8]})"
    if done.returncode == 0:
        return True, f"public names {against}: nothing is removed or changed"
    broken = re.findall(r"^--- failure (\w+): ", words, re.M)
    if not broken:
        return False, f"public names {against} could not be compared:\n{words}"
    summary = f"public names {against}: {', '.join(broken)}"
    # Before 1.0 the second number says that names were removed or changed.
    if version.split(".")[:2] != before.split(".")[:2]:
        names = "\n  ".join(sorted(set(re.findall(r"^  (.+), previously in ", words, re.M))))
        return True, f"{summary}; a new minor version may. The changelog must name:\n  {names}"
    return False, f"{summary}; a patch version may not\n{words}"


def check():
    missing = [tool for tool in TOOLS if shutil.which(tool) is None]
    left = steps_of_version()
    if "cargo-deny" not in missing:
        parts = ["licenses", "bans", "sources"]
        done = run("cargo", "deny", "--locked", "--workspace", "check", *parts)
        # Duplicates are warnings; one line has the outcome of each part.
        words = done.stdout + done.stderr
        outcome = re.search(r"^bans .*$", words, re.M)
        print(f"cargo deny: {outcome[0] if outcome else 'no outcome'}")
        if done.returncode:
            left.append(f"what cargo deny names:\n{words}")
    if "cargo-semver-checks" not in missing:
        heading = HEADING.search(text_of("CHANGELOG.md"))
        ok, words = public_names(heading[1] if heading else "")
        print(f"cargo semver-checks: {words}")
        if not ok:
            left.append("the public names do not fit the version")
    print("fields without a true value, which stay out until there is one:")
    print("".join(f"  {field}\n" for field in absent_fields()), end="")
    for step in left:
        print(f"left: {step}")
    for tool in missing:
        print(f"not checked: {tool} is missing; install it by `{TOOLS[tool]}`")
    return 1 if left else UNCHECKED if missing else 0


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["check"]:
            sys.exit(check())
        case ["version", version]:
            set_version(version, datetime.date.today().isoformat())
        case ["version", version, date]:
            set_version(version, date)
        case _:
            sys.exit(__doc__)
