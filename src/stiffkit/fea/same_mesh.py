"""A part on one given mesh: the link that it is there, and its matrices as they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stiffkit.fea.discretisation import Discretisation
from stiffkit.fea.geometry import Part
from stiffkit.fea.interfaces import Port
from stiffkit.fea.link_spec import LinkSpec, blamed_on
from stiffkit.fea.material import Law
from stiffkit.fea.mesh import MeshSettings, PartMesh, mesh_part
from stiffkit.fea.prepared import laws_of, ports_of, read_part
from stiffkit.fea.settings import SolveSettings
from stiffkit.fea.solve import BASE
from stiffkit.fea.superelement import reduce_part
from stiffkit.link import Superelement
from stiffkit.spatial.frame import Frame


@dataclass(frozen=True, eq=False)
class MeshedPart:
    """A part with its interfaces, its materials and a mesh."""

    spec: LinkSpec
    part: Part
    ports: tuple[Port, ...]
    laws: Sequence[Law]
    mesh: PartMesh

    def discretised(self, settings: SolveSettings) -> Discretisation:
        """Return its matrices, by elements of these orders."""
        return Discretisation(self.mesh, self.laws, settings)

    def reduced(self, settings: SolveSettings, T_part_link: Frame) -> Superelement:
        """Return it reduced to its ports on this mesh, in link axes. Raises FileError."""
        with blamed_on(self.spec.cad_place):
            model = reduce_part(self.mesh, self.ports, self.laws, settings, BASE)
            return model.to_link(self.spec.n_modes, T_part_link.rotation)


def meshed_part(spec: LinkSpec, mesh: PartMesh) -> MeshedPart:
    """Return the part of a specification with a mesh of it. Raises FileError."""
    part = read_part(spec)
    return MeshedPart(spec, part, ports_of(part, spec), laws_of(part, spec), mesh)


def mesh_spec(spec: LinkSpec, settings: MeshSettings) -> MeshedPart:
    """Return the part of a specification, meshed. Raises FileError where it cannot be."""
    part = read_part(spec)
    ports, laws = ports_of(part, spec), laws_of(part, spec)
    with blamed_on(spec.cad_place):
        return MeshedPart(spec, part, ports, laws, mesh_part(part, settings))
