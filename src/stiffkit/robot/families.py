"""CAD links that follow parameters without being solved anew for each value."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from stiffkit.errors import LinkError, UnitError
from stiffkit.files.entry import Entry
from stiffkit.files.names import suggest
from stiffkit.files.parameters import Given, check_same_dimension
from stiffkit.link.family import LinkFamily, Range, described, link_family
from stiffkit.link.file import LinkFile
from stiffkit.link.materials import Material
from stiffkit.progress import Progress
from stiffkit.robot.memo import PartMemo
from stiffkit.units import Value

WithOthers = Callable[[Mapping[str, Given]], Mapping[str, Value]]
"""Some parameters replaced to the values of all."""

_MOST = {1: 9, 2: 5, 3: 3}
"""Points of each range, by the number of ranges: no more than some tens of solutions."""


class Families:
    """The solutions of one link's part over ranges of parameters."""

    def __init__(
        self,
        name: str,
        materials: Mapping[str, Material],
        progress: Progress | None,
        memo: PartMemo,
        with_others: WithOthers | None,
    ) -> None:
        """Take the link's name, and what knows solutions from before."""
        self.name = name
        self.materials = materials
        self.progress = progress
        self.memo = memo
        self.with_others = with_others

    def link(self, entry: Entry) -> LinkFile:
        """Return the link at the parameters' values, between solutions at others.

        Raises FileError where ranges are wrong, a value lies out of them, or a part cannot be
        solved.
        """
        between = entry["between"]
        ranges = [self._range(name, one, entry) for name, one in between.items()]
        values = {one.name: entry.scope.values[one.name].si for one in ranges}
        for one in ranges:
            try:
                one.check(values[one.name])
            except LinkError as error:
                raise between[one.name].error(error.what, error.mend) from None
        middle = self._at(entry, {one.name: 0.5 * (one.low + one.high) for one in ranges})
        family = self.memo.get(
            f"solutions of {self.name}",
            [middle],
            lambda: self._solved(entry, ranges),
            *self.materials.values(),
        )
        try:
            found = family.at(list(values.values()))
        except LinkError as error:
            raise between.error(error.what, error.mend) from None
        return replace(found, notes=(*found.notes, described(family, values)))

    def _range(self, name: str, entry: Entry, whole: Entry) -> Range:
        values = whole.scope.values
        if name not in values:
            raise entry.error(f"there is no parameter '{name}'", suggest(name, values))
        ends = [one.value() for one in entry.elements()]
        for end in ends:
            try:
                check_same_dimension(name, values[name], end)
            except UnitError as error:
                raise entry.error(error.what, error.mend) from None
        low, high = (end.si for end in ends)
        if not low < high:
            raise entry.error("the range is empty", "give the smaller value first")
        return Range(name, low, high)

    def _at(self, entry: Entry, values: Mapping[str, float]) -> Entry:
        """Return the entry with other values of some parameters."""
        own = entry.scope.values
        given = {name: Value(si, own[name].dims) for name, si in values.items()}
        others = {**own, **given} if self.with_others is None else self.with_others(given)
        return replace(entry, scope=replace(entry.scope, values=others))

    def _solved(self, entry: Entry, ranges: list[Range]) -> LinkFamily:
        # It takes long to import, and few robots need it.
        from stiffkit.fea import link_from_cad, read_inline_spec

        tolerance = read_inline_spec(entry, self.name, self.materials).tolerance

        def solve(place: tuple[float, ...]) -> LinkFile:
            values = dict(zip((one.name for one in ranges), place, strict=True))
            spec = read_inline_spec(self._at(entry, values), self.name, self.materials)
            return link_from_cad(spec, self.progress).link

        return link_family(ranges, solve, tolerance, _MOST[len(ranges)])
