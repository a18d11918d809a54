"""Figures of parts: numbered faces, meshes, deformed shapes, convergence of a solution."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stiffkit.fea import Part
from stiffkit.fea.cad_link import CadLink
from stiffkit.link.ports import BASE
from stiffkit.plots import style
from stiffkit.plots.scale import Scale, set_log_ticks

Array = NDArray[np.float64]

_VIEW = (24.0, -58.0)
"""Elevation and azimuth of the view, degrees."""

_LIGHT = np.array([0.35, -0.55, 0.76])

_DRAWN = 12_000
"""Triangles beyond which a picture shows no edges."""

_FILLS = 1.2
"""The zoom at which a part without axes fills its picture."""

_BULGE = 0.12
"""Size of the largest drawn displacement, over that of the part."""

_LOADS = ("force x", "force y", "force z", "moment x", "moment y", "moment z")


def write_face_figure(part: Part, stem: Path) -> list[Path]:
    """Write a picture of a part with the numbers of its faces, as ``stem``.svg and .png.

    Raises OutputError if they cannot be written.
    """
    return style.save(face_figure(part), stem)


def write_link_figures(link: CadLink, directory: Path) -> list[Path]:
    """Write mesh, deformed shapes and, where there is one, convergence, as SVG and PNG.

    Raises OutputError if a file cannot be written.
    """
    style.make_folder(directory)
    written = style.save(mesh_figure(link), directory / "mesh")
    written += style.save(shapes_figure(link), directory / "shapes")
    if len(link.solved.steps) > 1:
        written += style.save(convergence_figure(link), directory / "convergence")
    return written


@style.styled
def face_figure(part: Part) -> Figure:
    """Return a picture of a part from two sides, each face with its number at its middle."""
    figure = style.new_figure(style.PAGE, 0.55 * style.PAGE)
    towards = np.array([_direction(*view) for view in _views()])
    for i, view in enumerate(_views()):
        axes = _space(figure, 1, 2, i + 1, part.low, part.high, view)
        _add_triangles(axes, 1e3 * part.triangles, edges=False)
        for face in part.faces:
            # Faces that look the other way are numbered in the other picture.
            sides = towards @ face.normal
            if np.any(face.normal) and sides[i] < sides[1 - i]:
                continue
            own = part.triangles[part.triangle_face == face.index].mean(axis=1)
            middle = own[np.argmin(np.linalg.norm(own - face.centre, axis=1))]
            axes.text(*(1e3 * middle), str(face.index), fontsize=6.0, color="#b00020", zorder=1e6)
    return figure


@style.styled
def mesh_figure(link: CadLink) -> Figure:
    """Return a picture of the mesh's surface in link axes, with the ports."""
    surface = link.solved.surface
    figure = style.new_figure(style.COLUMN, 0.75 * style.COLUMN)
    low, high = surface.points.min(axis=0), surface.points.max(axis=0)
    axes = _space(figure, 1, 1, 1, low, high, _VIEW, zoom=_FILLS)
    axes.set_axis_off()
    size = " x ".join(f"{1e3 * length:.3g}" for length in high - low)
    style.set_title(axes, f"{size} mm along x, y and z of the link")
    edges = len(surface.triangles) <= _DRAWN
    _add_triangles(axes, 1e3 * surface.points[surface.triangles], edges=edges)
    places = {name: frame.position for name, frame in link.solved.ports.items()}
    for name, point in {BASE: np.zeros(3), **places}.items():
        axes.plot(*(1e3 * point[:, None]), "o", color="#b00020", zorder=1e6)
        axes.text(*(1e3 * point), f"  {name}", color="#b00020", zorder=1e6)
    return figure


@style.styled
def shapes_figure(link: CadLink) -> Figure:
    """Return the deformed shapes under the six loads at each port, each to a scale of its own."""
    surface = link.solved.surface
    names = list(link.solved.ports)
    figure = style.new_figure(style.PAGE, 0.5 * style.PAGE * len(names))
    span = float(np.linalg.norm(np.ptp(surface.points, axis=0)))
    size = np.linalg.norm(surface.displacements, axis=1)
    moved = [
        surface.points + _BULGE * span / max(float(size[:, k].max()), 1e-300) * d
        for k, d in enumerate(np.moveaxis(surface.displacements, 2, 0))
    ]
    low = np.min([points.min(axis=0) for points in moved], axis=0)
    high = np.max([points.max(axis=0) for points in moved], axis=0)
    for k, points in enumerate(moved):
        axes = _space(figure, 2 * len(names), 3, k + 1, low, high, _VIEW, zoom=_FILLS)
        axes.set_axis_off()
        share = size[surface.triangles, k].mean(axis=1) / max(float(size[:, k].max()), 1e-300)
        _add_triangles(axes, 1e3 * points[surface.triangles], edges=False, values=share)
        load, at = _LOADS[k % 6], f" at {names[k // 6]}" if len(names) > 1 else ""
        style.set_title(axes, f"{load}{at}")
    return figure


@style.styled
def convergence_figure(link: CadLink) -> Figure:
    """Return estimated error, and difference from the result, over unknowns by mesh."""
    steps = link.solved.steps
    figure = style.new_figure(style.COLUMN, 0.75 * style.COLUMN)
    axes = figure.add_subplot()
    for mesh in range(1, steps[-1].mesh + 1):
        own = [step for step in steps if step.mesh == mesh]
        estimates = [(step.unknowns, step.estimate) for step in own if step.estimate]
        changes = [(step.unknowns, step.change) for step in own if step.change > 0.0]
        _add_line(axes, estimates, "estimated error" if mesh == 1 else "", "refined")
        _add_line(axes, changes, "difference from the result" if mesh == 1 else "", "simplified")
    tolerance = link.solved.facts["tolerance"]
    if tolerance is not None:
        axes.axhline(100.0 * tolerance, color=style.INK, linewidth=0.8, linestyle=":")
    axes.set_xscale("log")
    axes.set_yscale("log")
    set_log_ticks(axes.xaxis, Scale(*axes.get_xlim(), is_log=True))
    set_log_ticks(axes.yaxis, Scale(*axes.get_ylim(), is_log=True))
    axes.set_xlabel("unknowns")
    axes.set_ylabel("relative error of the compliance, %")
    axes.grid(visible=True)
    axes.legend()
    return figure


def _add_line(axes: Any, points: Sequence[tuple[int, float]], label: str, style_of: str) -> None:
    """Draw shares as per cents over numbers; a label that is empty is left out."""
    x, y = [n for n, _ in points], [100.0 * share for _, share in points]
    axes.plot(x, y, label=label or "_", **style.LINES[style_of])


def _views() -> tuple[tuple[float, float], tuple[float, float]]:
    elevation, azimuth = _VIEW
    return _VIEW, (-elevation, azimuth + 180.0)


def _direction(elevation: float, azimuth: float) -> Array:
    """Return the unit vector (3,) from what is seen to the eye."""
    e, a = np.radians([elevation, azimuth])
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def _space(
    figure: Figure,
    rows: int,
    columns: int,
    number: int,
    low: Array,
    high: Array,
    view: tuple[float, float],
    *,
    zoom: float = 0.85,
) -> Any:
    """Return axes in space that hold a box (m), lengths alike along all of them, in mm."""
    axes: Any = figure.add_subplot(rows, columns, number, projection="3d")
    span = 1e3 * np.maximum(high - low, 0.05 * float((high - low).max()))
    middle = 5e2 * (low + high)
    for axis, m, s in zip("xyz", middle, span, strict=True):
        getattr(axes, f"set_{axis}lim")(m - 0.5 * s, m + 0.5 * s)
        getattr(axes, f"set_{axis}label")(f"{axis}, mm")
        getattr(axes, f"{axis}axis").set_major_locator(_few_ticks())
    axes.set_box_aspect(tuple(span), zoom=zoom)
    axes.view_init(*view)
    return axes


def _few_ticks() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(3)


def _add_triangles(
    axes: Any, triangles: Array, *, edges: bool, values: Array | None = None
) -> None:
    """Draw triangles (t, 3, 3), shaded; coloured by values (t,) from 0 to 1 where given."""
    from matplotlib import colormaps
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / np.where(lengths > 0.0, lengths, 1.0)
    light = 0.65 + 0.35 * np.abs(normals @ _LIGHT)
    base: Array = np.tile([0.80, 0.84, 0.88], (len(triangles), 1))
    if values is not None:
        base = np.asarray(colormaps[style.MAP_COLOURS](values))[:, :3]
    colours = np.clip(base * light[:, None], 0.0, 1.0)
    faces = Poly3DCollection(
        triangles,
        facecolors=colours,
        edgecolors="#5c6670" if edges else colours,
        linewidths=0.15,
        rasterized=True,
    )
    # Axes in space are square, and parts are longer than that.
    faces.set_clip_on(False)
    axes.add_collection3d(faces)
