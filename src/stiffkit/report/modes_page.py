"""The modes of a posture as one animated page that needs nothing but a browser."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit import __version__
from stiffkit.errors import OutputError
from stiffkit.report.payload import json_text
from stiffkit.report.tables import bullet_list, pair_table
from stiffkit.report.template import Script, fill, page, write_text
from stiffkit.robot import DIRECTIONS
from stiffkit.study import ModesResult
from stiffkit.vibration import SHOWN, ModesDrawing
from stiffkit.vibration import Path as Line

Array = NDArray[np.float64]

_DIGITS = 6
"""Of lengths in metres: micrometres, far below what a screen shows."""

_ENERGIES = 8
"""Links and joints that are listed for each mode, at most."""


def write_modes_page(result: ModesResult, path: Path) -> None:
    """Write the modes of a posture as one self-contained animated page.

    The page makes no request to any other place. Raises OutputError if there is no mode to show, or
    if the page cannot be written.
    """
    if result.drawing is None:
        raise OutputError(
            f"{result.robot} has no mode to draw there",
            mend="look at what the command says without -o",
        )
    write_text(_page(result, result.drawing), path, "page")


def _page(result: ModesResult, drawing: ModesDrawing) -> str:
    main = fill(
        "modes.html",
        shown=f"{round(100 * SHOWN)}",
        free_motions=bullet_list(
            [*result.free_motions, *result.idle_motions],
            otherwise="None: with all drives held, nothing moves without deforming.",
        ),
        notes=bullet_list(result.notes, otherwise="None."),
        listed=_list(result),
        rules=pair_table(list(result.rules.items()), otherwise="None."),
    )
    data = json_text(_payload(result, drawing))
    return page(
        "modes of vibration",
        title=result.title or result.robot,
        scope=f"{result.model.capitalize()} model, tool at {_pose_words(result.tool)}.",
        version=__version__,
        styles=("modes.css",),
        main=main,
        made=[
            ("robot", result.robot),
            ("stiffkit version", __version__),
            ("model", result.model),
            ("elastic modes in all", str(result.n_existing)),
        ],
        script=Script("The mechanism on this page is", data, ("modes.js",)),
    )


def _list(result: ModesResult) -> str:
    """Return the modes as a table, for where nothing can be drawn."""
    rows = "".join(
        f'<tr><th scope="row">{k}</th><td>{mode.frequency_hz:.4g}</td>'
        f'<td class="words">{escape(mode.description)}</td></tr>'
        for k, mode in enumerate(result.modes, 1)
    )
    return (
        '<table class="figures"><thead><tr><th scope="col">mode</th>'
        '<th scope="col">frequency, Hz</th><th scope="col" class="words">what moves</th></tr>'
        f"</thead><tbody>{rows}</tbody></table>"
    )


def _pose_words(tool: Array) -> str:
    words = []
    for name, value in zip(DIRECTIONS, tool, strict=True):
        turns = name.startswith("r")
        shown = float(np.degrees(value)) if turns else 1e3 * float(value)
        if not turns or abs(shown) > 1e-6:
            words.append(f"{name} = {round(shown, 6) + 0.0:.6g} {'deg' if turns else 'mm'}")
    return ", ".join(words)


def _payload(result: ModesResult, drawing: ModesDrawing) -> dict[str, Any]:
    """Return what the page's script draws; lengths in metres."""
    lines = [
        _line(path, "elastic" if link.elastic else "rigid")
        for link in drawing.links
        for path in link.paths
    ]
    lines += [
        _line(joint.guide, "guide" if joint.grounded else "rigid")
        for joint in drawing.joints
        if joint.guide is not None
    ]
    return {
        "lines": lines,
        "joints": [
            {
                "at": _numbers(joint.position),
                "moved": _numbers(joint.moved),
                "driven": joint.driven,
                "grounded": joint.grounded,
            }
            for joint in drawing.joints
        ],
        "base": [_numbers(line) for line in drawing.base],
        "tool": {"at": _numbers(drawing.tool), "moved": _numbers(drawing.tool_moved)},
        "low": _numbers(drawing.low),
        "high": _numbers(drawing.high),
        "size": drawing.size,
        "shown": SHOWN,
        "modes": [
            {
                "frequency": f"{mode.frequency_hz:.4g}",
                "words": mode.description,
                "energy": list(mode.energy_shares.items())[:_ENERGIES],
                "view": "".join("xyz"[i] for i in drawing.plane(k) or ()) or "space",
            }
            for k, mode in enumerate(result.modes)
        ],
    }


def _line(path: Line, kind: str) -> dict[str, Any]:
    return {"kind": kind, "rest": _numbers(path.rest), "moved": _numbers(path.moved)}


def _numbers(values: Array) -> Any:
    return (np.round(values, _DIGITS) + 0.0).tolist()
