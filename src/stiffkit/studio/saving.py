"""What the studio writes: into one folder, under new names, whole or not at all."""

from __future__ import annotations

import re
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stiffkit.design.robot_file import write_robot_file
from stiffkit.errors import OutputError
from stiffkit.files.write import write_bytes
from stiffkit.plots import style
from stiffkit.plots.scale import Scale, add_colour_bar
from stiffkit.progress import Progress
from stiffkit.robot import Robot
from stiffkit.study import Analysis

Array = NDArray[np.float64]

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,99}")


class Saver:
    """Writes into one folder, and nowhere else."""

    def __init__(self, folder: Path, source: str | Path) -> None:
        """Take the folder, and the robot file or catalogue name that is worked on.

        Raises OutputError if the folder is none.
        """
        self.folder = folder.resolve()
        self.source = source
        if not self.folder.is_dir():
            raise OutputError(f"{folder} is no folder", mend="make it, or choose another --folder")

    def robot_file(self, name: str, values: Mapping[str, float]) -> Path:
        """Write the robot file with values (SI) of parameters, and return where.

        Raises OutputError or FileError.
        """
        target = self._free(name, ".yaml")
        write_robot_file(self.source, values, target)
        return target

    def picture(self, name: str, image: NDArray[np.uint8], caption: str, bar: Bar | None) -> Path:
        """Write what is seen (H, W, 4) as PNG with its colour bar and a caption."""
        target = self._free(name, ".png")
        write_bytes(_png(image, caption, bar), target)
        return target

    def report(self, name: str, robot: Robot, progress: Progress) -> Path:
        """Write map, figures and report of a robot into a folder, and return the page.

        Raises OutputError, and PoseError for a workspace that cannot be swept.
        """
        from stiffkit.report import write_map

        target = self._free(f"{name}-report", "")
        write_map(Analysis(robot), target, progress=progress)
        return target / "report.html"

    def _free(self, name: str, suffix: str) -> Path:
        """Return a path in the folder that is not there yet: NAME, NAME-2, ..."""
        stem = name.strip().removesuffix(suffix) if suffix else name.strip()
        if not _NAME.fullmatch(stem):
            raise OutputError(
                f"'{name}' cannot be the name of a file here",
                mend="use letters, digits, '-', '_' and '.', no folders",
            )
        number = 1
        while True:
            path = self.folder / f"{stem}{'' if number == 1 else f'-{number}'}{suffix}"
            if not path.exists() and not path.is_symlink():
                return path
            number += 1


class Bar:
    """The colour bar of a picture."""

    def __init__(self, scale: Scale, label: str) -> None:
        """Take a scale of values in display units, and what they are, with the unit."""
        self.scale = scale
        self.label = label


def _png(image: NDArray[np.uint8], caption: str, bar: Bar | None) -> bytes:
    buffer = BytesIO()
    _figure(image, caption, bar).savefig(buffer, format="png", dpi=style.DPI)
    return buffer.getvalue()


@style.styled
def _figure(image: NDArray[np.uint8], caption: str, bar: Bar | None) -> Figure:
    """Return a picture with caption and colour bar."""
    from matplotlib.cm import ScalarMappable

    image = _without_margins(image)
    height, width = image.shape[:2]
    figure = style.new_figure(style.PAGE, style.PAGE * height / width * 0.85 + 0.4)
    axes = figure.add_subplot()
    axes.set_axis_off()
    axes.imshow(image, interpolation="antialiased")
    style.set_heading(figure, caption)
    if bar is not None:
        colours = ScalarMappable(norm=bar.scale.norm, cmap=style.MAP_COLOURS)
        add_colour_bar(figure, colours, axes, bar.scale, bar.label)
    return figure


def _without_margins(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the part of a picture (H, W, 4) that is not transparent, all of it if nothing is."""
    rows, columns = (np.flatnonzero(image[..., 3].any(axis=axis)) for axis in (1, 0))
    if not rows.size:
        return image
    return image[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
