"""The virtual work of an elastic body, in NGSolve's words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from stiffkit.errors import CadError
from stiffkit.fea.material import Law, Orthotropic
from stiffkit.link.materials import Material
from stiffkit.spatial.rotation import Array


def virtual_work(mesh: Any, laws: Sequence[Law], D: Any, d: Any) -> Any:
    """Return the virtual work per volume of displacement gradients D and d.

    ``laws`` has one law for each of the mesh's materials s0, s1 ...
    """
    from ngsolve import CF, InnerProduct, Sym, Trace

    isotropic = [law for law in laws if isinstance(law, Material)]
    if len(isotropic) == len(laws):
        lam = mesh.MaterialCF({f"s{i}": _lame(law) for i, law in enumerate(isotropic)})
        mu = mesh.MaterialCF({f"s{i}": law.G for i, law in enumerate(isotropic)})
        return 2.0 * mu * InnerProduct(Sym(D), Sym(d)) + lam * Trace(D) * Trace(d)
    matrices = {
        f"s{i}": CF(tuple(law_stiffness(law).ravel().tolist()), dims=(6, 6))
        for i, law in enumerate(laws)
    }
    return InnerProduct(mesh.MaterialCF(matrices) * _strain(D), _strain(d))


def law_stiffness(law: Law) -> Array:
    """Return the stiffness (6, 6), Pa, of a law; order xx, yy, zz, yz, xz, xy."""
    if isinstance(law, Orthotropic):
        return law.stiffness()
    C = np.diag(np.repeat([2.0 * law.G, law.G], 3))
    C[:3, :3] += _lame(law)
    return C


def one_for_each(laws: Sequence[Law], n_solids: int) -> tuple[Law, ...]:
    """Return a law for each solid, from one for each or one for all."""
    if len(laws) == 1:
        return tuple(laws) * n_solids
    if len(laws) != n_solids:
        raise CadError(
            f"the part has {n_solids} solids and {len(laws)} materials",
            mend="give one material for all, or one for each solid",
        )
    return tuple(laws)


def _lame(law: Material) -> float:
    """Return Lame's first parameter, Pa."""
    return law.E * law.nu / ((1.0 + law.nu) * (1.0 - 2.0 * law.nu))


def _strain(D: Any) -> Any:
    """Return the engineering strains of a gradient, ordered xx, yy, zz, yz, xz, xy."""
    from ngsolve import CF

    shears = (D[1, 2] + D[2, 1], D[0, 2] + D[2, 0], D[0, 1] + D[1, 0])
    return CF((D[0, 0], D[1, 1], D[2, 2], *shears))
