"""The legend of the colours, as HTML: a bar with ticks and unit, and what the greys mean."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

import numpy as np
from numpy.typing import NDArray

from stiffkit.kinematics import Status
from stiffkit.plots import format_value, style
from stiffkit.plots.scale import Scale
from stiffkit.studio.looks import LOOKS, NO_ANSWER, WORST, Colour, css

Array = NDArray[np.float64]

_WIDTH = 265
_BAR = 12
_STOPS = 16
_APART = 0.13
"""Least distance between ticks, over the length of the bar."""


def colour_bar(scale: Scale, values: Array, unit: str) -> str:
    """Return the bar of a scale with round ticks; ``values`` are what is shown, in ``unit``."""
    from matplotlib import colormaps

    colours = colormaps[style.MAP_COLOURS](np.linspace(0.0, 1.0, _STOPS + 1), bytes=True)[:, :3]
    stops = "".join(
        f'<stop offset="{i / _STOPS:.4f}" stop-color="{css((int(r), int(g), int(b)))}"/>'
        for i, (r, g, b) in enumerate(colours)
    )
    ticks = _ticks(scale, values)
    marks = "".join(_tick(float(scale.norm(v)), format_value(float(v))) for v in ticks)
    return (
        f'<svg width="{_WIDTH}" height="36" role="img" aria-label="colour scale in {escape(unit)}">'
        f'<defs><linearGradient id="sk-scale">{stops}</linearGradient></defs>'
        f'<rect x="0" y="0" width="{_WIDTH}" height="{_BAR}" fill="url(#sk-scale)"/>'
        f"{marks}</svg>"
    )


def _ticks(scale: Scale, values: Array) -> Array:
    """Return round values on the scale whose texts do not touch; its limits if none is round."""
    if scale.is_constant:
        return np.array([scale.high])
    inside = scale.levels(values)
    inside = inside[(inside >= scale.low) & (inside <= scale.high)]
    kept: list[float] = []
    for value in inside:
        if not kept or scale.norm(value) - scale.norm(kept[-1]) > _APART:
            kept.append(float(value))
    return np.array(kept or [scale.low, scale.high])


def _tick(share: float, text: str) -> str:
    x = share * _WIDTH
    anchor = "start" if share < 0.06 else "end" if share > 0.94 else "middle"
    return (
        f'<line x1="{x:.1f}" y1="{_BAR}" x2="{x:.1f}" y2="{_BAR + 4}" stroke="#444"/>'
        f'<text x="{x:.1f}" y="{_BAR + 16}" font-size="11" text-anchor="{anchor}" fill="#222">'
        f"{escape(text)}</text>"
    )


def status_key(status: NDArray[np.integer]) -> str:
    """Return what the greys of a map mean and how many postures have them, as far as there are."""
    entries = []
    for kind, colour in NO_ANSWER.items():
        count = int(np.count_nonzero(status == kind))
        if count and kind is not Status.OUTSIDE:
            entries.append((colour, f"{kind.word}: {count:,} of {status.size:,} poses"))
    return _key(entries)


def parts_key(looks: Iterable[str]) -> str:
    """Return what the colours of the mechanism mean."""
    return _key([(LOOKS[look].colour, LOOKS[look].words) for look in LOOKS if look in set(looks)])


def worst_key(text: str) -> str:
    """Return the mark of the worst posture with its words."""
    return colour_key(WORST, text)


def colour_key(colour: Colour, text: str) -> str:
    """Return what one colour means."""
    return _key([(colour, text)])


def _key(entries: Iterable[tuple[Colour, str]]) -> str:
    return "".join(
        f'<p><span style="display:inline-block;width:10px;height:10px;margin-right:6px;'
        f'border:1px solid #777;background:{css(colour)}"></span>{escape(text)}</p>'
        for colour, text in entries
    )
