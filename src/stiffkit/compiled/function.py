"""Kernels as functions over batches of postures: compiled by heyoka, or interpreted by NumPy."""

from __future__ import annotations

import importlib.util
import os
import warnings
from collections import OrderedDict
from collections.abc import Hashable
from functools import cache
from typing import Any, Literal

import numpy as np

from stiffkit.compiled.kernel import Array, Kernel
from stiffkit.errors import StiffkitError
from stiffkit.smallmat import Vector, as_objects, vector

Backend = Literal["auto", "heyoka", "numpy"]

CHUNK = 1024
"""Postures per call of compiled code: inputs, constants and outputs then stay in the L2 cache."""

WORTH_COMPILING = 4096
"""Postures after which "auto" compiles: interpreting them costs about as much as compiling."""

WORTH_COMPILING_LARGE = 200_000
"""The same for large kernels, which take seconds to compile."""

INTERPRETED_CHUNK = 4096
"""Postures per interpreted call, so that intermediate arrays do not fill the memory."""

_CACHE_SIZE = 64
_compiled: OrderedDict[Hashable, Any] = OrderedDict()


@cache
def heyoka_available() -> bool:
    """Tell whether kernels can be compiled here; say once that it will be slower if not."""
    if importlib.util.find_spec("heyoka") is not None:
        return True
    warnings.warn(
        "heyoka is not installed: the NumPy fallback computes the same numbers, "
        "ten to a hundred times slower",
        stacklevel=2,
    )
    return False


def default_backend() -> Backend:
    """Return the backend that the environment variable STIFFKIT_BACKEND names, else "auto".

    Raises StiffkitError for a name that is none.
    """
    named = os.environ.get("STIFFKIT_BACKEND", "auto")
    if named in ("auto", "heyoka", "numpy"):
        return named  # type: ignore[return-value]
    raise StiffkitError(
        f"the environment variable STIFFKIT_BACKEND is '{named}'",
        mend="set it to auto, heyoka or numpy, or not at all",
    )


class BatchFunction:
    """A kernel that takes a batch of postures."""

    def __init__(self, kernel: Kernel, backend: Backend | None = None) -> None:
        """Wrap a kernel; "auto" interprets small amounts of work and compiles for large ones."""
        self.kernel = kernel
        self.backend = backend or default_backend()
        self._values = kernel.constants.values
        self._pattern = kernel.constants.pattern
        self._seen = 0

    def __call__(self, inputs: Array) -> Array:
        """Return the outputs (n_outputs, N) at the inputs (n_inputs, N)."""
        n = inputs.shape[1]
        self._seen += n
        if n == 0:
            n_outputs = len(self._interpret(np.zeros((self.kernel.n_inputs, 1))))
            return np.empty((n_outputs, 0))
        if self._compile_now():
            return self._run_compiled(inputs)
        return self._interpret(inputs)

    def _compile_now(self) -> bool:
        if self.backend == "numpy":
            return False
        if self.backend == "heyoka":
            return True
        threshold = WORTH_COMPILING_LARGE if self.kernel.large else WORTH_COMPILING
        worth = self._seen >= threshold or self._key in _compiled
        return worth and heyoka_available()

    @property
    def _key(self) -> Hashable:
        kernel = self.kernel
        return (kernel.name, kernel.topology, kernel.constants.layout, self._pattern)

    def compile(self) -> Any:
        """Return the compiled function, out of the cache if the topology has been met before."""
        key = self._key
        if key in _compiled:
            _compiled.move_to_end(key)
        else:
            _compiled[key] = self._trace()
            while len(_compiled) > _CACHE_SIZE:
                _compiled.popitem(last=False)
        return _compiled[key]

    def _trace(self) -> Any:
        import heyoka

        inputs = heyoka.make_vars(*(f"x{i}" for i in range(self.kernel.n_inputs)))
        inputs = vector(inputs if isinstance(inputs, list) else [inputs])
        outputs = self.kernel.function(inputs, self._constant_scalars(heyoka))
        expressions = [
            heyoka.expression(float(out)) if isinstance(out, float) else out for out in outputs
        ]
        return heyoka.cfunc(expressions, list(inputs), compact_mode=self.kernel.large)

    def _constant_scalars(self, heyoka: Any) -> Vector:
        free = 0
        scalars: list[Any] = []
        for fixed in self._pattern:
            scalars.append(fixed if fixed is not None else heyoka.par[free])
            free += fixed is None
        return vector(scalars)

    def _run_compiled(self, inputs: Array) -> Array:
        function = self.compile()
        n = inputs.shape[1]
        free = np.array([fixed is None for fixed in self._pattern], dtype=bool)
        # Trailing constants that no output depends on are unknown to the compiled function.
        parameters = self._values[free][: function.nparams]
        outputs = np.empty((function.nouts, n))
        broadcast = np.empty((0, 0))
        for start in range(0, n, CHUNK):
            chunk = np.ascontiguousarray(inputs[:, start : start + CHUNK])
            if broadcast.shape[1] != chunk.shape[1]:
                broadcast = np.repeat(parameters[:, None], chunk.shape[1], axis=1)
            keywords = {"pars": broadcast} if parameters.size else {}
            outputs[:, start : start + CHUNK] = function(chunk, **keywords)
        return outputs

    def _interpret(self, inputs: Array) -> Array:
        n = inputs.shape[1]
        constants = as_objects(self._values)
        if n == 1:
            # One posture runs on Python's own floats, ten times faster than on arrays of length 1.
            outputs = self.kernel.function(as_objects(inputs[:, 0]), constants)
            return np.array(outputs, dtype=float)[:, None]
        chunks = []
        for start in range(0, n, INTERPRETED_CHUNK):
            chunk = inputs[:, start : start + INTERPRETED_CHUNK]
            with np.errstate(all="ignore"):
                outputs = self.kernel.function(vector(chunk), constants)
            shape = (len(outputs), chunk.shape[1])
            chunks.append(np.empty(shape))
            for row, out in zip(chunks[-1], outputs, strict=True):
                row[:] = out
        return np.concatenate(chunks, axis=1)
