"""Basins in numbers, against closed forms and the program."""

import json
import os
import subprocess

import numpy as np
import pytest
import stickslip as ss

X, Y = ss.states("x y")
P = ss.parameter("p", 0.0)


def wells():
    """Equilibria at (-1, 0) and (1, 0), whose basins meet at x = y^2/3."""
    u = X - Y**2 / 3
    return ss.System({X: u - u**3 - 2 / 3 * Y**2, Y: -Y})


def grid(side):
    middles = -2 + 4 * (np.arange(side) + 0.5) / side
    return np.stack(np.meshgrid(middles, middles), axis=-1)


def test_measures_are_those_of_the_program(tmp_path):
    system = wells()
    (tmp_path / "wells.toml").write_text(system.to_toml(), encoding="utf-8")
    options = "--x x=-2:2 --y y=-2:2 --grid 64x64 --tol 1e-10 --entropy 8 --dimension"
    run = [os.environ["STICKSLIP"], "basin", "wells.toml", *options.split()]
    run += ["--return-within", "0.01", "--push", "x", "--json"]
    done = subprocess.run(run, cwd=tmp_path, check=True, capture_output=True)
    theirs = json.loads(done.stdout)
    found = ss.basins_of_attraction(
        system, grid(64), return_within=0.01, rtol=1e-10, atol=1e-10
    )
    entropy, boundary = found.entropy(8), found.uncertainty_exponent()
    for name in ("sb", "sb_std_error", "sbb", "sbb_std_error", "boxes", "boundary_boxes"):
        assert getattr(entropy, name) == theirs["entropy"][name], name
    for name in ("exponent", "dimension", "std_error"):
        assert getattr(boundary, name) == theirs["boundary"][name], name
    table = found.attractors
    for own, one in zip(table, theirs["attractors"]):
        assert own["mean_return"] == pytest.approx(one["return_time"]["mean"], rel=1e-12)
        assert own["mean_return_error"] == pytest.approx(one["return_time"]["std_error"], rel=1e-9)
        assert own["largest_return"] == one["return_time"]["largest"]
    from_left = next(one for one in theirs["pushes"] if one["push"] is not None)
    push = ss.least_push(system, [-1, 0], [[1, 0]], largest=3, rtol=1e-10, atol=1e-10)
    assert push.size[0] == pytest.approx(from_left["push"], abs=1e-8)


def test_returns_take_their_time():
    decay = ss.System({X: -X})
    found = ss.basins_of_attraction(decay, [[2.0], [-0.5], [1e-4]], return_within=1e-3)
    assert found.return_time == pytest.approx([np.log(2000), np.log(500), 0], abs=1e-8)
    assert found.attractors["largest_return"][0] == found.return_time[0]
    assert ss.basins_of_attraction(decay, [[2.0]]).return_time is None
    with pytest.raises(ss.OptionError, match="return_within"):
        ss.basins_of_attraction(decay, [[2.0]], return_within=0)


def test_pushes_and_edges_are_those_of_the_boundary():
    found = ss.least_push(wells(), [1, 0], [[-1, 0], [1, 0], [-1, 1]], largest=4, workers=1)
    assert found.size[[0, 2]] == pytest.approx([1, (np.sqrt(21) - 3) / 2], abs=1e-8)
    assert np.isnan(found.size[1]) and found.beyond == ["equilibrium", "", "equilibrium"]
    assert found.y_beyond[0] == pytest.approx([-1, 0], abs=1e-9)
    edge = ss.edge_state(wells(), [-1, 1.5], [1, 1.5])
    assert edge.kind == "equilibrium" and edge.unstable == 1 and np.isnan(edge.period)
    assert abs(edge.y).max() < 1e-9 and edge.beside == ("equilibrium", "equilibrium")
    assert np.allclose(edge.track[:, 0], edge.track[:, 1] ** 2 / 3, atol=1e-3)
    with pytest.raises(ss.OptionError, match="different attractors"):
        ss.edge_state(wells(), [1, 0], [2, 0])
    with pytest.raises(ss.OptionError, match="direction"):
        ss.least_push(wells(), [1, 0], [[0, 0]], largest=1)


def test_shares_are_followed_along_a_parameter():
    fold = ss.System({X: P + X - X**3})
    starts = np.linspace(-1.995, 1.995, 400)[:, None]
    values = np.round(np.arange(-1, 1.05, 0.1), 1)
    found = ss.basin_shares(fold, P, values, starts)
    assert found.shares.shape == (21, 2) and found.shares.sum(axis=1) == pytest.approx(1)
    # The folds lie at 2/sqrt(27) = 0.385 on both sides.
    assert (found.first[0], found.last[0]) == (-1, 0.3)
    assert (found.first[1], found.last[1]) == (-0.3, 1)
    assert found.shares[10] == pytest.approx([0.5, 0.5]) and found.kind == ["equilibrium"] * 2
    assert found.std_errors[10, 0] == pytest.approx(0.025)
    assert len(found.to_pandas()) == 21 + 7 and found.to_xarray().shares.dims == ("p", "band")


def test_grids_that_do_not_fit_are_refused():
    found = ss.basins_of_attraction(wells(), grid(10), rtol=1e-8)
    for side in (3, 1, 10):
        with pytest.raises(ss.OptionError, match="side"):
            found.entropy(side)
    with pytest.raises(ss.OptionError, match="64 starts"):
        found.uncertainty_exponent()
