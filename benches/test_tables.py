"""Times at equal error, and pages that say what the committed tables hold."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import tables


def test_pages_say_what_the_tables_hold():
    for path, text in tables.pages().items():
        assert text == (tables.ROOT / path).read_text(encoding="utf-8"), "run `make bench-pages`"


def test_other_measurements_make_other_pages():
    rows = tables.read("bench.csv")
    slower = [row | {"median_s": "1.0"} if row["solver"] == "heyoka" else row for row in rows]
    assert tables.of_heyoka(slower) != tables.of_heyoka(rows)
    assert tables.of_peers(slower) != tables.of_peers(rows)


def test_a_page_without_its_marks_is_refused():
    with pytest.raises(ValueError, match="begin|marks"):
        tables.replaced("no marks", "speed", "x")


def test_the_front_leaves_out_what_is_bettered():
    points = [(4.0, 1e-8), (1.0, 1e-4), (3.0, 1e-3), (5.0, 0.0)]
    assert tables.front(points) == [(1.0, 1e-4), (4.0, 1e-8), (5.0, tables.LEAST_ERROR)]


def test_times_are_interpolated_by_their_logarithms():
    front = [(1.0, 1e-4), (4.0, 1e-8)]
    assert tables.time_for(front, 1e-6) == pytest.approx(2.0, rel=1e-12)
    assert tables.time_for(front, 1e-2) == 1.0
    assert tables.time_for(front, 1e-8) == 4.0
    assert tables.time_for(front, 1e-9) is None


def test_peers_are_compared_where_both_can_be():
    def row(solver, time, error):
        return {"problem": "decay", "solver": solver, "median_s": time, "error": error}

    rows = [
        row("stickslip Taylor", "1.0", "1e-6"),
        row("stickslip Taylor", "2.0", "1e-12"),
        row("exact", "30.0", "1e-14"),
        row("rough", "10.0", "1e-6"),
        row("lost", "10.0", ""),
    ]
    found = [(peer, error, theirs / ours) for _, peer, error, theirs, ours in tables.ratios(rows)]
    assert found == [("exact", 1e-12, 15.0), ("rough", 1e-6, 10.0)]


def test_times_have_three_digits_and_a_unit():
    found = [tables.duration(seconds) for seconds in (1.234e-5, 4.5e-3, 0.1234, 2.0)]
    assert found == ["12.3 µs", "4.50 ms", "123 ms", "2.00 s"]
