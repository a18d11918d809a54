"""Derivatives of kernels with respect to everything that they read, constants included."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from stiffkit.compiled.function import (
    INTERPRETED_CHUNK,
    Backend,
    Trace,
    chunk_of,
    compiled_once,
    filled_up,
    quiet_heyoka,
    variables,
)
from stiffkit.compiled.geometries import decided
from stiffkit.compiled.kernel import Array, Kernel
from stiffkit.smallmat import Tape, vector


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Derivatives of a sum of outputs times seeds, at N postures."""

    inputs: Array
    """(n_inputs, N)."""
    constants: Array
    """(m, N); zero for the constants that are compiled in."""


class AdjointFunction:
    """A kernel's derivatives for a batch of postures, backwards from its outputs.

    They cost a few times what the outputs cost, however many inputs and constants there are.
    """

    def __init__(self, kernel: Kernel, n_seeded: int, backend: Backend) -> None:
        """Take a kernel and how many of its outputs, the first ones, have seeds."""
        self.kernel = kernel
        self.n_seeded = n_seeded
        self._backend = decided(backend)
        self._free = np.flatnonzero(~kernel.constants.compiled_in)

    def __call__(self, inputs: Array, seeds: Array, constants: Array) -> Derivatives:
        """Return the derivatives at inputs (n_inputs, N) of outputs times seeds (n_seeded, N).

        ``constants`` (m,) are those of the postures' geometry; what is compiled in must be the
        same in them as in the kernel's own.
        """
        chunks = self._chunks(inputs.shape[1])
        one = self._interpret if self._backend == "numpy" else self._evaluate
        found = [one(inputs[:, part], seeds[:, part], constants) for part in chunks]
        n = self.kernel.n_inputs
        flat = np.concatenate([np.empty((n + self._free.size, 0)), *found], axis=1)
        by_constants = np.zeros((constants.size, inputs.shape[1]))
        by_constants[self._free] = flat[n:]
        return Derivatives(flat[:n], by_constants)

    def _chunks(self, n: int) -> list[slice]:
        size = INTERPRETED_CHUNK
        if self._backend != "numpy":
            size = chunk_of(2 * (self.kernel.n_inputs + self._free.size) + self.n_seeded)
        return [slice(start, min(start + size, n)) for start in range(0, n, size)]

    def _evaluate(self, inputs: Array, seeds: Array, constants: Array) -> Array:
        width = inputs.shape[1]
        columns = filled_up(np.concatenate([inputs, seeds]))
        # Trailing constants that nothing depends on are unknown to the compiled function.
        free = constants[self._free][: self._function.nparams]
        keywords: dict[str, Any] = {}
        if free.size:
            keywords["pars"] = np.repeat(free[:, None], columns.shape[1], axis=1)
        found = self._function(columns, batch_parallel=False, **keywords)
        return np.asarray(found[:, :width])

    @cached_property
    def _function(self) -> Any:
        pattern = self.kernel.constants.pattern
        key: Hashable = (
            "adjoint",
            self.n_seeded,
            self.kernel.name,
            self.kernel.topology,
            self.kernel.constants.layout,
            pattern,
        )
        return compiled_once(key, lambda: self._compile(pattern))

    def _compile(self, pattern: tuple[float | None, ...]) -> Any:
        heyoka = quiet_heyoka()
        trace = Trace.of(self.kernel, pattern)
        seeds = variables("s", self.n_seeded)
        seeded = trace.outputs[: self.n_seeded]
        total = heyoka.sum([s * out for s, out in zip(seeds, seeded, strict=True)])
        arguments = [*trace.inputs, *trace.parameters]
        gradient = heyoka.diff_tensors([total], diff_args=arguments, diff_order=1).jacobian[0]
        # Four times the code of the kernel: at a lower level it is compiled in a third of the
        # time and runs as fast.
        return heyoka.cfunc(
            list(gradient),
            [*trace.inputs, *seeds],
            compact_mode=self.kernel.large,
            opt_level=1,
        )

    def _interpret(self, inputs: Array, seeds: Array, constants: Array) -> Array:
        tape = Tape()
        x = [tape.variable(row) for row in inputs]
        width = inputs.shape[1]
        free = {i: tape.variable(np.full(width, constants[i])) for i in self._free}
        c = vector(free.get(i, float(value)) for i, value in enumerate(constants))
        with np.errstate(all="ignore"):
            outputs = self.kernel.function(vector(x), c)
        seeded = list(zip(outputs[: self.n_seeded], seeds, strict=True))
        return tape.gradient(seeded, [*x, *free.values()])
