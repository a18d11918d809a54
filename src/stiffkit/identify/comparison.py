"""The same compliance found in other ways, to be set side by side."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from stiffkit.identify.compliance import identify
from stiffkit.identify.gather import Chosen
from stiffkit.identify.identified import Identified, Options
from stiffkit.identify.spec import ESTIMATORS
from stiffkit.progress import Progress
from stiffkit.spatial.rotation import Array


@dataclass(frozen=True, eq=False)
class Alternative:
    """A compliance found in another way than the main one."""

    name: str
    words: str
    """How, for people."""
    node_count: int
    compliance: Array
    """(6, 6), the mean of the estimate and its transpose."""
    sigma: float
    """m."""
    largest_difference: float
    """From the main compliance: of all elements, over the root of their two diagonal elements."""


def alternatives(
    main: Identified,
    chosen: Chosen,
    others: Mapping[str, Chosen],
    wrenches: Array,
    progress: Progress,
) -> Iterator[Alternative]:
    """Yield the other estimators, the fit before outliers were dealt with, and other nodes.

    ``wrenches`` (m, 6) are those of the load cases, in N and N m, in the axes of the fields.
    """
    options = main.options
    plain = replace(options, outliers="keep") if options.outliers == "robust" else options

    def other(name: str, words: str, choice: Chosen, how: Options) -> Alternative:
        progress(f"comparing: {name}", 0.7)
        found = identify(choice.field, wrenches, main.reference, how)
        return _alternative(name, words, found, main)

    for word, estimator in ESTIMATORS.items():
        if estimator != options.estimator:
            how = replace(plain, estimator=estimator)
            yield other(word, f"estimator {word}", chosen, how)
    if options.outliers != "keep":
        how = replace(options, outliers="keep")
        yield other("with outliers", "all nodes of the selection", chosen, how)
    for name, choice in others.items():
        words = f"{choice.words}, {choice.weights_words}"
        yield other(name, words, choice, options)


def _alternative(name: str, words: str, found: Identified, main: Identified) -> Alternative:
    size = np.sqrt(np.abs(np.diag(main.symmetrised)))
    difference = np.abs(found.symmetrised - main.symmetrised) / np.outer(size, size)
    return Alternative(
        name,
        words,
        found.node_count,
        found.symmetrised,
        found.sigma,
        float(np.nan_to_num(difference).max()),
    )
