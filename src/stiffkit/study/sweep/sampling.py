"""The geometries of a study: values of the parameters that are varied."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from stiffkit.study.sweep.spec import StudySpec

Array = NDArray[np.float64]


def parameter_values(spec: StudySpec, geometries: NDArray[np.intp]) -> Array:
    """Return the values (k, n), SI, of the varied parameters of n geometries by their numbers.

    A grid counts through the last parameter fastest. A latin hypercube is that of
    `scipy.stats.qmc.LatinHypercube` with the study's seed.
    """
    if not spec.varied:
        return np.empty((0, geometries.size))
    if spec.sample is None:
        shape = tuple(len(varied.values) for varied in spec.varied)
        indices = np.unravel_index(geometries, shape)
        columns = [
            np.array(varied.values)[index]
            for varied, index in zip(spec.varied, indices, strict=True)
        ]
        return np.array(columns)
    low, high = np.array([varied.values for varied in spec.varied]).T[:, :, None]
    return np.asarray(low + (high - low) * _unit_sample(spec)[geometries].T)


@lru_cache(maxsize=2)
def _unit_sample(spec: StudySpec) -> Array:
    """Return points (n, k) in the unit cube."""
    from scipy.stats.qmc import LatinHypercube  # slow to import

    return np.asarray(LatinHypercube(len(spec.varied), rng=spec.seed).random(spec.sample))
