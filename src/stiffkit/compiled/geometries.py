"""Kernels for postures of many geometries: every posture has constants of its own."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled.function import (
    INTERPRETED_CHUNK,
    Backend,
    BatchFunction,
    chunk_of,
    filled_up,
    heyoka_available,
)
from stiffkit.compiled.kernel import Array, Kernel
from stiffkit.smallmat import Vector, vector

Postures = Callable[[Array], Array]
"""A kernel at constants that are fixed: inputs (n, N) to outputs (k, N)."""


def decided(backend: Backend) -> Backend:
    """Return "heyoka" or "numpy": what a long computation uses from its first posture on.

    A choice by the work seen so far would make numbers depend on what was computed before them.
    """
    if backend == "auto":
        return "heyoka" if heyoka_available() else "numpy"
    return backend


class GeometriesFunction:
    """A kernel whose constants are given with each call.

    All geometries have the topology of the kernel: the entries that are compiled in are the same.
    """

    def __init__(self, kernel: Kernel, backend: Backend) -> None:
        """Take a kernel of one of the geometries; it is compiled when first used."""
        self.kernel = kernel
        self._backend = decided(backend)
        self._batch = BatchFunction(kernel, self._backend)
        self._free: NDArray[np.bool_] = ~kernel.constants.compiled_in

    def at(self, constants: Array, number: NDArray[np.intp]) -> Postures:
        """Return the kernel for N postures of geometries with constants (m, G).

        ``number`` (N,) tells which of the geometries each posture is one of.
        """
        if self._backend == "numpy":
            return self._interpreted(constants[:, number])
        return self._compiled(constants, number)

    def compiled(self) -> GeometriesFunction:
        """Return this, compiled now if ever, for several threads to use."""
        if self._backend != "numpy":
            _ = self._function
        return self

    @cached_property
    def _function(self) -> Any:
        return self._batch.compile()

    def _compiled(self, constants: Array, number: NDArray[np.intp]) -> Postures:
        function = self._function
        n = number.size
        # Trailing constants that no output depends on are unknown to the compiled function.
        free = constants[self._free][: function.nparams]
        chunk = chunk_of(function.nvars + function.nouts + function.nparams)
        blocks = [
            (
                slice(start, min(start + chunk, n)),
                filled_up(np.take(free, number[start : start + chunk], axis=1)),
            )
            for start in range(0, n, chunk)
        ]

        def evaluate(inputs: Array) -> Array:
            outputs = np.empty((function.nouts, n))
            for where, parameters in blocks:
                keywords = {"pars": parameters} if free.size else {}
                chunk = filled_up(inputs[:, where])
                found = function(chunk, batch_parallel=False, **keywords)
                if len(blocks) == 1:
                    return np.asarray(found[:, :n])
                outputs[:, where] = found[:, : where.stop - where.start]
            return outputs

        return evaluate

    def _interpreted(self, constants: Array) -> Postures:
        n = constants.shape[1]
        blocks = [
            slice(start, start + INTERPRETED_CHUNK) for start in range(0, n, INTERPRETED_CHUNK)
        ]

        def evaluate(inputs: Array) -> Array:
            return np.concatenate([self._at_block(inputs, constants, b) for b in blocks], axis=1)

        return evaluate

    def _at_block(self, inputs: Array, constants: Array, block: slice) -> Array:
        width = constants[:, block].shape[1]
        with np.errstate(all="ignore"):
            found = self.kernel.function(vector(inputs[:, block]), self._scalars(constants, block))
        outputs = np.empty((len(found), width))
        for row, out in zip(outputs, found, strict=True):
            row[:] = out
        return outputs

    def _scalars(self, constants: Array, block: slice) -> Vector:
        """Return the constants: floats where the topology shows, arrays elsewhere."""
        scalars: list[Any] = [
            row if free else float(row[0])
            for row, free in zip(constants[:, block], self._free, strict=True)
        ]
        return vector(scalars)
