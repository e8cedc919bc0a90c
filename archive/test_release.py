"""What is left before a release is found, and one edit does it."""

import json
import re
import shutil
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import release


@pytest.fixture
def tree(tmp_path, monkeypatch):
    """A copy of the files that say the version, with a changelog that has no date yet."""
    for file in {*release.VERSIONS, *release.DATES, "CHANGELOG.md", "Cargo.lock"}:
        shutil.copy(release.HERE / file, tmp_path / file)
    changes = (tmp_path / "CHANGELOG.md").read_text(encoding="utf-8")
    rest = release.HEADING.sub("## 98.0.0 (2020-01-31)", changes, count=1)
    changed = f"# Changelog\n\n## 99.1.0 ({release.NOT_RELEASED})\n\n{rest}"
    (tmp_path / "CHANGELOG.md").write_text(changed, encoding="utf-8")
    monkeypatch.setattr(release, "HERE", tmp_path)

    class Done:
        returncode, stdout, stderr = 0, "", ""

    def no_process(*command):
        if command[:2] == ("cargo", "update"):
            lock = tmp_path / "Cargo.lock"
            text = lock.read_text(encoding="utf-8")
            own = r'(name = "[\w-]+"\nversion = ")[^"]*("\n(?!source))'
            lock.write_text(re.sub(own, r"\g<1>99.1.0\g<2>", text), encoding="utf-8")
        return Done

    monkeypatch.setattr(release, "run", no_process)
    return tmp_path


def test_one_edit_leaves_nothing(tree):
    (left,) = release.steps_of_version()
    assert "99.1.0 has no date" in left
    release.set_version("99.1.0", "2030-02-01")
    assert release.steps_of_version() == []
    meta = json.loads((tree / "codemeta.json").read_text(encoding="utf-8"))
    assert (meta["version"], meta["datePublished"]) == ("99.1.0", "2030-02-01")
    assert "## 99.1.0 (2030-02-01)" in (tree / "CHANGELOG.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("file", sorted({*release.VERSIONS, *release.DATES, "Cargo.lock"}))
def test_a_file_that_stayed_behind_is_named(tree, file):
    behind = (tree / file).read_text(encoding="utf-8")
    release.set_version("99.1.0", "2030-02-01")
    (tree / file).write_text(behind, encoding="utf-8")
    assert any(file in left for left in release.steps_of_version())


def test_a_version_that_the_changelog_does_not_begin_with_is_refused(tree):
    with pytest.raises(SystemExit, match="CHANGELOG"):
        release.set_version("99.2.0", "2030-02-01")
    with pytest.raises(SystemExit, match="no version"):
        release.set_version("99.1", "2030-02-01")


def test_the_tree_as_it_is_has_its_versions_in_step():
    left = [step for step in release.steps_of_version() if "not committed" not in step]
    assert len(left) <= 1 and all("has no date" in step for step in left)
