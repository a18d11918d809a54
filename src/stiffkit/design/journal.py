"""The steps of a design study on disk: what is finished is never computed again."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stiffkit.study.sweep.files import read_arrays, write_arrays

Array = NDArray[np.float64]
Step = dict[str, Array]


class Journal:
    """A folder with a file for each step.

    The course of a study is determined by its file: run again, it asks for the same steps in the
    same order, and those that are there already are read.
    """

    def __init__(self, folder: Path | None, key: str) -> None:
        """Take a folder that exists, None for nowhere, and what tells studies apart."""
        self._folder = folder
        self._key = key

    def step(self, name: str, given: Array, compute: Callable[[], Step]) -> Step:
        """Return a step, read or computed, with its ``seconds``.

        What was computed from anything else than ``given`` does not count. Raises OutputError where
        it cannot be written.
        """
        path = None if self._folder is None else self._folder / f"{name}.npz"
        known = None if path is None else read_arrays(path)
        if known is not None and str(known.pop("study", "")) == self._key:
            found = {name: np.asarray(array, dtype=float) for name, array in known.items()}
            if np.array_equal(found.pop("given"), given):
                return found
        begun = time.perf_counter()
        found = compute()
        found["seconds"] = np.array(time.perf_counter() - begun)
        if path is not None:
            write_arrays(path, {**found, "given": given, "study": np.array(self._key)})
        return found
