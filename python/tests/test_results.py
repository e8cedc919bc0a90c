"""Results: copies, short texts, figures."""

import copy
import pickle

import matplotlib
import matplotlib.pyplot
import numpy as np
import pytest
import stickslip as ss


matplotlib.use("Agg")


def belt_system():
    x, v = ss.states("x v")
    mu0, vp = ss.parameters(mu0=0.4, vp=0.2)
    belt = ss.Contact("belt", boundary=v - vp)
    rate = -x - belt.side * mu0 / (1 + belt.side * (v - vp))
    return ss.System({x: v, v: rate}, contacts=[belt])


def damped():
    x, v = ss.states("x v")
    return ss.System({x: v, v: ss.parameter("p", 1.0) - v - x - x**3}, start=[0, 0])


def of_basins():
    x, y = ss.states("x y")
    u = x - y**2 / 3
    wells = ss.System({x: u - u**3 - 2 / 3 * y**2, y: -y})
    line = np.linspace(-1.99, 1.99, 64)
    grid = np.stack(np.meshgrid(line, line), axis=-1)
    boundary = ss.basins_of_attraction(wells, grid, longest=200, rtol=1e-8)
    p = ss.parameter("p", 0.0)
    fold = ss.System({x: p + x - x**3})
    return {
        "boundary": boundary.uncertainty_exponent(),
        "entropy": boundary.entropy(8),
        "pushes": ss.least_push(wells, [1, 0], [[-1, 0], [0, 1]], largest=3),
        "edge": ss.edge_state(wells, [-1, 1], [2, 1]),
        "shares": ss.basin_shares(fold, p, [-0.5, 0, 0.5], [[-1.0], [0.1], [1.0]]),
    }


def results():
    system, start = belt_system(), [0.5, 0]
    v = ss.state("v")
    grid = np.stack(np.meshgrid(np.linspace(-1, 1, 3), np.linspace(-1, 1, 2)), axis=-1)
    return {
        "solution": ss.solve_ivp(system, (0, 30), start, dense_output=True, events=v),
        "map": ss.poincare_map(system, ss.event(v, -1), start, returns=5),
        "orbit": ss.periodic_orbit(system, start),
        "branch": ss.continuation(system, "mu0", (0.38, 0.42), start),
        "equilibria": ss.equilibrium_continuation(damped(), "p", (-2, 2)),
        "spectrum": ss.lyapunov_spectrum(system, start, transient=20, duration=50),
        "diagram": ss.bifurcation_diagram(system, "mu0", [0.38, 0.42], start, longest=200),
        "basins": ss.basins_of_attraction(system, grid, longest=200),
        "row of basins": ss.basins_of_attraction(system, grid[0], longest=200),
        "plane": ss.parameter_map(
            system, ("mu0", [0.3, 0.4]), ("vp", [0.2, 0.3, 0.4]), start, longest=200, duration=20
        ),
        **of_basins(),
        "data": ss.lyapunov_from_data(np.sin(0.1 * np.arange(3000.0)) ** 3, dt=0.1),
    }


RESULTS = results()


def same(one, other):
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.tobytes() == other.tobytes()
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    return one is other or one == other or repr(one) == repr(other)


@pytest.mark.parametrize("name", RESULTS)
@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))]
)
def test_results_are_copied(name, copied):
    result = RESULTS[name]
    again = copied(result)
    assert type(again) is type(result)
    # Tables of a solution are made when they are asked for.
    for field in [*vars(result), *result.keys()]:
        assert same(getattr(result, field), getattr(again, field)), field


def test_a_solution_from_a_pickle_has_the_same_bits():
    x = ss.state("x")
    times = np.linspace(0, 12, 101)
    stop = ss.event(x - 0.1, direction=-1, terminal=3)
    for sol in (
        ss.solve_ivp(belt_system(), (0, 12), [0.5, 0], dense_output=True, rtol=1e-8),
        ss.solve_ivp(belt_system(), (0, 1e6), [0.5, 0], events=stop, dense_output=True),
    ):
        again = pickle.loads(pickle.dumps(sol)).sol
        asked = times[times <= sol.sol.t_max]
        assert np.array_equal(again(asked), sol.sol(asked)) and len(asked) > 50
        assert np.array_equal(again(sol.sol.t_max), sol.sol(sol.sol.t_max))
        with pytest.raises(ValueError, match="within the run"):
            again(sol.sol.t_max + 1)


@pytest.mark.parametrize("name", RESULTS)
def test_texts_are_short_and_figures_show_something(name, tmp_path):
    result = RESULTS[name]
    assert len(repr(result)) < 500 and type(result).__name__ in repr(result)
    axes = result.plot()
    assert axes.get_xlabel() and axes.get_ylabel() + axes.get_xlabel()
    assert axes.lines or axes.collections or axes.patches
    assert result.plot(axes) is axes
    axes.figure.savefig(tmp_path / "figure.png")
    assert (tmp_path / "figure.png").stat().st_size > 2000
    matplotlib.pyplot.close(axes.figure)


@pytest.mark.parametrize("what", ["exponent", "in_stick", "period"])
def test_a_map_shows_numbers(what):
    axes = RESULTS["plane"].plot(what=what)
    drawn = axes.collections[0].get_array().reshape(3, 2)
    assert np.ma.allequal(drawn, np.ma.masked_invalid(getattr(RESULTS["plane"], what)))
    with pytest.raises(ValueError, match="what = 'other'"):
        RESULTS["plane"].plot(what="other")


def test_an_orbit_closes_and_its_stick_is_drawn():
    orbit = RESULTS["orbit"]
    sol = orbit.solution()
    assert np.allclose(sol.y[:, 0], sol.y[:, -1], atol=1e-9)
    assert [line.get_label() for line in orbit.plot().lines][1] == "stick"


def test_without_matplotlib_a_figure_says_what_is_missing(monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    with pytest.raises(ImportError, match=r"stickslip\[plot\]"):
        RESULTS["solution"].plot()


def plane(kinds):
    """A map whose cells are of so many kinds of motion, one undecided."""
    numbers = np.arange(kinds).reshape(1, kinds)
    words = np.array([*["periodic"] * (kinds - 1), "undecided"])[numbers]
    phases = np.array([*["+ " * k for k in range(1, kinds)], ""])[numbers]
    nan = np.full((1, kinds), np.nan)
    along = np.arange(float(kinds)), np.array([0.0])
    return ss.ParameterMap(*along, words, nan, numbers, phases, *[nan] * 4, np.full(phases.shape, ""), ("a", "b"))


def legend_of(axes):
    legend = axes.get_legend()
    texts = [text.get_text() for text in legend.get_texts()]
    return texts, [patch.get_facecolor() for patch in legend.get_patches()]


@pytest.mark.parametrize("result", ["basins", "row of basins", "plane", 8, 30])
def test_the_legend_is_within_the_figure_and_its_colours_differ(result):
    drawn = plane(result) if isinstance(result, int) else RESULTS[result]
    axes = drawn.plot()
    figure = axes.figure
    figure.canvas.draw()
    inside = figure.bbox
    extent = axes.get_legend().get_window_extent()
    assert inside.x0 <= extent.x0 and extent.x1 <= inside.x1
    assert inside.y0 <= extent.y0 and extent.y1 <= axes.xaxis.get_tightbbox().y0
    # Most of the figure is that of the data.
    assert axes.get_window_extent().height > 0.4 * inside.height
    texts, colours = legend_of(axes)
    assert len(set(colours)) == len(colours) and len(texts) <= 13
    assert ("on the attractors" in texts) == isinstance(drawn, ss.Basins)
    matplotlib.pyplot.close(figure)


def test_a_figure_of_the_user_keeps_its_layout():
    for layout in (None, "tight"):
        figure, own = matplotlib.pyplot.subplots(layout=layout)
        before = figure.get_layout_engine()
        axes = plane(8).plot(own)
        assert axes is own and figure.get_layout_engine() is before
        matplotlib.pyplot.close(figure)


def test_no_two_of_many_kinds_have_one_colour_and_undecided_is_grey():
    axes = plane(30).plot()
    texts, _ = legend_of(axes)
    assert texts[-1] == "and 19 more"
    cells = axes.collections[0]
    colours = {tuple(cells.to_rgba(number)) for number in range(30)}
    greys = [one for one in colours if one[0] == one[1] == one[2]]
    assert len(colours) == 30 and len(greys) == 1
    matplotlib.pyplot.close(axes.figure)


def test_an_orbit_has_its_phases_and_its_part_in_stick():
    orbit = RESULTS["orbit"]
    # The same attractor at the same parameter, by recurrence.
    found = ss.bifurcation_diagram(belt_system(), "mu0", [0.4], [0.5, 0], longest=200)
    assert orbit.phases == found.phases[0] and "S" in orbit.phases
    sol = orbit.solution()
    sticks = sol.phases[sol.phases["mode"] == "S"]
    time = (sticks["t_end"] - sticks["t_start"]).sum()
    assert 0 < time and orbit.in_stick == pytest.approx(time / orbit.period, rel=1e-9)


def test_curves_follow_the_solution_between_steps():
    x, v = ss.states("x v")
    wall = ss.Jump("wall", when=x + 0.5, set={v: -v})
    sol = ss.solve_ivp(ss.System({x: v, v: -x}, jumps=[wall]), (0, 3), [1, 0])
    axes = sol.plot()
    t, position = axes.lines[0].get_data()
    before = t < 2 * np.pi / 3
    assert np.allclose(position[before], np.cos(t[before]), rtol=0, atol=1e-10)
    # The straight lines between them are a thousandth off at most, which no eye sees.
    fine = np.linspace(0, t[before][-1], 1000)
    drawn = np.interp(fine, t[before], position[before])
    assert len(t) > 10 * len(sol.t) and abs(drawn - np.cos(fine)).max() < 1e-3
    matplotlib.pyplot.close(axes.figure)
    # The requested times are drawn as they are.
    axes = ss.solve_ivp(sol.system, (0, 2), [1, 0], t_eval=[0, 1, 2]).plot()
    assert len(axes.lines[0].get_xdata()) == 3
    matplotlib.pyplot.close(axes.figure)


def test_several_axes_are_refused_where_a_figure_has_one():
    sol = RESULTS["solution"]
    figure, axes = matplotlib.pyplot.subplots(2)
    with pytest.raises(TypeError, match=r"axes are 2, and this figure has one: .* axes\[0\]"):
        sol.plot(axes)
    with pytest.raises(TypeError, match="must be an Axes of matplotlib"):
        sol.plot(figure)
    assert sol.plot(axes[0]) is axes[0] and sol.plot(axes[:1]) is axes[0]
    matplotlib.pyplot.close(figure)
