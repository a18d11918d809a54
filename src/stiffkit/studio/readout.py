"""What the studio tells beside the scene: the map's legend, numbers, and what it is doing."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffkit.plots import format_value, position_text
from stiffkit.studio import legend, numbers
from stiffkit.studio.looks import ROTATION, TRANSLATION
from stiffkit.studio.machine import Machine, Variant
from stiffkit.studio.mapped import Mapped
from stiffkit.studio.wish import LOADED, NOTHING, REST, Wish
from stiffkit.study import QUANTITIES, PoseResult

if TYPE_CHECKING:
    import viser

Array = NDArray[np.float64]

PINNED_HEADS = ("now", "pinned", "change")


class Readout:
    """The panel with legend and numbers."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Put the panel at the left edge."""
        self.panel = server.gui.add_panel()
        with self.panel.add_tab("Map and pose"):
            self._doing = server.gui.add_html("")
            self._legend = server.gui.add_html("")
            self._pose = server.gui.add_html("")
        with self.panel.add_tab("Compliance"):
            self._compliance = server.gui.add_html("")
        with self.panel.add_tab("Key"):
            self._key = server.gui.add_html("")
        self.panel.dock_left()
        self.panel.set_width(300)

    def say(self, text: str, *, is_bad: bool = False) -> None:
        """Tell what is being done, or what is wrong."""
        self._doing.content = numbers.page(numbers.paragraph(text, "bad" if is_bad else "dim"))

    def show_map(self, variant: Variant, shown: Mapped, wish: Wish) -> None:
        """Show the legend of the map, and its worst and middle value."""
        quantity = QUANTITIES[wish.quantity]
        of_load = f", load {wish.load}" if quantity.per_load else ""
        n_poses = np.count_nonzero(variant.inside)
        parts = [
            numbers.heading(f"{quantity.label} ({shown.unit.symbol})"),
            numbers.paragraph(f"{wish.model} model{of_load}, {n_poses:,} poses", "dim"),
        ]
        finite = shown.values[np.isfinite(shown.values)]
        if finite.size and wish.extent != NOTHING:
            parts.append(legend.colour_bar(shown.scale, finite, shown.unit.symbol))
        if shown.slice_at is not None:
            parts.append(numbers.paragraph(f"slice at {_place(wish.slice_axis, shown.slice_at)}"))
        if shown.worst is not None:
            number, value = shown.worst
            where = position_text(zip(variant.swept, variant.poses[:, number], strict=True))
            worst = f"worst {format_value(value)} {shown.unit.symbol} at {where}"
            median = f"median {format_value(shown.median)} {shown.unit.symbol}"
            parts += [legend.worst_key(worst), numbers.paragraph(median, "dim")]
        parts.append(legend.status_key(shown.status))
        self._legend.content = numbers.page(*parts)

    def hide_map(self) -> None:
        """Show no legend."""
        self._legend.content = ""

    def show_pose(
        self,
        results: Sequence[PoseResult],
        frequencies_hz: Sequence[Array],
        wish: Wish,
        magnification: float,
    ) -> None:
        """Show the numbers of the pose; a second result is that of the pinned variant."""
        heads = PINNED_HEADS[: 3 if len(results) > 1 else 0]
        now = results[0]
        parts = [numbers.paragraph(now.reason, "bad")] if now.reason else []
        if wish.load is not None:
            parts += [
                numbers.heading(f"Deflection at this pose, load {wish.load}"),
                numbers.table(numbers.deflection_rows(results, wish.load), heads),
            ]
        parts += [
            numbers.heading("Principal stiffness at this pose"),
            numbers.table(numbers.stiffness_rows(results), heads),
        ]
        if any(len(hz) for hz in frequencies_hz):
            parts += [
                numbers.heading("Lowest natural frequencies at this pose"),
                numbers.table(numbers.frequency_rows(frequencies_hz), heads),
            ]
        if wish.shape != REST:
            parts.append(numbers.paragraph(_told(wish.shape, magnification), "dim"))
        self._pose.content = numbers.page(*parts)
        self._compliance.content = numbers.page(
            numbers.heading(f"Compliance at the tool point, world axes, {wish.model} model"),
            numbers.paragraph("singular or out of reach", "bad")
            if now.compliance is None
            else numbers.compliance_table(now.compliance),
        )

    def show_key(self, machine: Machine, looks: Collection[str]) -> None:
        """Show what colours and keys mean."""
        self._key.content = numbers.page(
            numbers.heading(machine.robot.title),
            numbers.paragraph(f"robot {machine.robot.name}", "dim"),
            numbers.heading("Mechanism"),
            legend.parts_key(looks),
            numbers.heading("Ellipsoids of stiffness at the tool"),
            legend.colour_key(TRANSLATION, "translation: long axis is the stiffest direction"),
            legend.colour_key(ROTATION, "rotation: the same about the axes"),
            numbers.heading("Keys"),
            numbers.table(
                [
                    ("home pose", ["H"]),
                    ("to the worst pose shown", ["W"]),
                    ("next quantity", ["Q"]),
                    ("other model", ["M"]),
                    ("next shape", ["S"]),
                    ("play or stop", ["P"]),
                    ("all commands", ["Ctrl K"]),
                    ("fields and sliders", ["Tab, arrows"]),
                ]
            ),
        )


def _place(axis: str, at: float) -> str:
    return position_text([(axis, at)])


def _told(shape: str, magnification: float) -> str:
    what = "deflection" if shape == LOADED else "motion of the mode"
    if shape == LOADED and magnification == 1.0:
        return f"{what} drawn true to scale"
    if shape == LOADED:
        return f"{what} drawn {format_value(magnification)} times as large"
    return f"{what} drawn at any size; a mode has none of its own"
