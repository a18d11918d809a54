"""How sections and materials are written in files."""

from __future__ import annotations

from collections.abc import Mapping

from stiffkit.errors import LinkError
from stiffkit.files.entry import Entry
from stiffkit.files.names import suggest
from stiffkit.link.materials import MATERIALS, Material
from stiffkit.link.sections import Section, box, rectangle, round_bar, tube
from stiffkit.units import AREA, DENSITY, LENGTH, NUMBER, PRESSURE, SECOND_MOMENT


def read_section(entry: Entry) -> Section:
    """Return the cross-section of a beam. Raises FileError where no beam can have it."""
    (kind, given), *_ = entry.items()
    try:
        match kind:
            case "round":
                return round_bar(given.quantity(LENGTH))
            case "tube":
                return tube(*given.vector(LENGTH).tolist())
            case "rectangle":
                return rectangle(*given.vector(LENGTH).tolist())
            case "box":
                return box(*given.vector(LENGTH).tolist())
        return _given_section(given)
    except LinkError as error:
        raise given.blame(error) from None


def _given_section(entry: Entry) -> Section:
    shear = {
        key: None if (given := entry.get(key)) is None else given.positive(NUMBER)
        for key in ("shear_y", "shear_z")
    }
    return Section(
        area=entry["area"].positive(AREA),
        Iy=entry["Iy"].positive(SECOND_MOMENT),
        Iz=entry["Iz"].positive(SECOND_MOMENT),
        torsion=entry["torsion"].positive(SECOND_MOMENT),
        shear_y=shear["shear_y"],
        shear_z=shear["shear_z"],
    )


def read_materials(entry: Entry | None) -> dict[str, Material]:
    """Return the built-in materials and those of the file.

    Raises FileError where one cannot exist, or has the name of a built-in one.
    """
    materials = dict(MATERIALS)
    for name, given in [] if entry is None else entry.items():
        if name in MATERIALS:
            raise given.error(f"'{name}' is a built-in material", "choose another name")
        try:
            materials[name] = Material(
                name,
                E=given["E"].positive(PRESSURE),
                nu=given["nu"].quantity(NUMBER),
                density=given["density"].positive(DENSITY),
            )
        except LinkError as error:
            raise given.blame(error) from None
    return materials


def read_material(entry: Entry, materials: Mapping[str, Material]) -> Material:
    """Return the material that a text names. Raises FileError where there is none."""
    name = entry.text()
    if name not in materials:
        raise entry.error(f"there is no material '{name}'", suggest(name, materials))
    return materials[name]
