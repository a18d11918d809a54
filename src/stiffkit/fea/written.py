"""How the materials of parts are written in files."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stiffkit.errors import LinkError
from stiffkit.fea.material import Law, Orthotropic
from stiffkit.files import Entry, read_frame
from stiffkit.link import Material
from stiffkit.link.written import read_material
from stiffkit.units import DENSITY, NUMBER, PRESSURE

OWN = "given"
"""What a material that is given by its values is called."""


def read_law(entry: Entry, materials: Mapping[str, Material]) -> Law:
    """Return the material that an entry names or describes. Raises FileError where none can be."""
    if isinstance(entry.node.value, str):
        return read_material(entry, materials)
    try:
        return _orthotropic(entry) if isinstance(entry["E"].node.value, list) else _isotropic(entry)
    except LinkError as error:
        raise entry.blame(error) from None


def _isotropic(entry: Entry) -> Material:
    for key in ("G", "axes"):
        if (given := entry.get(key)) is not None:
            raise given.error(
                f"'{key}' is given, and E is one number", "of an orthotropic material E has three"
            )
    return Material(
        OWN,
        E=entry["E"].positive(PRESSURE),
        nu=entry["nu"].quantity(NUMBER),
        density=entry["density"].positive(DENSITY),
    )


def _orthotropic(entry: Entry) -> Orthotropic:
    if not isinstance(entry["nu"].node.value, list):
        raise entry["nu"].error("E has three values and nu one", "write [nu12, nu13, nu23]")
    E1, E2, E3 = entry["E"].vector(PRESSURE).tolist()
    nu12, nu13, nu23 = entry["nu"].vector(NUMBER).tolist()
    G12, G13, G23 = entry["G"].vector(PRESSURE).tolist()
    axes = read_frame(entry, rotate="axes").rotation if "axes" in entry else np.eye(3)
    return Orthotropic(
        OWN,
        E1=E1,
        E2=E2,
        E3=E3,
        nu12=nu12,
        nu13=nu13,
        nu23=nu23,
        G12=G12,
        G13=G13,
        G23=G23,
        density=entry["density"].positive(DENSITY),
        axes=axes,
    )
