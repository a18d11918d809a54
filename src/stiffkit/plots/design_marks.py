"""How designs look in every figure: the start, the chosen ones, fronts, and all the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from stiffkit.plots import style
from stiffkit.plots.designs import START, Designs, Parameter, Result

Array = NDArray[np.float64]

FEASIBLE = "#8c8c8c"
INFEASIBLE = "#d4d4d4"

START_LOOK: Mapping[str, Any] = {
    "marker": "X",
    "color": style.INK,
    "markersize": 7.0,
    "markeredgecolor": "white",
    "markeredgewidth": 0.6,
}
_CHOSEN_MARKERS = {"refined": ("*", 11.0), "simplified": ("D", 6.0)}

NO_BREAK = "\N{NO-BREAK SPACE}"
"""A blank that drawings do not swallow."""

ROOM = 0.25
"""How far beyond fronts, start and chosen designs axes go, over the span of these."""


def colour_of(model: str) -> str:
    """Return the colour of a model."""
    return str(look_of(model)["color"])


def look_of(model: str) -> Mapping[str, Any]:
    """Return colour, line style and marker of a model."""
    return style.LINES.get(model, style.LINES["refined"])


def line_look(model: str) -> dict[str, Any]:
    """Return colour and line style of a model, without a marker."""
    return {key: value for key, value in look_of(model).items() if key != "marker"}


def dots_look(model: str) -> dict[str, Any]:
    """Return how designs of a model are marked, without a line."""
    return {**look_of(model), "linestyle": ""}


def hollow_look(model: str) -> dict[str, Any]:
    """Return how designs of a model are marked where another one judges them."""
    return {**dots_look(model), "markerfacecolor": "white", "markeredgewidth": 0.8}


def chosen_look(model: str) -> dict[str, Any]:
    """Return how the chosen design of a model is marked."""
    marker, size = _CHOSEN_MARKERS.get(model, _CHOSEN_MARKERS["refined"])
    return {
        "marker": marker,
        "color": colour_of(model),
        "markersize": size,
        "markeredgecolor": style.INK,
        "markeredgewidth": 0.7,
    }


def other_look(model: str) -> dict[str, Any]:
    """Return how the chosen design of a model is marked where another one judges it."""
    look = chosen_look(model)
    return {**look, "markerfacecolor": "white", "markeredgecolor": look["color"]}


def draw_marks(axes: Axes, designs: Designs, x: Array, y: Array) -> None:
    """Mark the start and the chosen designs at their coordinates (n_designs,)."""
    for model, design in reversed(list(designs.chosen.items())):
        axes.plot(x[design], y[design], linestyle="", zorder=6, **chosen_look(model))
    axes.plot(x[START], y[START], linestyle="", zorder=5, **START_LOOK)


def mark_handles(designs: Designs) -> list[Artist]:
    """Return the legend entries of the start and the chosen designs."""
    handles: list[Artist] = [Line2D([], [], linestyle="", label="start", **START_LOOK)]
    handles += [
        Line2D(
            [], [], linestyle="", label=of_model(designs, "chosen by", model), **chosen_look(model)
        )
        for model in designs.chosen
    ]
    return handles


def of_model(designs: Designs, what: str, model: str) -> str:
    """Return a legend's text: "front of the refined model", or "front" where it is the only one."""
    return f"{what} the {model} model" if len(designs.models) > 1 else what.split()[0]


def dot_handle(colour: str, label: str) -> Artist:
    """Return the legend entry of a kind of design that is drawn as dots."""
    return Line2D([], [], linestyle="", marker="o", markersize=3.0, color=colour, label=label)


def better_label(result: Result) -> str:
    """Return the label of an axis, with an arrow that tells where it is better.

    Along a vertical axis, which is read from below, the arrow turns with the text.
    """
    gap = 3 * NO_BREAK
    return f"← better{gap}{result.label}" if result.sign > 0 else f"{result.label}{gap}better →"


def limits_of(designs: Designs, column: Result | Parameter, models: Sequence[str]) -> Array:
    """Return the limits of an axis, in display units, that show what matters.

    What matters are fronts, start and chosen designs, by the numbers of ``models``; other feasible
    designs are shown as far as they are not far away. Without any front all designs matter.
    """
    fronts = np.flatnonzero(np.any([*designs.front.values()], axis=0))
    matter = np.array([START, *designs.chosen.values(), *fronts], dtype=np.intp)
    if not fronts.size:
        matter = np.arange(designs.count)
    core = _known([values_by(column, model)[matter] for model in models])
    if not core.size:
        return np.array([0.0, 1.0])
    rest = _known([values_by(column, model)[designs.feasible[model]] for model in models])
    low, high = core.min(), core.max()
    span = float(high - low) or 0.2 * abs(float(high)) or 1.0
    low = max(low - ROOM * span, np.min(rest, initial=low))
    high = min(high + ROOM * span, np.max(rest, initial=high))
    margin = 0.06 * (float(high - low) or span)
    return column.unit.of([low - margin, high + margin])


def values_by(column: Result | Parameter, model: str) -> Array:
    """Return the values (n_designs,), SI, that a model gives; a parameter's are its own."""
    return column.values[model] if isinstance(column, Result) else column.values


def _known(parts: Sequence[Array]) -> Array:
    values = np.concatenate(parts)
    known: Array = values[np.isfinite(values)]
    return known
