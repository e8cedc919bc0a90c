"""Results as tables: items, pandas, xarray, notebooks."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import stickslip as ss

sys.path.insert(0, str(Path(__file__).parent))
from test_results import RESULTS, belt_system


@pytest.mark.parametrize("name", RESULTS)
def test_fields_are_items(name):
    result = RESULTS[name]
    assert all(result[key] is getattr(result, key) for key in result.keys())
    assert list(dict(result)) == result.keys() and not any(key[0] == "_" for key in result)
    with pytest.raises(KeyError, match="there is no field 'other'"):
        result["other"]


@pytest.mark.parametrize("name", RESULTS)
def test_every_result_is_a_table_and_a_data_set(name):
    result = RESULTS[name]
    frame, data, text = result.to_pandas(), result.to_xarray(), result._repr_html_()
    assert isinstance(frame, pd.DataFrame) and len(frame) > 0
    assert len(data.data_vars) > 0 and text.startswith("<table>") and len(text) < 60_000


def test_an_orbit_has_its_states_by_name():
    sol = RESULTS["solution"]
    frame = sol.to_pandas()
    assert frame.index.name == "t" and list(frame) == ["x", "v"]
    assert np.array_equal(frame["v"], sol["y"][1]) and np.array_equal(frame.index, sol["t"])
    data = sol.to_xarray()
    assert np.array_equal(data.y.sel(state="v"), sol.y[1])


def test_pandas_reads_tables():
    sol = RESULTS["solution"]
    frame = pd.DataFrame(sol.transitions)
    assert np.array_equal(frame["y.x"], sol.transitions["y"][:, 0])
    assert frame["kind"].tolist() == sol.transitions["kind"].tolist()
    assert frame.equals(sol.transitions.to_pandas())
    assert list(pd.DataFrame(sol.phases))[:3] == ["t_start", "t_end", "mode"]
    assert sol.transitions[0]["y"].tolist() == sol.transitions["y"][0].tolist()
    with pytest.raises(KeyError, match="there is no column 'z'"):
        sol.transitions["z"]
    rows = sol.transitions[sol.transitions["kind"] == "stick exit"]
    assert isinstance(rows, ss.Table) and rows["y"].shape == (len(rows), 2)
    assert "<table>" in sol.transitions._repr_html_()


def test_tables_are_data_sets():
    sol = RESULTS["solution"]
    data = sol.transitions.to_xarray()
    assert data.kind.dims == ("row",) and data.y.dims == ("row", "state")
    assert np.array_equal(data.y.sel(state="v"), sol.transitions["y"][:, 1])
    phases = sol.phases.to_xarray()
    assert np.array_equal(phases.t_end, sol.phases["t_end"])
    sol = ss.solve_ivp(belt_system(), (0, 10), [0.5, 0], derivatives=["mu0", "x"])
    data = sol.transitions.to_xarray()
    assert data.dt.dims == ("row", "by") and data.dy.dims == ("row", "state", "by")
    assert np.array_equal(data.dy.sel(state="v", by="mu0"), sol.transitions["dy"][:, 1, 0])


def test_derivatives_are_columns():
    sol = ss.solve_ivp(belt_system(), (0, 10), [0.5, 0], derivatives=["mu0", "x"])
    assert sol.transitions["dt"].shape == (len(sol.transitions), 2)
    assert sol.transitions["dy"].shape == (len(sol.transitions), 2, 2)
    frame = sol.transitions.to_pandas()
    assert np.array_equal(frame["dy.v/mu0"], sol.transitions["dy"][:, 1, 0])
    assert np.array_equal(frame["dt/x"], sol.transitions["dt"][:, 1])
    assert np.array_equal(sol.to_pandas()["dv/dmu0"], sol.dy[1, :, 0])
    assert sol.to_xarray().dy.dims == ("state", "t", "by")


def test_reactions_of_stops_are_columns():
    h, w = ss.states("h w")
    floor = ss.Stop("floor", gap=h, acts={w: 1}, restitution=0.5)
    sol = ss.solve_ivp(ss.System({h: w, w: -10.0}, stops=[floor], start=[1, 0]), (0, 5))
    assert np.array_equal(sol.to_pandas()["floor.force"], sol.forces[0])
    assert np.array_equal(sol.to_xarray().forces.sel(contact="floor"), sol.forces[0])
    assert "floor.force" in sol._repr_html_()


def test_what_an_ensemble_kept_is_a_column():
    starts = [[0.5, 0], [0.1, 0]]
    one, two, words = (
        ss.ensemble(belt_system(), starts, (0, 5), reduce=reduce)
        for reduce in (lambda sol: sol.t[-1], lambda sol: sol.y[:, -1], lambda sol: "good")
    )
    assert one.to_pandas()["reduced"].tolist() == [5, 5]
    assert np.array_equal(two.to_pandas()[["reduced.0", "reduced.1"]], two.y_end.T)
    assert one.to_xarray().reduced.dims == ("orbit",)
    assert two.to_xarray().reduced.dims == ("orbit", "reduced_0")
    assert words.to_pandas()["reduced"].tolist() == ["good", "good"]
    assert "reduced.1" in two._repr_html_()


def test_a_system_without_transitions_has_an_empty_table():
    x = ss.state("x")
    sol = ss.solve_ivp(ss.System({x: -x}), (0, 1), [1.0])
    assert len(pd.DataFrame(sol.transitions)) == 0 and sol.transitions["y"].shape == (0, 1)


def test_a_diagram_has_rows_for_values_and_for_points():
    diagram = RESULTS["diagram"]
    assert diagram.to_pandas()["mu0"].tolist() == [0.38, 0.42]
    points = diagram.to_pandas(points=True)
    assert len(points) == sum(map(len, diagram.points)) and list(points) == ["mu0", "x", "v"]


def test_a_plane_and_a_grid_of_basins_have_their_axes():
    data = RESULTS["plane"].to_xarray()
    assert data.kind.dims == ("vp", "mu0") and data.vp.values.tolist() == [0.2, 0.3, 0.4]
    basins = RESULTS["basins"].to_xarray()
    assert basins.reached.dims == ("v", "x")
    assert basins.x.values.tolist() == [-1, 0, 1] and basins.v.values.tolist() == [-1, 1]
    assert RESULTS["row of basins"].to_xarray().reached.dims == ("start",)


def test_without_pandas_a_table_says_what_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(ImportError, match=r"stickslip\[pandas\]"):
        RESULTS["solution"].to_pandas()
    with pytest.raises(ImportError, match=r"stickslip\[xarray\]"):
        RESULTS["solution"].to_xarray()


def test_formulas_and_systems_are_shown_in_latex():
    x, v = ss.states("x v")
    mu0 = ss.parameter("mu0", 0.4)
    belt = ss.Contact("belt", boundary=v - 0.2, friction=mu0 / (1 + v**2))
    formula = -(x**2) * np.sin(v / mu0) - (x - v) / 2e-3
    shown = formula._repr_latex_()
    assert shown == (
        r"$-x^{2}\,\sin\left(\frac{v}{\mu_{0}}\right) - \frac{x - v}{0.002}$"
    )
    system = ss.System({x: v, v: -x - belt.friction}, contacts=[belt])._repr_latex_()
    assert r"\dot{v} &= -x - F_{\mathrm{belt}}" in system
    assert r"\operatorname{sgn}\left(v - 0.2\right)" in system
    assert r"F_{\mathrm{belt}} &= \mathrm{belt}\,\frac" in system


def test_products_before_a_bracket_have_a_sign():
    x, v = ss.states("x v")
    c = ss.parameter("c", 0.4)
    assert (c * (x - 1) * v)._repr_latex_() == r"$c \cdot \left(x - 1\right)\,v$"
    belt = ss.Contact("belt", boundary=v, friction=c + x)
    flat = ss.Contact("flat", boundary=v - 1, friction=0.4)
    system = ss.System({x: v, v: -belt.friction - flat.friction}, contacts=[belt, flat])
    shown = system._repr_latex_()
    assert r"\mathrm{belt} \cdot \left(c + x\right)" in shown
    assert r"\mathrm{flat} \cdot 0.4" in shown


def test_stops_and_jumps_are_shown_in_latex():
    h, w = ss.states("h w")
    floor = ss.Stop("floor", gap=h, acts={w: 2}, restitution=0.5)
    kick = ss.Jump(
        "kick",
        when=h - 3,
        set={w: np.where(w < 1, 0, -w)},
        direction="falling",
        condition=(w < 1) & ~(h >= w),
        count=3,
    )
    end = ss.Jump("end", when=h - 9, stop=True)
    roof = ss.Stop("roof", gap=5 - h, acts={w: -1}, restitution=0)
    shown = ss.System({h: w, w: -10.0}, stops=[floor, roof], jumps=[kick, end])._repr_latex_()
    for part in (
        r"\dot{w} &= -10 + \lambda_{\mathrm{floor}} \cdot 2 - \lambda_{\mathrm{roof}} \\",
        r"0 &\le g_{\mathrm{floor}} \perp \lambda_{\mathrm{floor}} \ge 0",
        r"g_{\mathrm{floor}} = 0 &: \dot{g_{\mathrm{floor}}} \to -0.5\,\dot{g_{\mathrm{floor}}}",
        r"h - 3 = 0\ \text{(falling)}\ \text{if}\ w < 1 \land \lnot \left(h \ge w\right) &: ",
        r"w \to \begin{cases} 0 & \text{if } w < 1 \\ -w & \text{otherwise} \end{cases}",
        r",\ \text{end after 3}",
        r"\dot{g_{\mathrm{roof}}} \to 0",
        r"h - 9 = 0 &: \text{end}",
    ):
        assert part in shown, part
