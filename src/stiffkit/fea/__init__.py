"""Links from CAD: STEP file in, compliance and superelement with an error estimate out."""

from stiffkit.fea.adapt import Adapted, AdaptSettings, Level, adapt
from stiffkit.fea.cad_link import CadLink, link_from_cad
from stiffkit.fea.elasticity import SolveSettings
from stiffkit.fea.estimate import relative_difference
from stiffkit.fea.geometry import Face, Part, Solid, build_part, read_step
from stiffkit.fea.interfaces import FacePick, Interface, Port, find_ports, pick_faces
from stiffkit.fea.link_spec import LinkSpec, read_inline_spec, read_link_spec
from stiffkit.fea.material import Law, Orthotropic
from stiffkit.fea.mesh import MeshSettings, PartMesh, coarse_settings, mesh_part
from stiffkit.fea.superelement import PortModel, reduce_part

__all__ = [
    "AdaptSettings",
    "Adapted",
    "CadLink",
    "Face",
    "FacePick",
    "Interface",
    "Law",
    "Level",
    "LinkSpec",
    "MeshSettings",
    "Orthotropic",
    "Part",
    "PartMesh",
    "Port",
    "PortModel",
    "Solid",
    "SolveSettings",
    "adapt",
    "build_part",
    "coarse_settings",
    "find_ports",
    "link_from_cad",
    "mesh_part",
    "pick_faces",
    "read_inline_spec",
    "read_link_spec",
    "read_step",
    "reduce_part",
    "relative_difference",
]
