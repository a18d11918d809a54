"""Adding up what calls take, in seconds of a processor."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from typing import Any

from stiffkit.compiled import BatchFunction


class KernelClock:
    """Adds up what the calls of compiled kernels take, by the kernels' names."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self.seconds: Counter[str] = Counter()

    def install(self) -> None:
        """Let every kernel that is compiled from now on be timed."""
        compile_kernel: Callable[[BatchFunction], Any] = BatchFunction.compile
        clock = self

        def compile_timed(function: BatchFunction) -> Any:
            return _Timed(compile_kernel(function), function.kernel.name, clock.seconds)

        BatchFunction.compile = compile_timed  # type: ignore[assignment, method-assign]


class _Timed:
    """A compiled function that tells what its calls take."""

    def __init__(self, function: Any, name: str, seconds: Counter[str]) -> None:
        self._function = function
        self._name = name
        self._seconds = seconds

    def __getattr__(self, name: str) -> Any:
        return getattr(self._function, name)

    def __call__(self, *args: Any, **keywords: Any) -> Any:
        start = time.thread_time()
        result = self._function(*args, **keywords)
        self._seconds[self._name] += time.thread_time() - start  # type: ignore[assignment]
        return result


def timed(owner: Any, name: str, seconds: Counter[str], what: str) -> None:
    """Let the calls of a function of a module or a class be added up under ``what``."""
    function = getattr(owner, name)

    def wrapped(*args: Any, **keywords: Any) -> Any:
        start = time.thread_time()
        try:
            return function(*args, **keywords)
        finally:
            seconds[what] += time.thread_time() - start  # type: ignore[assignment]

    setattr(owner, name, wrapped)
