"""Branches of modes through crossings that are known, and neighbours of postures."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from stiffkit.study.grid import PoseGrid
from stiffkit.study.neighbours import lines_through, neighbours
from stiffkit.vibration import Branches, ModeVectors, track_modes
from stiffkit.vibration.tracking import _best_partners

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def modes_of(H: Array, m: int, seed: int = 0) -> ModeVectors:
    """The m lowest eigenvectors of matrices (N, r, r), of arbitrary sign as a solver gives them."""
    values, vectors = np.linalg.eigh(H)
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], (len(H), 1, m))
    return ModeVectors(values[:, :m].T, np.swapaxes(vectors[:, :, :m] * signs, 1, 2))


def two_by_two(mean: Array, half: Array, coupling: Array) -> Array:
    """Matrices (N, 2, 2) with the diagonal mean -+ half."""
    return np.stack(
        [np.stack([mean - half, coupling], -1), np.stack([coupling, mean + half], -1)], -2
    )


def block_diagonal(*blocks: Array) -> Array:
    size = sum(block.shape[1] for block in blocks)
    H = np.zeros((len(blocks[0]), size, size))
    start = 0
    for block in blocks:
        end = start + block.shape[1]
        H[:, start:end, start:end] = block
        start = end
    return H


def grid_of(**counts: int) -> PoseGrid:
    axes = {name: np.linspace(-1.0, 1.0, count) for name, count in counts.items()}
    n = int(np.prod(list(counts.values())))
    return PoseGrid(axes, False, np.ones(n, dtype=bool))


def points_of(**axes: Array) -> PoseGrid:
    return PoseGrid(axes, True, np.ones(next(iter(axes.values())).size, dtype=bool))


def track(modes: ModeVectors, grid: PoseGrid, n: int, known: Mask | None = None) -> Branches:
    where = np.ones(grid.inside.size, dtype=bool) if known is None else known
    beside = neighbours(grid, where)
    part = modes if known is None else modes.part(np.flatnonzero(where))
    return track_modes(part, beside.pairs, beside.middle, n)


def crossing(grid: PoseGrid) -> tuple[Array, Array]:
    """Three modes of turning shape, two of which meet a fourth on a circle; and its frequency."""
    x, y = grid.values().values()
    own = two_by_two(10.0 + x, 2.0 + 0.3 * y, 0.5 + 0.4 * x * y)
    alone = 8.0 + 4.0 * (x**2 + y**2) - 2.0
    high = np.full_like(x, 30.0)
    return block_diagonal(own, alone[:, None, None], high[:, None, None]), alone


def test_modes_keep_their_shape_through_a_crossing() -> None:
    grid = grid_of(x=31, y=27)
    H, alone = crossing(grid)
    own = np.linalg.eigvalsh(H[:, :2, :2]).T
    modes = modes_of(H, 4)
    branches = track(modes, grid, 3)
    found = branches.of(modes.frequencies)
    assert (np.argsort(H.diagonal(axis1=1, axis2=2), axis=1) != np.arange(4)).any()
    assert found[0] == pytest.approx(alone)
    assert found[1:] == pytest.approx(own)
    assert branches.jumps == 0
    assert branches.lowest_overlap > 0.99


def test_the_order_of_pairs_and_the_signs_do_not_count() -> None:
    grid = grid_of(x=15, y=13)
    H, _ = crossing(grid)
    beside = neighbours(grid, grid.inside)
    expected = track_modes(modes_of(H, 4), beside.pairs, beside.middle, 3)
    rng = np.random.default_rng(5)
    shuffled = rng.permutation(beside.pairs)[:, ::-1]
    doubled = np.concatenate([shuffled, beside.pairs[:40]])
    again = track_modes(modes_of(H, 4, seed=9), doubled, beside.middle, 3)
    assert (again.modes == expected.modes).all()
    assert again.pairs == expected.pairs


@pytest.mark.parametrize(("coupling", "crosses"), [(0.3, False), (1e-3, True)])
def test_a_wide_gap_turns_modes_away_and_a_narrow_one_lets_them_through(
    coupling: float, crosses: bool
) -> None:
    grid = grid_of(x=40)
    x = grid.values()["x"]
    modes = modes_of(two_by_two(np.full(40, 10.0), 2.0 * x, np.full(40, coupling)), 2)
    branches = track(modes, grid, 2)
    ends = branches.modes[:, [0, -1]]
    assert (ends[:, 0] != ends[:, 1]).all() == crosses


def test_where_two_modes_meet_in_a_point_the_order_of_frequencies_stays() -> None:
    # The apex of the cone lies beside the middle of a cell's edge, where two shapes swap at once.
    grid = grid_of(x=22, y=21)
    x, y = grid.values().values()
    modes = modes_of(two_by_two(10.0 + 0.2 * x, x, y + 1e-3), 2)
    branches = track(modes, grid, 2)
    far = np.hypot(x, y) > 0.3
    assert (branches.modes[:, far] == np.arange(2)[:, None]).all()
    assert 0 < branches.jumps < 5


def test_a_weak_coupling_does_not_reorder_the_rest() -> None:
    # Coupled at one end only: the way around leads there, and frequencies stay continuous.
    grid = grid_of(x=41, y=31)
    x, y = grid.values().values()
    modes = modes_of(two_by_two(np.full(x.size, 10.0), 2.0 * x, 0.6 * np.maximum(y, 0.0)), 2)
    branches = track(modes, grid, 2)
    found = branches.of(modes.frequencies)
    pairs = neighbours(grid, grid.inside).pairs
    step = np.abs(found[:, pairs[:, 0]] - found[:, pairs[:, 1]])
    assert step.max() < 0.25


def test_modes_go_straight_through_a_posture_of_equal_frequencies() -> None:
    grid = grid_of(x=21)
    x = grid.values()["x"]
    modes = modes_of(two_by_two(10.0 + x, x, np.zeros(21)), 2)
    turn = np.array([[0.6, 0.8], [-0.8, 0.6]])
    modes.vectors[10] = turn @ modes.vectors[10]
    branches = track(modes, grid, 2)
    found = branches.of(modes.frequencies)
    straight = np.stack([np.full(21, 10.0), 10.0 + 2.0 * x])
    assert np.sort(found, axis=0) == pytest.approx(np.sort(straight, axis=0))
    assert any(found[k] == pytest.approx(straight[0]) for k in range(2))
    assert branches.lowest_overlap == pytest.approx(1.0)
    assert branches.jumps == 0


@pytest.mark.parametrize("gap", [0.0, 0.02])
def test_a_posture_at_which_modes_mix_is_bridged(gap: float) -> None:
    # Shapes turn by 6 degrees a step, and at the crossing two modes are mixed half and half: from
    # the left one of the mixtures resembles a mode more, from the right the other one does.
    x = np.linspace(-1.0, 1.0, 21)
    angle = x + np.where(np.abs(x) < 1e-9, np.pi / 4.0, 0.0)
    shapes = np.stack([np.cos(angle), np.sin(angle), -np.sin(angle), np.cos(angle)], 1)
    shapes = shapes.reshape(21, 2, 2)
    values = np.stack([10.0 - x, 10.0 + x])
    values[:, 10] += [0.0, gap]
    order = np.argsort(values, axis=0)
    modes = ModeVectors(np.sort(values, axis=0), shapes[np.arange(21)[:, None], order.T])
    chain = np.stack([np.arange(20), np.arange(1, 21)], 1)
    branches = track_modes(modes, chain, 3, 2)
    found = branches.of(modes.frequencies)
    apart = np.arange(21) != 10
    assert found[0, apart] == pytest.approx((10.0 + x)[apart])
    assert found[1, apart] == pytest.approx((10.0 - x)[apart])


@pytest.mark.parametrize("turn", np.linspace(0.1, 3.0, 9))
def test_a_start_of_equal_frequencies_does_not_decide_the_numbers(turn: float) -> None:
    grid = grid_of(x=21, y=21)
    x, y = grid.values().values()
    modes = modes_of(two_by_two(10.0 + 0.2 * x, x, y), 2)
    middle = neighbours(grid, grid.inside).middle
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    modes.vectors[middle] = rotation @ modes.vectors[middle]
    branches = track(modes, grid, 2)
    assert np.hypot(x, y)[middle] == pytest.approx(0.0)
    assert np.hypot(x, y)[branches.start] == pytest.approx(0.1)
    assert (branches.modes[:, np.hypot(x, y) > 0.3] == np.arange(2)[:, None]).all()


def test_equal_frequencies_everywhere_are_one_subspace() -> None:
    # A pair of modes whose mixture is arbitrary at every posture, and one mode that crosses it.
    grid = grid_of(x=17, y=9)
    x, _ = grid.values().values()
    n = x.size
    pair, alone = np.full(n, 10.0), 10.0 + 1.7 * x - 0.03
    rng = np.random.default_rng(3)
    angles = rng.uniform(0.0, 2.0 * np.pi, n)
    mixed = np.zeros((n, 3, 3))
    mixed[:, 0, :2] = np.stack([np.cos(angles), np.sin(angles)], 1)
    mixed[:, 1, :2] = np.stack([-np.sin(angles), np.cos(angles)], 1)
    mixed[:, 2, 2] = 1.0
    values = np.stack([pair, pair, alone])
    order = np.argsort(values, axis=0, kind="stable")
    modes = ModeVectors(
        np.take_along_axis(values, order, axis=0),
        np.take_along_axis(mixed, order.T[:, :, None], axis=1),
    )
    branches = track(modes, grid, 3)
    found = branches.of(modes.frequencies)
    singles = [k for k in range(3) if np.ptp(found[k]) > 1.0]
    assert len(singles) == 1
    assert found[singles[0]] == pytest.approx(alone)
    assert branches.lowest_overlap == pytest.approx(1.0)


def test_holes_are_gone_around_and_islands_continue_from_the_nearest_posture() -> None:
    grid = grid_of(x=41, y=31)
    x, y = grid.values().values()
    H, alone = crossing(grid)
    known = (np.hypot(x - 0.3, y) > 0.25) & ~((x > 0.6) & (x < 0.7))
    beside = neighbours(grid, known)
    modes = modes_of(H, 4)
    branches = track(modes, grid, 3, known)
    assert branches.of(modes.frequencies[:, known])[0] == pytest.approx(alone[known])
    # One pair more than there are along the grid, to the strip beyond the gap.
    place = np.stack([x, y], 1)[known]
    long = np.linalg.norm(place[beside.pairs[:, 0]] - place[beside.pairs[:, 1]], axis=1) > 0.08
    assert long.sum() == 1


def test_points_of_a_list_are_followed_by_the_nearest() -> None:
    rng = np.random.default_rng(1)
    grid = points_of(x=rng.uniform(-1, 1, 600), y=rng.uniform(-1, 1, 600))
    H, alone = crossing(grid)
    modes = modes_of(H, 4)
    found = track(modes, grid, 3).of(modes.frequencies)
    assert found[0] == pytest.approx(alone)


def test_points_at_one_place_and_a_single_one() -> None:
    grid = points_of(x=np.zeros(20), y=np.zeros(20))
    H, _ = crossing(grid)
    branches = track(modes_of(H, 4), grid, 3)
    assert (branches.modes == np.arange(3)[:, None]).all()
    single = points_of(x=np.zeros(1))
    beside = neighbours(single, single.inside)
    alone = track_modes(modes_of(H[:1], 4), beside.pairs, beside.middle, 3)
    assert alone.modes[:, 0].tolist() == [0, 1, 2]
    assert alone.lowest_overlap == 1.0


def test_a_branch_that_leaves_the_computed_modes_ends() -> None:
    grid = grid_of(x=31)
    x = grid.values()["x"]
    values = np.stack([np.full(31, 1.0), 2.0 + 4.0 * (x + 0.1), *np.repeat([[3.0], [4.0]], 31, 1)])
    modes = modes_of(np.stack([np.diag(v) for v in values.T]), 3)
    branches = track(modes, grid, 2)
    found = branches.of(modes.frequencies)
    assert found[0] == pytest.approx(1.0)
    rises = values[1] > 4.0
    assert rises.any()
    assert found[1, ~rises] == pytest.approx(values[1, ~rises])
    assert np.isnan(found[1, rises]).all()
    assert np.isnan(branches.overlaps[1, rises]).all()


def test_modes_that_do_not_exist_have_no_branch() -> None:
    grid = grid_of(x=9)
    H = block_diagonal(two_by_two(np.full(9, 5.0), np.ones(9), np.zeros(9)), np.full((9, 1, 1), 9))
    modes = modes_of(H, 3)
    modes.frequencies[2], modes.vectors[:, 2] = np.nan, 0.0
    branches = track(modes, grid, 3)
    assert (branches.modes[:2] == np.arange(2)[:, None]).all()
    assert (branches.modes[2] == -1).all()
    assert branches.lowest_overlap == pytest.approx(1.0)
    assert track(ModeVectors(np.full((3, 9), np.nan), np.zeros((9, 3, 0))), grid, 3).jumps == 0


def test_postures_without_a_way_to_the_start_have_no_branches() -> None:
    H = block_diagonal(two_by_two(np.full(6, 5.0), np.ones(6), np.zeros(6)))
    branches = track_modes(modes_of(H, 2), np.array([[0, 1], [1, 2], [4, 5]]), 1, 2)
    assert (branches.modes[:, :3] == np.arange(2)[:, None]).all()
    assert (branches.modes[:, 3:] == -1).all()


@pytest.mark.parametrize("m", [1, 2, 6])
def test_best_partners_are_those_of_the_assignment_problem(m: int) -> None:
    score = np.random.default_rng(m).uniform(size=(200, m, m)) ** 3
    found = _best_partners(score)
    for one, columns in zip(score, found, strict=True):
        rows, best = linear_sum_assignment(one, maximize=True)
        assert one[rows, columns].sum() == pytest.approx(one[rows, best].sum())
        assert sorted(columns) == list(range(m))


def test_neighbours_on_a_grid_are_the_next_along_each_axis() -> None:
    grid = grid_of(x=3, y=4, z=2)
    beside = neighbours(grid, grid.inside)
    index = list(itertools.product(range(3), range(4), range(2)))
    for a, b in beside.pairs:
        assert sum(abs(i - j) for i, j in zip(index[a], index[b], strict=True)) == 1
    assert len(beside.pairs) == 2 * 4 * 2 + 3 * 3 * 2 + 3 * 4 * 1
    assert index[beside.middle] == (1, 1, 0)


def test_lines_run_through_a_pose_along_each_axis() -> None:
    grid = grid_of(x=3, y=4, z=2)
    values = grid.values()
    pose = 13
    for axis, line in lines_through(grid, pose).items():
        assert pose in line
        assert values[axis][line] == pytest.approx(grid.axes[axis])
        for other in set(grid.axes) - {axis}:
            assert (values[other][line] == values[other][pose]).all()
    assert lines_through(points_of(x=np.zeros(3)), 0) == {}
