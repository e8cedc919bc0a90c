"""What the program writes is in the results, too: tables, reasons, forces, axes of data sets."""

import csv
import inspect
import os
import subprocess

import matplotlib
import matplotlib.pyplot
import numpy as np
import pytest
import stickslip as ss

matplotlib.use("Agg")

PROGRAM = os.environ.get("STICKSLIP", "stickslip")
x, v = ss.states("x v")


def block():
    mu0, vp = ss.parameters(mu0=0.4, vp=0.2)
    belt = ss.Contact("belt", v - vp, lambda side: mu0 / (1 + 3 * side * (v - vp)))
    return ss.System({x: v, v: -x - 0.05 * v - belt.friction}, contacts=[belt], start=[0.5, 0])


def wells():
    p, q = ss.parameters(p=0.0, q=0.0)
    return ss.System({x: v, v: p + x - x**3 - 0.3 * v + q * v**3}, start=[0.5, 0])


def rows_of(folder, system, name, *options):
    """The tables that a command of the program writes: for each its header and its rows."""
    (folder / "system.toml").write_text(system.to_toml(), encoding="utf-8")
    run = [PROGRAM, name, "system.toml", "--out", "out", *options]
    done = subprocess.run(run, cwd=folder, capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    found = {}
    for path in sorted((folder / "out").glob("*.csv")):
        with open(path, encoding="utf-8") as file:
            header, *rows = csv.reader(file)
        found[path.stem] = (header, [dict(zip(header, row)) for row in rows])
    return found


def columns(result):
    """The columns of a result or of one of its tables."""
    return set(result.dtype.names if isinstance(result, ss.Table) else result._columns())


#: Columns whose names differ: a kind of motion is `motion` in files, and so on.
RENAMED = {
    "motion": "kind",
    "what": "name",
    "lambda1": "exponent",
    "from": "from_value",
    "to": "to_value",
    "from_belt": "from_mode",
    "to_belt": "to_mode",
    "belt": "mode",
    "x_length": "length.x",
    "v_length": "length.v",
    "x_low": "x.min",
    "v_low": "v.min",
    "x_high": "x.max",
    "v_high": "v.max",
    "multiplier1_re": "multiplier1",
    "multiplier1_im": "multiplier1",
    "multiplier1_uncertainty": "multiplier_uncertainty1",
    "eigenvalue1_re": "eigenvalue1",
    "eigenvalue1_im": "eigenvalue1",
    "eigenvalue2_re": "eigenvalue2",
    "eigenvalue2_im": "eigenvalue2",
    "x_start": "y_start.x",
    "v_start": "y_start.v",
    "x_end": "y_end.x",
    "v_end": "y_end.v",
}
#: Columns that Python has elsewhere, and where.
ELSEWHERE = {
    "way": "upwards and downwards are two calls",
    "phase": "the number of the row",
    "duration of phases": "t_end - t_start",
    "branch": "branches are results of their own",
    "branches": "branches are results of their own",
    "curve": "curves are results of their own",
    "of": "BifurcationCurve.what",
    "what of curves": "BifurcationCurve.what",
    "attractor": "the number of the row, and Basins.reached",
    "orbit": "the number of the row",
    "ending": "status and message",
    "error": "message",
    "doubtful": "a warning",
    "direction": "the directions are columns of each state",
    "beyond of pushes": "the number of the attractor; beyond is its kind",
    "largest": "the argument",
}


def missing(header, result, renamed=(), without=()):
    """Columns of a table of the program that a result does not have."""
    assert not [one for one in without if one not in ELSEWHERE]
    left_out = {one.partition(" of ")[0] for one in without}
    names = {**RENAMED, **dict(renamed)}
    own = columns(result)
    if isinstance(result, ss.Table):
        names = {**{"x": "y.x", "v": "y.v"}, **names}
    wanted = [one for one in header if one not in left_out]
    # Columns that are named as elsewhere must be in the table of the program.
    assert left_out <= set(header), left_out - set(header)
    return [one for one in wanted if names.get(one, one) not in own and one not in own]


def test_an_orbit_has_the_columns_of_the_program(tmp_path):
    found = rows_of(tmp_path, block(), "simulate", "--t-end", "20")
    sol = ss.solve_ivp(block(), (0, 20))
    assert missing(found["steps"][0], sol) == []
    assert missing(found["transitions"][0], sol.transitions) == []
    without = ["phase", "duration of phases"]
    assert missing(found["phases"][0], sol.phases, without=without) == []
    (tmp_path / "starts.csv").write_text("x,vp\n0.1,0.2\n0.3,0.3\n", encoding="utf-8")
    found = rows_of(tmp_path, block(), "simulate", "--t-end", "20", "--starts", "starts.csv")
    many = ss.ensemble(block(), [[0.1, 0], [0.3, 0]], (0, 20), parameters={"vp": [0.2, 0.3]})
    renamed = {"t_end": "t.end"}
    renamed |= {"x_start": "x", "v_start": "v", "x_end": "x.end", "v_end": "v.end"}
    without = ["orbit", "ending", "error", "doubtful"]
    assert missing(found["orbits"][0], many, renamed, without) == []
    assert missing(found["transitions"][0], many.transitions) == []


def test_a_periodic_orbit_has_the_columns_of_the_program(tmp_path):
    found = rows_of(tmp_path, block(), "orbit")
    orbit = ss.periodic_orbit(block())
    assert [one for one in found["orbit"][0] if one not in (*orbit.keys(), "x", "v")] == []
    assert len(found["multipliers"][1]) == len(orbit.multipliers)
    own = [float(row["uncertainty"]) for row in found["multipliers"][1]]
    assert own == orbit.multiplier_uncertainties.tolist()
    sol = orbit.solution()
    without = ["phase", "duration of phases"]
    assert missing(found["phases"][0], sol.phases, without=without) == []
    assert missing(found["transitions"][0], sol.transitions) == []


def test_a_branch_has_the_columns_of_the_program(tmp_path):
    options = ["--parameter", "vp=0.4:0.8", "--also", "mu0=0.39:0.41", "--branches"]
    options += ["--set", "vp=0.5"]
    system = block().with_parameters(vp=0.5)
    found = rows_of(tmp_path, system, "continue", *options)
    also = ("mu0", (0.39, 0.41))
    branch = ss.continuation(system, "vp", (0.4, 0.8), also=also, branches=True)
    assert missing(found["branch"][0], branch, without=["branch"]) == []
    renamed = {"vp": "parameter"}
    without = ["branch", "branches"]
    assert missing(found["special"][0], branch.special, renamed, without) == []
    contacts = [row["contacts"] for row in found["special"][1]]
    assert contacts == branch.special["contacts"].tolist() == ["belt"]
    assert np.isnan(branch.special["angle"]).all()
    assert branch.curves and all(isinstance(one, ss.BifurcationCurve) for one in branch.curves)
    renamed = {"uncertainty_vp": "uncertainty"}
    without = ["curve", "what of curves"]
    assert missing(found["curves"][0], branch.curves[0], renamed, without) == []
    renamed |= {"mu0": "other", "vp": "parameter", "uncertainty_mu0": "other_uncertainty"}
    special = branch.curves[0].special
    # The time of the state is `t` in both.
    assert missing(found["curves-special"][0], special, renamed, ["curve", "of"]) == []


def test_a_branch_of_equilibria_has_the_columns_of_the_program(tmp_path):
    options = ["--equilibrium", "--parameter", "p=-1:1", "--also", "q=-1:1"]
    found = rows_of(tmp_path, wells(), "continue", *options)
    branch = ss.equilibrium_continuation(wells(), "p", (-1, 1), also=("q", (-1, 1)))
    assert missing(found["equilibria"][0], branch) == []
    assert missing(found["equilibria-special"][0], branch.special, {"p": "parameter"}) == []
    without = ["curve", "what of curves"]
    assert missing(found["curves"][0], branch.curves[0], without=without) == []
    renamed = {"q": "other", "p": "parameter"}
    renamed |= {"uncertainty_q": "other_uncertainty", "uncertainty_p": "uncertainty"}
    special = branch.curves[0].special
    assert missing(found["curves-special"][0], special, renamed, ["curve", "of"]) == []


def test_a_diagram_has_the_tables_of_the_program(tmp_path):
    options = ["--parameter", "mu0=0.3:0.4", "--values", "3", "--until", "300", "--duration", "20"]
    options += ["--shares", "4", "--over", "x=-1:1"]
    found = rows_of(tmp_path, block(), "bifurcation", *options)
    up = [row for row in found["bifurcation"][1] if row["way"] == "up"]
    values = list(dict.fromkeys(float(row["mu0"]) for row in up))
    diagram = ss.bifurcation_diagram(block(), "mu0", values, longest=300, duration=20)
    of_points = ["x", "v"]
    header = [one for one in found["bifurcation"][0] if one not in of_points]
    assert missing(header, diagram, without=["way"]) == []
    assert set(of_points) <= set(diagram.to_pandas(points=True))
    assert missing(found["changes"][0], diagram.changes, {"mu0": "parameter"}, ["way"]) == []
    assert missing(found["sticks"][0], diagram.sticks, {"mu0": "parameter"}, ["way"]) == []
    sticks = [row for row in found["sticks"][1] if row["way"] == "up"]
    assert len(sticks) == len(diagram.sticks) >= len(values)
    for name, of in (("mu0", "parameter"), ("duration", "duration"), ("x_length", "length.x")):
        assert [float(row[name]) for row in sticks] == diagram.sticks[of].tolist()
    # A stick goes with the belt, and fills its part of the period.
    moved = diagram.sticks["length"][:, 0]
    assert np.allclose(moved, 0.2 * diagram.sticks["duration"], rtol=0, atol=1e-9)
    at = [diagram.sticks["duration"][diagram.sticks["parameter"] == one].sum() for one in values]
    assert np.allclose(at, diagram.in_stick * diagram.period, rtol=0, atol=1e-6)
    starts = [[-0.9, 0.0], [-0.3, 0.0], [0.3, 0.0], [0.9, 0.0]]
    shares = ss.basin_shares(block(), "mu0", values, starts, longest=300)
    assert missing(found["shares"][0], shares) == []
    assert [row["phases"] for row in found["shares"][1]] == shares.row_phases


def test_a_map_has_the_columns_of_the_program(tmp_path):
    options = ["--x", "mu0=0.3:0.4", "--y", "vp=0.2:0.3", "--grid", "2x2", "--until", "200"]
    found = rows_of(tmp_path, block(), "map", *options, "--duration", "20")
    plane = ss.parameter_map(
        block(), ("mu0", [0.3, 0.4]), ("vp", [0.2, 0.3]), longest=200, duration=20
    )
    assert missing(found["map"][0], plane) == []


def test_basins_have_the_columns_of_the_program(tmp_path):
    options = ["--x", "x=-2:2", "--y", "v=-1:1", "--grid", "64x64", "--until", "200"]
    options += ["--return-within", "0.01", "--push", "v", "--edges", "--dimension"]
    found = rows_of(tmp_path, wells(), "basin", *options, "--tol", "1e-8")
    middles = (np.arange(6) + 0.5) / 6
    grid = np.stack(np.meshgrid(-2 + 4 * middles, -1 + 2 * middles), axis=-1)
    basins = ss.basins_of_attraction(wells(), grid, longest=200, return_within=0.01)
    assert missing(found["basin"][0], basins, without=["attractor"]) == []
    assert missing(found["attractors"][0], basins.attractors, without=["attractor"]) == []
    pushes = ss.least_push(wells(), [1, 0], [[0, 1]], largest=3)
    renamed = {"push": "size", "beyond_motion": "beyond", "x": "x_beyond", "v": "v_beyond"}
    without = ["attractor", "direction", "beyond of pushes", "largest"]
    assert missing(found["pushes"][0], pushes, renamed, without) == []
    edge = ss.edge_state(wells(), [-1, 0], [1, 0])
    own = {"motion", "period", "unstable", "bisections"}
    assert own < set(found["edges"][0]) and own - {"motion"} < set(edge.keys())
    track = [one for one in found["tracks"][0] if one not in ("attractor", "towards")]
    assert missing(track, edge) == []
    assert set(found["uncertain"][0]) <= {"steps", "uncertain"}


def test_tangent_points_and_exponents_have_the_columns_of_the_program(tmp_path):
    found = rows_of(tmp_path, block(), "tangents", "--from", "-1", "--to", "1")
    there = ss.tangents(block(), bounds=(-1, 1))
    header = [one for one in found["tangents"][0] if one != "t"]
    assert missing(header, there.points) == []
    assert missing(found["zones"][0], there.zones, {"x_from": "low", "x_to": "high"}) == []
    options = ["--transient", "20", "--duration", "50"]
    found = rows_of(tmp_path, block(), "lyapunov", *options)
    spectrum = ss.lyapunov_spectrum(block(), transient=20, duration=50)
    header = [one for one in found["exponents"][0] if one != "number"]
    assert missing(header, spectrum) == []


def test_a_fit_has_the_columns_of_the_program(tmp_path):
    t = np.linspace(0.25, 10, 40)
    system = block()
    sol = ss.solve_ivp(system.with_parameters(mu0=0.45), (0, 10), t_eval=t)
    data = np.c_[t, sol.y[0] + 0.001 * np.sin(100 * t)]
    np.savetxt(tmp_path / "data.csv", data, delimiter=",", header="t,x", comments="", fmt="%.17g")
    options = ["data.csv", "--fit", "mu0", "--observe", "x", "--bounds", "mu0=0.1:0.9"]
    found = rows_of(tmp_path, system, "fit", *options)
    fit = ss.fit(system, {"t": t, "x": data[:, 1]}, "mu0", {"x": x}, bounds={"mu0": (0.1, 0.9)})
    assert missing(found["parameters"][0], fit) == []
    (row,) = found["parameters"][1]
    assert [float(row["lower_bound"]), float(row["upper_bound"])] == fit.bounds[0].tolist()


def test_each_value_cell_attractor_and_row_has_its_reason():
    a, b = ss.parameters(a=0.5, b=1.0)
    # The logarithm has no value at the start where a is large.
    system = ss.System({x: -b * np.log(x - a)}, start=[1])
    match = "cannot start at t = 0"
    with pytest.warns(ss.SolverWarning, match="2 of 5 runs failed"):
        diagram = ss.bifurcation_diagram(system, a, [0.2, 0.5, 3.0, 3.5, 0.4])
    assert [match in reason for reason in diagram.reason] == [False, False, True, True, False]
    assert diagram.reason[0] == "" and diagram.to_pandas()["reason"].tolist() == diagram.reason
    with pytest.warns(ss.SolverWarning, match="2 of 6 runs failed"):
        plane = ss.parameter_map(system, (a, [0.2, 3.0, 0.5]), (b, [1, 2]), duration=None)
    assert [[match in one for one in row] for row in plane.reason] == [[False, True, False]] * 2
    assert plane.to_xarray().reason.dims == ("b", "a")
    with pytest.warns(ss.SolverWarning, match="1 of 3 runs failed"):
        basins = ss.basins_of_attraction(system, [[1.0], [-2.0], [2.0]])
    assert [match in one for one in basins.reason] == [k == "failure" for k in basins.kind]
    table = basins.attractors
    assert table["reason"].tolist() == basins.reason and table["starts"].tolist() == [2, 1]
    assert table["y.x"][0] == pytest.approx(1.5) and np.isnan(table["y.x"][1])
    with pytest.warns(ss.SolverWarning, match="runs failed"):
        shares = ss.basin_shares(system, a, [0.2, 0.5], [[1.0], [-2.0]])
    assert [match in one for one in shares.reason] == [one == "failure" for one in shares.kinds]
    assert "failure" in shares.kinds and shares.to_pandas()["reason"].tolist() == shares.reason


def test_an_orbit_of_an_ensemble_has_the_forces_of_a_single_run():
    h, w = ss.states("h w")
    floor = ss.Stop("floor", gap=h, acts={w: 1}, restitution=0.5)
    ball = ss.System({h: w, w: -10.0}, stops=[floor], start=[1, 0])
    for system, starts in ((block(), [[0.5, 0], [-0.3, 0.1]]), (ball, [[1.0, 0], [2.0, 1.0]])):
        kept = []
        ss.ensemble(system, starts, (0, 9), np.linspace(0, 9, 31), reduce=kept.append)
        for start, one in zip(starts, kept):
            alone = ss.solve_ivp(system, (0, 9), start, t_eval=np.linspace(0, 9, 31))
            assert one.forces.tobytes() == alone.forces.tobytes()
            assert list(one.to_pandas()) == list(alone.to_pandas())
    kept = []
    ss.ensemble(ss.System({x: v, v: -x}), [[1.0, 0.0]], (0, 1), reduce=kept.append)
    assert kept[0].forces is None


def test_forces_of_an_ensemble_are_those_of_its_parameters():
    kept = []
    values = [0.3, 0.4, 0.3]
    ss.ensemble(block(), [0.5, 0.0], (0, 9), parameters={"mu0": values}, reduce=kept.append)
    for value, one in zip(values, kept):
        alone = ss.solve_ivp(block().with_parameters(mu0=value), (0, 9), [0.5, 0.0])
        assert one.forces.tobytes() == alone.forces.tobytes()


def test_data_sets_drop_nothing():
    middles = np.linspace(-0.9, 0.9, 4)
    grid = np.stack(np.meshgrid(middles, middles), axis=-1)
    basins = ss.basins_of_attraction(wells(), grid, longest=200, return_within=0.01)
    data = basins.to_xarray()
    assert data.return_time.dims == data.reached.dims == ("v", "x")
    assert np.array_equal(data.return_time, basins.return_time)
    assert data.y.dims == ("attractor", "state")
    row = ss.basins_of_attraction(wells(), grid[0], longest=200, return_within=0.01)
    assert row.to_xarray().return_time.dims == ("start",)
    plain = ss.basins_of_attraction(wells(), grid[0], longest=200)
    assert "return_time" not in plain.to_xarray()
    orbit = ss.periodic_orbit(block())
    data = orbit.to_xarray()
    assert data.attrs["period"] == orbit.period and data.attrs["stability"] == "stable"
    assert np.array_equal(data.attrs["multipliers"], orbit.multipliers)
    branch = ss.continuation(block(), "mu0", (0.38, 0.42), also=("vp", (0.19, 0.21)))
    assert np.array_equal(branch.to_xarray().t, branch.t)
    edge = ss.edge_state(wells(), [-1, 0], [1, 0])
    assert edge.to_xarray().attrs["kind"] == edge.kind


def test_a_branch_draws_a_state_by_its_symbol():
    branch = ss.continuation(block(), "mu0", (0.38, 0.42))
    for which in (v, "v", 1):
        axes = branch.plot(what=which)
        assert axes.get_ylabel() == "v"
        assert np.nanmax(axes.lines[0].get_ydata()) == branch.y_max[:, 1].max()
        matplotlib.pyplot.close(axes.figure)
    assert branch.plot(what="period").get_ylabel() == "period"


def test_every_result_has_a_figure():
    results = [one for one in vars(ss).values() if hasattr(one, "_columns")]
    assert len(results) > 18
    for one in results:
        assert inspect.signature(one.plot).parameters["axes"].default is None, one


def test_the_figure_of_an_entropy_has_both_and_the_bound():
    entropy = ss.BasinEntropy(0.2, 0.01, 0.5, 0.02, 64, 20, False)
    axes = entropy.plot()
    heights = [bar.get_height() for bar in axes.patches]
    assert heights == [0.2, 0.5]
    assert [np.log(2)] * 2 in [list(line.get_ydata()) for line in axes.lines]
    matplotlib.pyplot.close(axes.figure)


def test_an_ensemble_draws_a_state_by_its_name():
    found = ss.ensemble(block(), [[0.5, 0], [0.1, 0]], (0, 5), np.linspace(0, 5, 11))
    for which in ("v", v, 1, -1):
        axes = found.plot(state=which)
        assert axes.get_ylabel() == "v"
        assert np.array_equal(axes.lines[1].get_ydata(), found.y[1, 1])
        matplotlib.pyplot.close(axes.figure)
    with pytest.raises(ValueError, match="there is no state 'z': they are x, v"):
        found.plot(state="z")
