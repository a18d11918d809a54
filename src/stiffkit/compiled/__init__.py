"""Posture kernels compiled to machine code, with a NumPy fallback."""

from stiffkit.compiled.adjoint import AdjointFunction, Derivatives
from stiffkit.compiled.function import Backend, BatchFunction, default_backend, heyoka_available
from stiffkit.compiled.geometries import GeometriesFunction, decided
from stiffkit.compiled.kernel import Constants, Kernel
from stiffkit.compiled.threads import limited_threads, over_blocks, thread_count

__all__ = [
    "AdjointFunction",
    "Backend",
    "BatchFunction",
    "Constants",
    "Derivatives",
    "GeometriesFunction",
    "Kernel",
    "decided",
    "default_backend",
    "heyoka_available",
    "limited_threads",
    "over_blocks",
    "thread_count",
]
