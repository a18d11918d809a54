"""Kernels as functions over batches of postures: compiled by heyoka, or interpreted by NumPy."""

from __future__ import annotations

import importlib.util
import os
import warnings
from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

import numpy as np

from stiffkit.compiled.kernel import Array, Kernel
from stiffkit.errors import StiffkitError
from stiffkit.smallmat import as_objects, vector

Backend = Literal["auto", "heyoka", "numpy"]

LARGEST_CHUNK = 8192
"""Postures per call of compiled code: as many as maps compute at a time, so that small kernels need
no copies. Large ones take less, whose inputs, constants and outputs stay in the cache."""

_WORKING_SET = 1 << 21
"""Bytes of inputs, constants and outputs of one call."""

LANES = 8
"""Postures are computed in groups of as many, filled up if need be, so that the numbers of one do
not depend on how many others there are: what is left over after whole registers would be computed
by other machine code."""

WORTH_COMPILING = 4096
"""Postures after which "auto" compiles: interpreting them costs about as much as compiling."""

WORTH_COMPILING_LARGE = 50_000
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


Evaluate = Callable[[Array], Array]
"""A kernel of one robot: inputs (n_inputs, N) to outputs (n_outputs, N)."""


class BatchFunction:
    """A kernel that takes a batch of postures."""

    def __init__(self, kernel: Kernel, backend: Backend | None = None) -> None:
        """Wrap a kernel; "auto" interprets small amounts of work and compiles for large ones."""
        self.kernel = kernel
        self.backend = backend or default_backend()
        self._values = kernel.constants.values
        self._pattern = kernel.constants.pattern
        self._seen = 0
        self._compiled: _Compiled | None = None

    def __call__(self, inputs: Array) -> Array:
        """Return the outputs (n_outputs, N) at the inputs (n_inputs, N)."""
        return self.ready_for(inputs.shape[1])(inputs)

    def ready_for(self, n: int) -> Evaluate:
        """Return this function for work on about ``n`` postures, given in any number of parts.

        Whether it is compiled is decided here and now, so that no number depends on the order in
        which the parts are computed; they may be computed by several threads.
        """
        self._seen += n
        if self._compiled is None and n > 0 and self._compile_now():
            self._compiled = _Compiled(self.compile(), self._free_values)
        return self._compiled or self._interpret

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
        return compiled_once(self._key, self._compile)

    def _compile(self) -> Any:
        heyoka = quiet_heyoka()
        trace = Trace.of(self.kernel, self._pattern)
        return heyoka.cfunc(trace.outputs, trace.inputs, compact_mode=self.kernel.large)

    @property
    def _free_values(self) -> Array:
        """The constants that are inputs."""
        return self._values[[fixed is None for fixed in self._pattern]]

    def _interpret(self, inputs: Array) -> Array:
        n = inputs.shape[1]
        constants = as_objects(self._values)
        if n == 0:
            n_outputs = len(self._interpret(np.zeros((self.kernel.n_inputs, 1))))
            return np.empty((n_outputs, 0))
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


def compiled_once(key: Hashable, make: Callable[[], Any]) -> Any:
    """Return a compiled function, out of the cache if the topology has been met before."""
    if key in _compiled:
        _compiled.move_to_end(key)
    else:
        _compiled[key] = make()
        while len(_compiled) > _CACHE_SIZE:
            _compiled.popitem(last=False)
    return _compiled[key]


def quiet_heyoka() -> Any:
    """Return the library, which would tell on standard output that it cannot write its cache."""
    import heyoka

    heyoka.set_logger_level_error()
    return heyoka


@dataclass(frozen=True, eq=False)
class Trace:
    """A kernel as expressions."""

    inputs: list[Any]
    outputs: list[Any]
    parameters: list[Any]
    """The constants that are inputs of the compiled function, in order."""

    @staticmethod
    def of(kernel: Kernel, pattern: tuple[float | None, ...]) -> Trace:
        """Run a kernel on expressions; ``pattern`` has the constants that are compiled in."""
        heyoka = quiet_heyoka()
        inputs = variables("x", kernel.n_inputs)
        parameters = [heyoka.par[i] for i in range(sum(fixed is None for fixed in pattern))]
        free = iter(parameters)
        constants = vector(next(free) if fixed is None else fixed for fixed in pattern)
        outputs = [
            heyoka.expression(out) if isinstance(out, float) else out
            for out in kernel.function(vector(inputs), constants)
        ]
        return Trace(inputs, outputs, parameters)


def variables(name: str, n: int) -> list[Any]:
    """Return ``n`` variables of expressions."""
    found = quiet_heyoka().make_vars(*(f"{name}{i}" for i in range(n)))
    return found if isinstance(found, list) else [found]


class _Compiled:
    """A compiled function and the constants of one robot."""

    def __init__(self, function: Any, constants: Array) -> None:
        self._function = function
        # Trailing constants that no output depends on are unknown to the compiled function.
        constants = constants[: function.nparams]
        self._chunk = chunk_of(function.nvars + function.nouts + constants.size)
        self._constants = np.repeat(constants[:, None], self._chunk, axis=1)

    def __call__(self, inputs: Array) -> Array:
        """Return the outputs (n_outputs, N) at the inputs (n_inputs, N)."""
        n = inputs.shape[1]
        if n <= self._chunk:
            return self._evaluate(inputs, None)[:, :n]
        outputs = np.empty((self._function.nouts, n))
        whole = np.empty((self._function.nouts, self._chunk))
        for start in range(0, n, self._chunk):
            part = slice(start, min(start + self._chunk, n))
            width = part.stop - part.start
            into = whole if width == self._chunk else None
            outputs[:, part] = self._evaluate(inputs[:, part], into)[:, :width]
        return outputs

    def _evaluate(self, inputs: Array, outputs: Array | None) -> Array:
        chunk = filled_up(inputs)
        keywords: dict[str, Any] = {"outputs": outputs} if outputs is not None else {}
        if self._constants.size:
            keywords["pars"] = np.ascontiguousarray(self._constants[:, : chunk.shape[1]])
        # Threads are ours to start: inside of one of them there is none to spare.
        return np.asarray(self._function(chunk, batch_parallel=False, **keywords))


def chunk_of(numbers: int) -> int:
    """Return how many postures to compute at a time, each with so many numbers in and out."""
    chunk = LARGEST_CHUNK
    while chunk > LARGEST_CHUNK // 32 and chunk * numbers * 8 > _WORKING_SET:
        chunk //= 2
    return chunk


def filled_up(columns: Array) -> Array:
    """Return columns (k, N) in a row of memory, the last one repeated up to whole `LANES`."""
    missing = -columns.shape[1] % LANES
    if missing and columns.shape[1]:
        columns = np.concatenate([columns, np.repeat(columns[:, -1:], missing, axis=1)], axis=1)
    return np.ascontiguousarray(columns)
