"""One look for every figure: sizes of a paper's column, fonts, colours, deterministic files.

Colours are told apart by colour-blind readers and in grey: viridis and cividis for maps, the
palette of Okabe and Ito with different line styles for curves.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from stiffkit.errors import OutputError

MM = 1.0 / 25.4
"""Inches in a millimetre, for Matplotlib's sizes."""
COLUMN = 85.0 * MM
"""Width of a figure over one column of a paper, inches."""
PAGE = 175.0 * MM
"""Width of a figure over both columns, inches."""
DPI = 300

MAP_COLOURS = "viridis"
RATIO_COLOURS = "cividis"
INK = "#222222"
UNREACHABLE_FACE = "#ececec"
UNREACHABLE_HATCH = "#b4b4b4"
SINGULAR = "#5a5a5a"
UNCONTROLLED = "#9a9a9a"

LINES: Mapping[str, Mapping[str, Any]] = {
    "refined": {"color": "#0072b2", "linestyle": "-", "marker": "o"},
    "simplified": {"color": "#d55e00", "linestyle": (0, (4, 2)), "marker": "s"},
}
"""Okabe and Ito's blue and vermilion, one line style and marker each."""

BRANCHES: tuple[Mapping[str, Any], ...] = (
    {"color": "#222222", "linestyle": "-", "marker": "o"},
    {"color": "#d55e00", "linestyle": (0, (6, 2)), "marker": "s"},
    {"color": "#0072b2", "linestyle": (0, (6, 1.5, 1.2, 1.5)), "marker": "^"},
    {"color": "#56b4e9", "linestyle": (0, (1.5, 1.2)), "marker": "D"},
)
"""Ink and Okabe and Ito's vermilion, blue and sky blue, for modes that cross."""

_RC: dict[Any, Any] = {
    # Carried by Matplotlib itself, so that every machine lays a figure out alike.
    "font.family": ["DejaVu Sans"],
    "font.size": 7.5,
    "axes.titlesize": 7.5,
    "axes.labelsize": 7.5,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "legend.fontsize": 7.0,
    "figure.titlesize": 8.5,
    "axes.titlelocation": "left",
    "axes.titlepad": 4.0,
    "axes.labelpad": 2.5,
    "axes.linewidth": 0.6,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.minor.size": 0.0,
    "ytick.minor.size": 0.0,
    "lines.linewidth": 1.3,
    "lines.markersize": 3.0,
    "hatch.linewidth": 0.4,
    "legend.frameon": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.5,
    "axes.unicode_minus": True,
    "figure.constrained_layout.h_pad": 0.03,
    "figure.constrained_layout.w_pad": 0.03,
    "svg.fonttype": "none",
    "svg.hashsalt": "stiffkit",
}

_P = ParamSpec("_P")


def styled(draw: Callable[_P, Figure]) -> Callable[_P, Figure]:
    """Make ``draw`` return a figure in the one look, whatever the user's Matplotlib says."""

    @wraps(draw)
    def in_style(*args: _P.args, **kwargs: _P.kwargs) -> Figure:
        with _look():
            return draw(*args, **kwargs)

    return in_style


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of ``width`` x ``height`` inches that no window shows."""
    figure = Figure(figsize=(width, height), layout="compressed", dpi=DPI)
    FigureCanvasAgg(figure)
    return figure


def set_heading(figure: Figure, text: str) -> None:
    """Put a title over the whole ``figure``, in plain text."""
    figure.suptitle(text, x=0.01, ha="left", parse_math=False)


def set_title(axes: Axes, text: str) -> None:
    """Put a title over ``axes``; names of loads are plain text, never formulas."""
    axes.set_title(text, parse_math=False)


def make_folder(directory: Path) -> None:
    """Make a folder for figures if it is not there. Raises OutputError if that fails."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            f"cannot make the folder {directory}: {error.strerror or error}",
            mend="give a folder that you may write to",
        ) from error


def save(figure: Figure, stem: Path) -> list[Path]:
    """Write ``stem``.svg and ``stem``.png (300 dpi), the same bytes on every run.

    Raises:
        OutputError: if the files cannot be written.
    """
    svg, png = stem.with_name(stem.name + ".svg"), stem.with_name(stem.name + ".png")
    try:
        with _look():
            # Arranged once: it takes longer than drawing, and every file would do it anew.
            engine = figure.get_layout_engine()
            if engine is not None:
                engine.execute(figure)
            figure.set_layout_engine("none")
            figure.savefig(svg, metadata={"Date": None, "Creator": "stiffkit"})
            figure.savefig(png, dpi=DPI, metadata={"Software": "stiffkit"})
    except OSError as error:
        raise OutputError(
            f"cannot write the figure {stem}: {error.strerror or error}",
            mend="give a folder that you may write to, with room left on the disk",
        ) from error
    return [svg, png]


@contextmanager
def _look() -> Iterator[None]:
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_RC)
        yield
