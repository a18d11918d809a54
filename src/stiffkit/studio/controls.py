"""What can be set on the page: pose, parameters, what is shown, and what is saved."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stiffkit.plots import DisplayUnit, Kind, display_unit
from stiffkit.studio.looks import BRAND
from stiffkit.studio.machine import Machine, Slider
from stiffkit.studio.numbers import page, paragraph
from stiffkit.studio.sliders import dimension_of
from stiffkit.studio.wish import ALL, EXTENTS, LOADED, REST, SLICE, Wish
from stiffkit.study import QUANTITIES
from stiffkit.units import LENGTH, STIFFNESS_ROTATION, STIFFNESS_TRANSLATION, parse_quantity

if TYPE_CHECKING:
    import viser

_MODES = 4
_WIDTH = 300
"""Of the panel, pixels."""
_HANDY = (1e-2, 1e5)
"""Sizes of numbers that are easily read."""
_SLACK = 1e-9
_KINDS = {
    STIFFNESS_TRANSLATION.dims: Kind.STIFFNESS,
    STIFFNESS_ROTATION.dims: Kind.ROTATIONAL_STIFFNESS,
    LENGTH.dims: Kind.DEFLECTION,
}
_MAGNIFICATIONS = {"true to scale": 0.0, "enlarged": 1.0, "enlarged 3 times more": 3.0}


@dataclass(frozen=True)
class Actions:
    """What the buttons do."""

    wish_changed: Callable[[], None]
    go_home: Callable[[], None]
    go_to_worst: Callable[[], None]
    pin: Callable[[], None]
    unpin: Callable[[], None]
    save_robot: Callable[[Any], None]
    save_picture: Callable[[Any], None]
    save_report: Callable[[Any], None]


class Controls:
    """The panel with everything that can be set."""

    def __init__(self, server: viser.ViserServer, machine: Machine, actions: Actions) -> None:
        """Build the panel for a robot's parameters, loads and coordinates."""
        self.gui = server.gui
        self.machine = machine
        self.actions = actions
        self._pose: dict[str, Any] = {}
        self._sliders: dict[str, Any] = {}
        self._units = {name: _unit_of(own) for name, own in machine.parameters.items()}
        self.pose = dict(machine.home)
        self.gui.configure_theme(show_logo=False, show_share_button=False, brand_color=BRAND)
        self.gui.set_panel_label(f"stiffkit studio: {machine.robot.name}")
        self.gui.main_panel.dock_right()
        self.gui.main_panel.set_width(_WIDTH)
        tabs = self.gui.add_tab_group()
        with tabs.add_tab("Robot"):
            self._add_tool()
            self._add_parameters()
        with tabs.add_tab("Show"):
            self._add_map()
            self._add_shape()
        with tabs.add_tab("Save"):
            self._add_saving()
        self._add_hotkeys()

    def wish(self) -> Wish:
        """Return what is set now."""
        return Wish(
            values=self._values(),
            pose=dict(self.pose),
            load=self._load.value if self.machine.loads else None,
            model="simplified" if self._model.value == "simplified" else "refined",
            quantity=self._quantities[self._quantity.value],
            extent=self._extent.value,
            slice_axis=self._axis.value,
            slice_share=self._share.value,
            holds_scale=self._holds.value,
            shape=_shape_of(self._shape.value),
            magnification=_MAGNIFICATIONS[self._magnification.value],
            is_playing=self._plays.value,
            is_faint=self._faint.value,
            ellipsoids=frozenset(n for n, box in self._ellipsoids.items() if box.value),
        )

    def show_pose(self, pose: Mapping[str, float]) -> None:
        """Write tool coordinates (m, rad) into the panel."""
        self.pose = {**self.pose, **pose}
        for name, field in self._pose.items():
            field.value = round(_pose_unit(name).of(self.pose[name]).item(), 3)

    def show_values(self, values: Mapping[str, float]) -> None:
        """Put the sliders at values (SI) of parameters; others at the file's own."""
        for name, slider in self._sliders.items():
            own = self.machine.parameters[name]
            slider.value = _shown(self._units[name], values.get(name, own.value))

    @property
    def name(self) -> str:
        """What is saved is to be called."""
        return str(self._name.value)

    def tell_saved(self, text: str) -> None:
        """Tell what has been saved, or why not."""
        self._saved.content = page(paragraph(text))

    # --- the robot --------------------------------------------------------------------------------

    def _add_tool(self) -> None:
        with self.gui.add_folder("Tool pose"):
            for name in self.machine.asked:
                unit = _pose_unit(name)
                field = self.gui.add_number(
                    unit.label(name),
                    round(unit.of(self.pose[name]).item(), 3),
                    step=1.0,
                    hint="drag the arrows at the tool, or type",
                )
                field.on_update(self._typed(name, field, unit.size))
                self._pose[name] = field
            self._buttons(
                "go to", {"home": self.actions.go_home, "worst pose": self.actions.go_to_worst}
            )

    def _typed(self, name: str, field: Any, unit_size: float) -> Callable[[Any], None]:
        def changed(event: Any) -> None:
            if event.client_id is not None and math.isfinite(field.value):
                self.pose[name] = float(field.value) * unit_size
                self.actions.wish_changed()

        return changed

    def _add_parameters(self) -> None:
        live = [own for own in self.machine.parameters.values() if own.live]
        slow = [own for own in self.machine.parameters.values() if not own.live]
        with self.gui.add_folder("Parameters"):
            for own in live:
                unit = self._units[own.name]
                low, high = _ends(own, unit)
                slider = self.gui.add_slider(
                    unit.label(own.name), low, high, _shown(unit, own.step), _shown(unit, own.value)
                )
                self._keep_slider(own, slider)
            for own in slow:
                unit = self._units[own.name]
                field = self.gui.add_number(
                    unit.label(own.name),
                    _shown(unit, own.value),
                    hint="parts from CAD are solved anew for each value, which takes its time",
                )
                self._keep_slider(own, field)
            if not live and not slow:
                self.gui.add_html(page(paragraph("The robot file has no parameters.", "dim")))
            self._buttons("set", {"as in the file": self._reset})
            self._buttons("compare", {"pin": self.actions.pin, "unpin": self.actions.unpin})

    def _keep_slider(self, own: Slider, handle: Any) -> None:
        handle.on_update(self._changed)
        self._sliders[own.name] = handle

    def _reset(self) -> None:
        self.show_values({})
        self.actions.wish_changed()

    def _values(self) -> dict[str, float]:
        values = {}
        for name, slider in self._sliders.items():
            own = self.machine.parameters[name]
            unit = self._units[name]
            if slider.value != _shown(unit, own.value):
                values[name] = float(slider.value) * unit.size
        return values

    # --- what is shown ----------------------------------------------------------------------------

    def _add_map(self) -> None:
        machine = self.machine
        self._quantities = {QUANTITIES[name].label: name for name in machine.quantities}
        with self.gui.add_folder("Workspace"):
            self._quantity = self._dropdown("quantity", tuple(self._quantities))
            self._load = self._dropdown("load", tuple(machine.loads) or ("none",))
            self._model = self._dropdown("model", ("refined", "simplified"))
            self._extent = self._dropdown("shown", EXTENTS)
            # Through a volume full of points one cannot see the mechanism.
            self._extent.value = SLICE if len(machine.swept) > 2 and machine.is_grid else ALL
            self._axis = self._dropdown("slice across", tuple(machine.swept))
            self._share = self.gui.add_slider("slice at", 0.0, 1.0, 0.01, 0.5)
            self._share.on_update(self._changed)
            self._holds = self._checkbox("hold the colour scale")

    def _add_shape(self) -> None:
        modes = tuple(f"mode {i + 1}" for i in range(_MODES)) if self.machine.vibrates else ()
        with self.gui.add_folder("Mechanism"):
            loaded = (LOADED,) if self.machine.loads else ()
            self._shape = self._dropdown("shape", (REST, *loaded, *modes))
            self._magnification = self._dropdown(
                "displacements", ("enlarged", *(n for n in _MAGNIFICATIONS if n != "enlarged"))
            )
            self._plays = self._checkbox("play the motion")
            self._faint = self._checkbox("see through it")
            self._ellipsoids = {
                "translation": self._checkbox("ellipsoid of translation"),
                "rotation": self._checkbox("ellipsoid of rotation"),
            }

    # --- saving -----------------------------------------------------------------------------------

    def _add_saving(self) -> None:
        self._name = self.gui.add_text("name", f"{self.machine.robot.name}-studio")
        for label, action in (
            ("Robot file", self.actions.save_robot),
            ("Picture of the scene", self.actions.save_picture),
            ("Report on the whole workspace", self.actions.save_report),
        ):
            self.gui.add_button(label).on_click(_with_client(action))
        self._saved = self.gui.add_html("")

    # --- keys -------------------------------------------------------------------------------------

    def _add_hotkeys(self) -> None:
        shortcuts: tuple[tuple[str, Any, Callable[[], None]], ...] = (
            ("Home pose", "H", self.actions.go_home),
            ("To the worst pose shown", "W", self.actions.go_to_worst),
            ("Next quantity", "Q", lambda: self._next(self._quantity)),
            ("Next shape of the mechanism", "S", lambda: self._next(self._shape)),
            ("Play or stop the motion", "P", self._toggle_play),
            ("Other model", "M", lambda: self._next(self._model)),
        )
        for label, key, action in shortcuts:
            command = self.gui.add_command(label, hotkey=key)
            command.on_trigger(_without_event(action))

    def _next(self, dropdown: Any) -> None:
        options = dropdown.options
        dropdown.value = options[(options.index(dropdown.value) + 1) % len(options)]
        self.actions.wish_changed()

    def _toggle_play(self) -> None:
        self._plays.value = not self._plays.value
        self.actions.wish_changed()

    # --- pieces -----------------------------------------------------------------------------------

    def _changed(self, event: Any) -> None:
        # What is set from here has been taken into account by whoever set it.
        if event.client_id is not None:
            self.actions.wish_changed()

    def _dropdown(self, label: str, options: tuple[str, ...]) -> Any:
        handle = self.gui.add_dropdown(label, options)
        handle.on_update(self._changed)
        return handle

    def _checkbox(self, label: str) -> Any:
        handle = self.gui.add_checkbox(label, False)
        handle.on_update(self._changed)
        return handle

    def _buttons(self, label: str, actions: Mapping[str, Callable[[], None]]) -> None:
        group = self.gui.add_button_group(label, tuple(actions))
        group.on_click(lambda event: actions[event.target.value]())


def _with_client(action: Callable[[Any], None]) -> Callable[[Any], None]:
    return lambda event: action(event.client)


def _without_event(action: Callable[[], None]) -> Callable[[Any], None]:
    return lambda _: action()


def _shape_of(chosen: str) -> str:
    return chosen.removeprefix("mode ")


def _pose_unit(name: str) -> Any:
    return display_unit(Kind.ANGLE if name.startswith("r") else Kind.POSITION, [])


def _unit_of(own: Slider) -> DisplayUnit:
    """Return the unit that a parameter is shown in: the file's, where its numbers are handy."""
    size = parse_quantity(f"1 {own.unit}").si if own.unit else 1.0
    if own.value == 0.0 or _HANDY[0] <= abs(own.value) / size < _HANDY[1]:
        return DisplayUnit(own.unit, size)
    dims = dimension_of(own.unit)
    kind = None if dims is None else _KINDS.get(dims)
    return DisplayUnit(own.unit, size) if kind is None else display_unit(kind, own.value)


def _shown(unit: DisplayUnit, si: float) -> float:
    """Return a value in a unit, without the noise of the conversion."""
    return float(f"{si / unit.size:.9g}")


def _ends(own: Slider, unit: DisplayUnit) -> tuple[float, float]:
    """Return the ends of a slider, round numbers a little inside the file's limits."""
    low, high = own.low / unit.size, own.high / unit.size
    digit = 10.0 ** (math.floor(math.log10(high - low)) - 2)
    at = _shown(unit, own.value)
    ends = math.ceil(low / digit - _SLACK) * digit, math.floor(high / digit + _SLACK) * digit
    return min(float(f"{ends[0]:.9g}"), at), max(float(f"{ends[1]:.9g}"), at)
