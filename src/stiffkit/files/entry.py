"""A place in a file: its value, and what an error there needs to say."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import ExpressionError, FileError, LinkError, UnitError
from stiffkit.files.names import Key, key_path, suggest
from stiffkit.files.parameters import evaluate
from stiffkit.files.tree import Node
from stiffkit.units import ANGLE, LENGTH, Dimension, Value, to_si

Array = NDArray[np.float64]

_NAME = re.compile(r"[\w-]+")
_VARIABLE = re.compile(r"\{([^{}]*)\}")
# Fourth powers of lengths, times moduli, stay far from overflow and underflow between these.
_SMALLEST, _LARGEST = 1e-40, 1e20
_FULL_TURN = 2.0 * math.pi


@dataclass(frozen=True)
class Scope:
    """What names mean at a place: parameters, and the variables of a repeated section."""

    values: Mapping[str, Value] = field(default_factory=dict)
    texts: Mapping[str, str] = field(default_factory=dict)
    """What ``{k}`` is replaced by; empty outside of repeated sections."""

    @property
    def label(self) -> str:
        """Which round of a repeated section this is, such as " (k = 1)"."""
        rounds = ", ".join(f"{name} = {text}" for name, text in self.texts.items())
        return f" ({rounds})" if rounds else ""


@dataclass(frozen=True)
class Entry:
    """A value in a file whose shape has been checked, with its place and its scope."""

    path: Path
    keys: tuple[Key, ...]
    node: Node
    scope: Scope = field(default_factory=Scope)

    def error(self, what: str, mend: str = "") -> FileError:
        """Return an error at this place."""
        key = key_path(self.keys) + self.scope.label
        return FileError(what, path=self.path, line=self.node.line, key=key, mend=mend)

    # --- inside ---

    def __contains__(self, key: str) -> bool:
        """Tell whether a mapping has a key."""
        return self.node.child(key) is not None

    def get(self, key: Key) -> Entry | None:
        """Return what stands under a key or an index; None where there is nothing."""
        node = self.node.child(key)
        return None if node is None else Entry(self.path, (*self.keys, key), node, self.scope)

    def __getitem__(self, key: Key) -> Entry:
        """Return what stands under a key or an index. Raises FileError if there is nothing."""
        entry = self.get(key)
        if entry is None:
            raise self.error(f"'{key}' is missing")
        return entry

    def elements(self) -> list[Entry]:
        """Return the elements of a list."""
        count = len(self.node.value) if isinstance(self.node.value, list) else 0
        return [self[index] for index in range(count)]

    def items(self) -> Iterator[tuple[str, Entry]]:
        """Yield the names of a mapping, variables filled in, and what stands under them.

        Raises FileError where filling in makes no name, or one that is there already.
        """
        seen: set[str] = set()
        for key in self.node.value if isinstance(self.node.value, dict) else ():
            entry = self[key]
            name = entry.fill(key)
            if self.scope.texts and not _NAME.fullmatch(name):
                raise entry.error(
                    f"'{name}' is no name", "names have letters, digits, _ and -, and no other sign"
                )
            if name in seen:
                raise entry.error(f"the name '{name}' is given twice")
            seen.add(name)
            yield name, entry

    # --- text ---

    def fill(self, text: str) -> str:
        """Return a text with the variables of the repeated section filled in."""

        def value(match: re.Match[str]) -> str:
            name = match[1].strip()
            if name not in self.scope.texts:
                raise self.error(
                    f"'{{{name}}}' is no variable of this section", suggest(name, self.scope.texts)
                )
            return self.scope.texts[name]

        return _VARIABLE.sub(value, text) if self.scope.texts else text

    def text(self) -> str:
        """Return a text."""
        return self.fill(str(self.node.value)).strip()

    def is_text(self, text: str) -> bool:
        """Tell whether this is a certain text."""
        return isinstance(self.node.value, str) and self.text() == text

    # --- quantities ---

    def value(self) -> Value:
        """Return a quantity. Raises FileError where it cannot be read or evaluated."""
        given = self.node.value
        if given is None or isinstance(given, dict | list):
            raise self.error("a quantity is expected here", "for example '310 mm'")
        try:
            return evaluate(
                self.fill(given) if isinstance(given, str) else given, self.scope.values
            )
        except (UnitError, ExpressionError) as error:
            raise self.error(error.what, error.mend) from None

    def quantity(self, dimension: Dimension) -> float:
        """Return a quantity in SI. Raises FileError where it has another dimension."""
        value = self.value()
        try:
            si = to_si(value, dimension)
        except UnitError as error:
            raise self.error(error.what, error.mend) from None
        if si != 0.0 and not _SMALLEST <= abs(si) <= _LARGEST:
            raise self.error(
                f"'{value}' is beyond what can be computed with",
                f"SI values lie between {_SMALLEST:g} and {_LARGEST:g}, or are zero",
            )
        if dimension is ANGLE and value.dims is None and abs(si) > _FULL_TURN:
            # Almost always degrees were meant.
            raise self.error(
                f"the bare number {value} means {value} rad, more than a turn",
                f"write '{si:g} deg', or '{si:g} rad' if you mean it",
            )
        return si

    def positive(self, dimension: Dimension) -> float:
        """Return a quantity in SI. Raises FileError where it is not positive."""
        si = self.quantity(dimension)
        if si <= 0.0:
            raise self.error(
                f"'{self.value()}' must be positive",
                f"write a value above zero; it is {si:g} in SI",
            )
        return si

    def not_negative(self, dimension: Dimension) -> float:
        """Return a quantity in SI. Raises FileError where it is negative."""
        si = self.quantity(dimension)
        if si < 0.0:
            raise self.error(
                f"'{self.value()}' must not be negative", f"write zero or more; it is {si:g}"
            )
        return si

    def vector(self, dimension: Dimension) -> Array:
        """Return a list of quantities of one dimension in SI, (n,)."""
        return np.array([element.quantity(dimension) for element in self.elements()])

    def matrix(self, dimension: Dimension) -> Array:
        """Return a list of equally long lists of quantities in SI, (m, n)."""
        return np.array([row.vector(dimension) for row in self.elements()])

    def coordinate(self, direction: str) -> float:
        """Return a length or an angle in SI, whichever a direction of x..rz has."""
        return self.quantity(ANGLE if direction.startswith("r") else LENGTH)

    def blame(self, error: LinkError) -> FileError:
        """Return what is wrong with a link's data as an error at this place."""
        return self.error(error.what, error.mend)
