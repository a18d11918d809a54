"""Stills of mode shapes for papers: the mechanism at rest in grey, and as a mode bends it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path as FilePath
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from stiffkit.plots import style
from stiffkit.vibration import JointDrawing, ModesDrawing, Path

Array = NDArray[np.float64]

_REST: dict[str, Any] = {"color": "#a9aeb4", "linewidth": 1.0, "solid_capstyle": "round"}
_ELASTIC: dict[str, Any] = {"color": style.LINES["refined"]["color"], "linewidth": 2.0}
_RIGID: dict[str, Any] = {"color": style.INK, "linewidth": 1.4}
_GUIDE: dict[str, Any] = {"color": "#c9ced3", "linewidth": 0.8, "linestyle": (0, (1, 1.5))}
_DRIVE = style.LINES["simplified"]["color"]

_OBLIQUE = (24.0, -58.0)
"""Elevation and azimuth of the view in space, degrees."""


def write_mode_figures(
    drawing: ModesDrawing, frequencies_hz: Array, descriptions: list[str], directory: FilePath
) -> list[FilePath]:
    """Write a still of each mode as SVG and PNG: ``mode-1.svg`` and so on.

    Raises OutputError if a file cannot be written.
    """
    style.make_folder(directory)
    written: list[FilePath] = []
    for i, (frequency, words) in enumerate(zip(frequencies_hz, descriptions, strict=True)):
        figure = mode_figure(drawing, i, float(frequency), words)
        written += style.save(figure, directory / f"mode-{i + 1}")
    return written


@style.styled
def mode_figure(drawing: ModesDrawing, mode: int, frequency_hz: float, description: str) -> Figure:
    """Return the still of one mode, counted from 0: at rest in grey, and at one of its extremes."""
    figure = style.new_figure(style.COLUMN, style.COLUMN * 0.95)
    plane = drawing.plane(mode)
    if plane is None:
        _draw_in_space(figure, drawing, mode)
    else:
        _draw_in_plane(figure, drawing, mode, plane)
    words = fill(description, 50)
    style.set_heading(figure, f"Mode {mode + 1}, {frequency_hz:.4g} Hz\n{words}")
    handles = _handles(drawing)
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=len(handles) if len(handles) < 5 else 3,
        handlelength=1.5,
        handletextpad=0.5,
        columnspacing=1.2,
        borderaxespad=0.2,
    )
    return figure


def _lines(drawing: ModesDrawing) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Yield each line with the look of its bent state."""
    for link in drawing.links:
        for path in link.paths:
            yield path, _ELASTIC if link.elastic else _RIGID
    for joint in drawing.joints:
        if joint.guide is not None:
            yield joint.guide, _GUIDE if joint.grounded else _RIGID


def _draw_in_plane(
    figure: Figure, drawing: ModesDrawing, mode: int, plane: tuple[int, int]
) -> None:
    axes = figure.add_subplot()
    select = list(plane)
    for line in drawing.base:
        axes.plot(*(1e3 * line[:, select].T), **_GUIDE, zorder=1)
    for path, look in _lines(drawing):
        rest = 1e3 * path.rest[:, select]
        bent = rest + 1e3 * path.moved[mode][:, select]
        axes.plot(*rest.T, **(_GUIDE if look is _GUIDE else _REST), zorder=1)
        axes.plot(*bent.T, **look, zorder=2 if look is _GUIDE else 3)
    for joint in drawing.joints:
        bent = joint.position + joint.moved[mode]
        _mark(axes, 1e3 * bent[select], joint)
    tool = 1e3 * (drawing.tool + drawing.tool_moved[mode])[select]
    axes.plot(*tool, **_TOOL, zorder=5)
    names = "xyz"
    axes.set_xlabel(f"{names[plane[0]]} (mm)")
    axes.set_ylabel(f"{names[plane[1]]} (mm)")
    axes.set_aspect("equal")
    axes.margins(0.08)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


_TOOL: dict[str, Any] = {"marker": "*", "markersize": 8.0, "color": style.INK, "linestyle": ""}


def _mark(axes: Axes, at: Array, joint: JointDrawing) -> None:
    axes.plot(
        *at[:, None],
        **_joint_look(joint.driven, joint.grounded),
        zorder=4,
        clip_on=False,
        in_layout=False,
    )


def _joint_look(driven: bool, grounded: bool) -> dict[str, Any]:
    return {
        "marker": "s" if grounded else "o",
        "markersize": 4.0 if driven or grounded else 3.2,
        "markerfacecolor": _DRIVE if driven else "white",
        "markeredgecolor": _DRIVE if driven else style.INK,
        "markeredgewidth": 0.7,
        "linestyle": "",
    }


def _draw_in_space(figure: Figure, drawing: ModesDrawing, mode: int) -> None:
    axes: Any = figure.add_subplot(projection="3d", computed_zorder=False)
    axes.view_init(*_OBLIQUE)
    axes.set_proj_type("ortho")
    corners = [drawing.low, drawing.high]
    for line in drawing.base:
        axes.plot(*(1e3 * line.T), **_GUIDE, zorder=1, clip_on=False, in_layout=False)
    for path, look in _lines(drawing):
        rest = 1e3 * path.rest
        bent = rest + 1e3 * path.moved[mode]
        corners.append(bent.min(axis=0) / 1e3)
        corners.append(bent.max(axis=0) / 1e3)
        axes.plot(
            *rest.T,
            **(_GUIDE if look is _GUIDE else _REST),
            zorder=1,
            clip_on=False,
            in_layout=False,
        )
        axes.plot(
            *bent.T, **look, zorder=2 if look is _GUIDE else 3, clip_on=False, in_layout=False
        )
    for joint in drawing.joints:
        bent = joint.position + joint.moved[mode]
        _mark(axes, 1e3 * bent, joint)
    tool = 1e3 * (drawing.tool + drawing.tool_moved[mode])
    axes.plot(*([x] for x in tool), **_TOOL, zorder=5, clip_on=False, in_layout=False)
    _equal_box(axes, 1e3 * np.array(corners))


def _equal_box(axes: Any, corners: Array) -> None:
    """Give the axes one scale, and panes that stay in the background."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    spans = np.maximum(high - low, 0.25 * (high - low).max())
    middle = (low + high) / 2.0
    for name, m, span in zip("xyz", middle, spans, strict=True):
        getattr(axes, f"set_{name}lim")(m - 0.55 * span, m + 0.55 * span)
        axis = getattr(axes, f"{name}axis")
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.line.set_color("#b9bfc6")
        axis.set_tick_params(pad=-1.0)
        axis.set_major_locator(_few(span / spans.max()))
    # A low box leaves room above and below, a high one does not.
    axes.set_box_aspect(tuple(spans), zoom=1.05 if spans[2] < 0.6 * spans.max() else 0.92)
    axes.grid(visible=True)
    axes.set_xlabel("x (mm)")
    axes.set_ylabel("y (mm)")
    # Matplotlib puts the label of a low z axis far outside the figure.
    top = [getattr(axes, f"get_{name}lim")()[1] for name in "xyz"]
    axes.text(top[0], top[1], top[2] + 0.1 * spans.max(), "z (mm)", ha="center", in_layout=False)


def _few(share: float) -> MaxNLocator:
    return MaxNLocator(nbins=max(2, round(5 * share)))


def _handles(drawing: ModesDrawing) -> list[Line2D]:
    handles = [Line2D([], [], **_REST, label="at rest")]
    kinds = {link.elastic for link in drawing.links if link.paths}
    if True in kinds:
        handles.append(Line2D([], [], **_ELASTIC, label="elastic link"))
    if False in kinds:
        handles.append(Line2D([], [], **_RIGID, label="rigid link"))
    if any(joint.driven for joint in drawing.joints):
        handles.append(Line2D([], [], **_joint_look(True, True), label="drive"))
    handles.append(Line2D([], [], **_TOOL, label="tool"))
    return handles
