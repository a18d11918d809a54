"""From a specification to what is solved: the part, its ports, the materials of its solids."""

from __future__ import annotations

from stiffkit.errors import CadError
from stiffkit.fea.child import check_installed
from stiffkit.fea.geometry import Part
from stiffkit.fea.interfaces import FacePick, Interface, Port, find_ports, pick_faces
from stiffkit.fea.link_spec import LinkSpec, PortSpec, blamed_on
from stiffkit.fea.material import Law


def read_part(spec: LinkSpec) -> Part:
    """Return the part of a specification.

    Raises FileError, at the place in the specification, if it is no single solid body.
    """
    check_installed()
    with blamed_on(spec.cad_place):
        return spec.cad.read(spec.scale)


def ports_of(part: Part, spec: LinkSpec) -> tuple[Port, ...]:
    """Return the ports of a specification, base first. Raises FileError if faces are not found."""
    interfaces = [_interface(part, name, port) for name, port in spec.ports]
    with blamed_on(spec.ports[-1][1].place):
        return find_ports(part, interfaces)


def laws_of(part: Part, spec: LinkSpec) -> list[Law]:
    """Return the material of each solid. Raises FileError if there is none of a name."""
    names = [solid.name for solid in part.solids]
    with blamed_on(spec.cad_place):
        for name in spec.solids:
            if name not in names:
                raise CadError(
                    f"the part has no solid '{name}'", mend=f"its solids are {', '.join(names)}"
                )
    return [spec.solids.get(name, spec.material) for name in names]


def _interface(part: Part, name: str, port: PortSpec) -> Interface:
    """Return an interface with its faces by number, found one description after another."""
    indices: list[int] = []
    for pick in port.picks:
        with blamed_on(port.place["faces"]):
            faces = pick_faces(part, pick, what=name)
        indices.extend(face.index for face in faces if face.index not in indices)
    return Interface(name, FacePick(indices=tuple(indices)), port.kind, port.point, port.axes)
