"""Making a large map small enough to look at: blocks of postures, each shown at its worst."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.plots import OK

Array = NDArray[np.float64]
Blocks = tuple[int, ...]


def block_sizes(shape: tuple[int, ...], limit: int) -> Blocks:
    """Return how many postures go into one block along each axis.

    Args:
        shape: of the sweep.
        limit: largest number of blocks in all, at least 1.

    Returns:
        Sizes, all 1 if ``shape`` is small enough; the finest axis is thinned first.
    """
    sizes = np.ones(len(shape), dtype=int)
    counts = np.array(shape)
    while counts.prod() > limit:
        sizes[np.argmax(counts)] += 1
        counts = -(-np.array(shape) // sizes)
    return tuple(int(size) for size in sizes)


def worst_of_blocks(values: Array, blocks: Blocks, *, worst_is_largest: bool) -> Array:
    """Return the worst value of each block; NaN where no posture in it has a value."""
    split, inner = _split(values, blocks, np.nan)
    worst: Array = (np.fmax if worst_is_largest else np.fmin).reduce(split, axis=inner)
    return worst


def centres_of_blocks(values: NDArray[np.generic], blocks: Blocks) -> NDArray[np.generic]:
    """Return the value at the posture in the middle of each block."""
    picks = [_centres(n, block) for n, block in zip(values.shape, blocks, strict=True)]
    return values[np.ix_(*picks)]


def coordinates_of_blocks(coordinate: Array, block: int) -> Array:
    """Return the coordinate of the posture in the middle of each block along one axis."""
    return coordinate[_centres(coordinate.size, block)]


def status_of_blocks(status: NDArray[np.int8], blocks: Blocks) -> NDArray[np.int8]:
    """Return OK for blocks with at least one computed posture, else their middle's status."""
    split, inner = _split((status == OK).astype(np.int8), blocks, 0)
    any_computed = split.max(axis=inner) == 1
    centres = centres_of_blocks(status, blocks).astype(np.int8)
    # The middle of a block that ends beyond the grid, or a lone posture, may be computed or not;
    # what counts is whether the block has a value to show.
    centres[any_computed] = OK
    return centres


def _centres(count: int, block: int) -> NDArray[np.intp]:
    starts = np.arange(0, count, block)
    ends = np.minimum(starts + block, count) - 1
    centres: NDArray[np.intp] = (starts + ends) // 2
    return centres


def _split(
    values: NDArray[np.generic], blocks: Blocks, filling: float
) -> tuple[NDArray[np.generic], tuple[int, ...]]:
    """Return ``values`` with each axis split in two, blocks and postures, and the latter axes."""
    padding = [(0, -n % block) for n, block in zip(values.shape, blocks, strict=True)]
    padded = np.pad(values, padding, constant_values=filling)
    shape = [part for n, b in zip(padded.shape, blocks, strict=True) for part in (n // b, b)]
    return padded.reshape(shape), tuple(range(1, 2 * values.ndim, 2))
