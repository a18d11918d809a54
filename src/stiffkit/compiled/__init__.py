"""Posture kernels compiled to machine code, with a NumPy fallback."""

from stiffkit.compiled.function import Backend, BatchFunction, default_backend, heyoka_available
from stiffkit.compiled.kernel import Constants, Kernel

__all__ = [
    "Backend",
    "BatchFunction",
    "Constants",
    "Kernel",
    "default_backend",
    "heyoka_available",
]
