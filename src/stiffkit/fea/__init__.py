"""Links from CAD: STEP file in, compliance and superelement with an error estimate out."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stiffkit.fea.cad_link import CadLink, link_from_cad
    from stiffkit.fea.child import is_installed
    from stiffkit.fea.estimate import relative_difference
    from stiffkit.fea.geometry import Face, Part, Solid, build_part, read_step
    from stiffkit.fea.interfaces import (
        FacePick,
        Interface,
        Port,
        find_ports,
        named_ports,
        pick_faces,
    )
    from stiffkit.fea.link_spec import LinkSpec, read_inline_spec, read_link_spec
    from stiffkit.fea.material import Law, Orthotropic
    from stiffkit.fea.mesh import MeshSettings, PartMesh, coarse_settings, mesh_part
    from stiffkit.fea.settings import SolveSettings
    from stiffkit.fea.sources import CadFile, PythonPart, RegisteredPart, write_step
    from stiffkit.fea.superelement import PortModel, reduce_part

# Modules load when they are first used: the child process that reads and meshes needs few of them,
# and is started again for every part and every mesh.
_HOMES = {
    "CadLink": "cad_link",
    "link_from_cad": "cad_link",
    "is_installed": "child",
    "SolveSettings": "settings",
    "relative_difference": "estimate",
    "Face": "geometry",
    "Part": "geometry",
    "Solid": "geometry",
    "build_part": "geometry",
    "read_step": "geometry",
    "FacePick": "interfaces",
    "Interface": "interfaces",
    "Port": "interfaces",
    "find_ports": "interfaces",
    "named_ports": "interfaces",
    "pick_faces": "interfaces",
    "LinkSpec": "link_spec",
    "read_inline_spec": "link_spec",
    "read_link_spec": "link_spec",
    "Law": "material",
    "Orthotropic": "material",
    "MeshSettings": "mesh",
    "PartMesh": "mesh",
    "coarse_settings": "mesh",
    "mesh_part": "mesh",
    "CadFile": "sources",
    "PythonPart": "sources",
    "RegisteredPart": "sources",
    "write_step": "sources",
    "PortModel": "superelement",
    "reduce_part": "superelement",
}

__all__ = [
    "CadFile",
    "CadLink",
    "Face",
    "FacePick",
    "Interface",
    "Law",
    "LinkSpec",
    "MeshSettings",
    "Orthotropic",
    "Part",
    "PartMesh",
    "Port",
    "PortModel",
    "PythonPart",
    "RegisteredPart",
    "Solid",
    "SolveSettings",
    "build_part",
    "coarse_settings",
    "find_ports",
    "is_installed",
    "link_from_cad",
    "mesh_part",
    "named_ports",
    "pick_faces",
    "read_inline_spec",
    "read_link_spec",
    "read_step",
    "reduce_part",
    "relative_difference",
    "write_step",
]


def __getattr__(name: str) -> Any:
    """Load a public name from its module."""
    if name in _HOMES:
        return getattr(import_module(f"stiffkit.fea.{_HOMES[name]}"), name)
    raise AttributeError(f"module 'stiffkit.fea' has no attribute {name!r}")
