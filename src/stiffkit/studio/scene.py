"""What is seen in space: the mechanism, how it bends, its stiffness, its workspace.

All lengths are in metres, world axes. Solids of one look are one mesh, so that whatever moves takes
a handful of messages.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffkit.plots import format_value
from stiffkit.studio.looks import LOADS, LOOKS, WORST, Colour, look_of
from stiffkit.studio.mapped import Mapped
from stiffkit.studio.mesh import Mesh
from stiffkit.studio.solid import Solid
from stiffkit.studio.variant import Variant
from stiffkit.studio.wish import NOTHING, Wish

if TYPE_CHECKING:
    import viser

Array = NDArray[np.float64]

_GHOST = 0.22
"""Opacity of what is there for comparison only."""
_FAINT = 0.4
_ELLIPSOID = 0.45
_FIELD_OF_VIEW = 0.7
"""rad, from the lower to the upper edge of the picture."""
_MARGIN = 1.1
"""Over which a robot fills the picture; a sphere around it would fill it at 1."""
_ARROW = 0.16
"""Length of a load's arrow, over the robot's size."""


class Scene:
    """The objects in the page's space, each kept up to date in place."""

    def __init__(self, server: viser.ViserServer, variant: Variant) -> None:
        """Take the robot that is looked at first; marks are drawn by its size."""
        self._server = server
        self.scene = server.scene
        self.size = size = variant.size
        self._meshes: dict[str, viser.MeshHandle] = {}
        self._cloud: viser.PointCloudHandle | None = None
        self._worst = self.scene.add_icosphere("/worst", 0.012 * size, color=WORST, visible=False)
        self._worst_text = self.scene.add_label("/worst/text", "", visible=False)
        self._arrow: viser.ArrowsHandle | None = None
        self._add_axes()

    def look_at(self, vertices: Sequence[Array], variant: Variant) -> None:
        """Let a page that opens see the whole mechanism and its workspace."""
        points = np.concatenate([*vertices, variant.points[variant.inside]])
        _look_at(self._server, points, is_plane=bool(np.ptp(variant.points[:, 2]) < 1e-9))

    def show_mechanism(
        self, solids: Sequence[Solid], vertices: Sequence[Array], *, is_faint: bool
    ) -> None:
        """Draw the mechanism: its solids and where their vertices (V, 3) are."""
        self._show("/robot", solids, vertices, opacity=_FAINT if is_faint else None)

    def show_rest(self, solids: Sequence[Solid], vertices: Sequence[Array]) -> None:
        """Draw the unloaded mechanism, faintly, behind one that is bent."""
        self._show("/rest", solids, vertices, opacity=_GHOST)

    def show_pinned(self, solids: Sequence[Solid], vertices: Sequence[Array]) -> None:
        """Draw the variant that was pinned, faintly."""
        self._show("/pinned", solids, vertices, opacity=_GHOST)

    def hide(self, what: str) -> None:
        """Take a mesh away, or all under a name such as ``/pinned``."""
        for name in [n for n in self._meshes if n == what or n.startswith(f"{what}/")]:
            self._meshes.pop(name).remove()

    def _show(
        self,
        under: str,
        solids: Sequence[Solid],
        vertices: Sequence[Array],
        *,
        opacity: float | None,
    ) -> None:
        for look, (points, faces) in _joined(solids, vertices):
            self._show_mesh(f"{under}/{look}", points, faces, LOOKS[look].colour, opacity)

    def _show_mesh(
        self,
        name: str,
        points: Array,
        faces: NDArray[np.intp],
        colour: Colour,
        opacity: float | None,
    ) -> None:
        known = self._meshes.get(name)
        if known is not None and np.array_equal(known.faces, faces):
            known.vertices = points.astype(np.float32)
            known.opacity = opacity
            return
        self._meshes[name] = self.scene.add_mesh_simple(
            name,
            points,
            faces,
            color=colour,
            opacity=opacity,
            flat_shading=True,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

    def show_ellipsoid(self, name: str, mesh: Mesh, at: Array, colour: Colour) -> None:
        """Draw an ellipsoid around the point ``at`` (3,)."""
        self._show_mesh(f"/ellipsoids/{name}", mesh.vertices + at, mesh.faces, colour, _ELLIPSOID)

    def show_map(self, variant: Variant, shown: Mapped, wish: Wish) -> None:
        """Draw the poses of a workspace in their colours, and mark the worst one."""
        is_seen = wish.extent != NOTHING and shown.which.size > 0
        if is_seen:
            self._show_cloud(variant.points[shown.which], shown.colours, shown.point_size)
        if self._cloud is not None:
            self._cloud.visible = is_seen
        marked = wish.extent != NOTHING and shown.worst is not None
        self._worst.visible = self._worst_text.visible = marked
        if shown.worst is not None:
            number, value = shown.worst
            self._worst.position = variant.points[number]
            self._worst_text.text = f"worst {format_value(value)} {shown.unit.symbol}"

    def hide_map(self) -> None:
        """Take the poses of the workspace and their worst one away."""
        self._worst.visible = self._worst_text.visible = False
        if self._cloud is not None:
            self._cloud.visible = False

    def _show_cloud(self, points: Array, colours: NDArray[np.uint8], point_size: float) -> None:
        cloud = self._cloud
        if cloud is None or len(cloud.points) != len(points):
            self._cloud = self.scene.add_point_cloud(
                "/workspace",
                points,
                colours,
                point_size=point_size,
                point_shape="square",
                point_shading="flat",
                precision="float32",
            )
            return
        cloud.colors = colours
        cloud.points = points.astype(np.float32)
        cloud.point_size = point_size

    def show_load(self, at: Array | None, force: Array | None = None) -> None:
        """Draw the direction of a force (3,) that acts at the point ``at`` (3,), or none."""
        strength = 0.0 if force is None else float(np.linalg.norm(force))
        if at is None or force is None or strength == 0.0:
            if self._arrow is not None:
                self._arrow.visible = False
            return
        ends = np.array([[at - _ARROW * self.size * force / strength, at]])
        if self._arrow is None:
            self._arrow = self.scene.add_arrows(
                "/load",
                ends,
                LOADS,
                shaft_radius=0.004 * self.size,
                head_radius=0.011 * self.size,
                head_length=0.03 * self.size,
            )
            return
        self._arrow.points = ends.astype(np.float32)
        self._arrow.visible = True

    def _add_axes(self) -> None:
        """Draw the world's axes with their names."""
        length = 0.12 * self.size
        self.scene.add_frame(
            "/axes", axes_length=length, axes_radius=0.02 * length, origin_radius=0.03 * length
        )
        for name, direction in zip("xyz", np.eye(3), strict=True):
            self.scene.add_label(f"/axes/{name}", name, position=1.12 * length * direction)


def _look_at(server: viser.ViserServer, points: Array, *, is_plane: bool) -> None:
    """Let a page that opens see all ``points`` (N, 3), those of a plane robot from its front."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, radius = 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low))
    direction = np.array([0.0, -0.45, 1.0] if is_plane else [0.8, -1.25, 0.7])
    camera = server.initial_camera
    camera.fov = _FIELD_OF_VIEW
    camera.up = (0.0, 1.0, 0.0) if is_plane else (0.0, 0.0, 1.0)
    camera.look_at = middle
    distance = _MARGIN * radius / np.sin(0.5 * _FIELD_OF_VIEW)
    camera.position = middle + distance * direction / np.linalg.norm(direction)


def _joined(
    solids: Sequence[Solid], vertices: Sequence[Array]
) -> Iterator[tuple[str, tuple[Array, NDArray[np.intp]]]]:
    """Yield vertices and faces of all solids of each look that there is."""
    looks = [look_of(solid) for solid in solids]
    for look in LOOKS:
        which = [i for i, own in enumerate(looks) if own == look]
        if not which:
            continue
        before = np.cumsum([0, *(len(vertices[i]) for i in which)])
        faces = [solids[i].faces + start for i, start in zip(which, before, strict=False)]
        yield look, (np.concatenate([vertices[i] for i in which]), np.concatenate(faces))
