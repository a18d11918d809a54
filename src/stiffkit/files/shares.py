"""Shares as files give them: '10 %', or 0.1."""

from __future__ import annotations

import re

from stiffkit.errors import UnitError
from stiffkit.files.entry import Entry
from stiffkit.units import NUMBER, to_si

_PERCENT = re.compile(r"([^%]*)%\s*")


def read_share(entry: Entry, most: float, example: float) -> float:
    """Return a share between 0 and ``most``, both excluded; messages show ``example``.

    Raises FileError where it is none.
    """
    percent = _PERCENT.fullmatch(entry.text())
    try:
        share = to_si(percent[1], NUMBER) / 100.0 if percent else entry.quantity(NUMBER)
    except UnitError as error:
        raise entry.error(error.what, f"write a share such as '{100.0 * example:g} %'") from None
    if not 0.0 < share < most:
        raise entry.error(
            f"'{entry.text()}' is not between 0 and {100.0 * most:g} %",
            f"'{100.0 * example:g} %' and {example:g} mean the same share",
        )
    return share
