"""What the studio says in numbers, as HTML: every number with its unit, all text escaped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from stiffkit.plots import DisplayUnit, Kind, display_unit, format_value
from stiffkit.robot import DIRECTIONS
from stiffkit.stiffness import PrincipalAxes
from stiffkit.study import PoseResult

Array = NDArray[np.float64]

_ROUNDING = 1e-9
_PREFIXES = ((1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_BLOCKS = (("m/N", "rad/N"), ("rad/N", "rad/(N m)"))
"""Units of the blocks of a compliance; 1/N is a radian per newton."""

STYLE = """<style>
.sk{font:12px/1.45 system-ui,sans-serif;color:#222;padding:0 14px 0 2px}
.sk h4{margin:10px 0 3px;font-size:12px;font-weight:600}
.sk table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}
.sk th{font-weight:400;color:#555;text-align:left;padding:1px 4px 1px 0}
.sk td{text-align:right;padding:1px 0 1px 4px;white-space:nowrap}
.sk table.k{font-size:10.5px}.sk table.k th{padding:1px 2px;color:#555;text-align:right}
.sk table.k td{padding:1px 2px}.sk td.far,.sk th.far{border-left:1px solid #bbb}
.sk tr.far td,.sk tr.far th{border-top:1px solid #bbb}
.sk p{margin:2px 0}.sk .dim{color:#666}.sk .bad{color:#a4123f;font-weight:600}
</style>"""


def page(*parts: str) -> str:
    """Return parts as one piece of the panel."""
    return f'{STYLE}<div class="sk">{"".join(parts)}</div>'


def heading(text: str) -> str:
    """Return a heading."""
    return f"<h4>{escape(text)}</h4>"


def paragraph(text: str, look: str = "") -> str:
    """Return a paragraph for each line; ``look`` is "", "dim" or "bad"."""
    return "".join(f'<p class="{look}">{escape(line)}</p>' for line in text.splitlines())


def table(rows: Iterable[tuple[str, Sequence[str]]], heads: Sequence[str] = ()) -> str:
    """Return a table: names with one or more values, under ``heads`` if there are any."""
    head = "".join(f'<th style="text-align:right">{escape(text)}</th>' for text in heads)
    body = "".join(
        f"<tr><th>{escape(name)}</th>{''.join(f'<td>{escape(cell)}</td>' for cell in cells)}</tr>"
        for name, cells in rows
    )
    return f"<table>{f'<tr><th></th>{head}</tr>' if heads else ''}{body}</table>"


Row = tuple[str, list[str]]
"""A name, and what stands beside it."""


def row(name: str, values: Sequence[float], kind: Kind) -> Row:
    """Return SI values as a row; of two, how the first differs from the second stands there too.

    One value has its unit beside it; the unit of two is that of the row.
    """
    unit = display_unit(kind, values)
    if len(values) < 2:
        return name, [unit.text(value) for value in values]
    now, before = values
    with np.errstate(all="ignore"):
        change = 100.0 * (now / before - 1.0) if before else np.nan
    numbers = [format_value(value / unit.size) for value in values]
    return unit.label(name), [
        *numbers,
        f"{change:+.1f} %".replace("-", "−") if np.isfinite(change) else "–",
    ]


def deflection_rows(results: Sequence[PoseResult], load: str) -> list[Row]:
    """Return the deflection under a load, of one pose or of two compared."""
    found = [_settled(r.deflections.get(load, np.full(6, np.nan))) for r in results]
    rows = [
        (f"along {d}" if i < 3 else f"about {d[1]}", [float(v[i]) for v in found])
        for i, d in enumerate(DIRECTIONS)
    ]
    rows.insert(0, ("deflection", [float(np.linalg.norm(v[:3])) for v in found]))
    rows.insert(4, ("rotation", [float(np.linalg.norm(v[3:])) for v in found]))
    kinds = [Kind.DEFLECTION] * 4 + [Kind.ROTATION] * 4
    return [row(name, values, kind) for (name, values), kind in zip(rows, kinds, strict=True)]


def _settled(deflection: Array) -> Array:
    """Return a deflection (6,) without what is rounding beside its largest part."""
    parts = []
    for part in (deflection[:3], deflection[3:]):
        parts.append(np.where(np.abs(part) > _ROUNDING * np.abs(part).max(), part, 0.0))
    return np.where(np.isnan(deflection), np.nan, np.concatenate(parts))


def stiffness_rows(results: Sequence[PoseResult]) -> list[Row]:
    """Return principal stiffnesses, weakest first, of one pose or of two compared."""
    rows = []
    for name, kind, of in (
        ("translation", Kind.STIFFNESS, [r.translation for r in results]),
        ("rotation", Kind.ROTATIONAL_STIFFNESS, [r.rotation for r in results]),
    ):
        for i, which in enumerate(("weakest", "middle", "strongest")):
            values = [_sorted(axes)[i] for axes in of]
            rows.append(row(f"{name}, {which}", values, kind))
    return rows


def _sorted(axes: PrincipalAxes | None) -> Array:
    return np.full(3, np.nan) if axes is None else np.sort(axes.stiffness)


def frequency_rows(all_hz: Sequence[Array]) -> list[Row]:
    """Return natural frequencies, lowest first, of one pose or of two compared."""
    n = max((len(hz) for hz in all_hz), default=0)
    rows = []
    for i in range(n):
        values = [float(hz[i]) if i < len(hz) else np.nan for hz in all_hz]
        rows.append(row(f"mode {i + 1}", values, Kind.FREQUENCY))
    return rows


def compliance_table(k: Array) -> str:
    """Return a compliance (6, 6), SI, as a table whose four blocks have their own units."""
    blocks = [[_block_unit(k, r, c) for c in range(2)] for r in range(2)]
    heads = "".join(f"<th{_far(j)}>{_COLUMNS[j]}</th>" for j in range(6))
    rows = []
    for i, name in enumerate(DIRECTIONS):
        cells = "".join(
            f"<td{_far(j)}>{format_value(_three(k[i, j] / blocks[i // 3][j // 3].size))}</td>"
            for j in range(6)
        )
        rows.append(f"<tr{' class=far' if i == 3 else ''}><th>{name}</th>{cells}</tr>")
    units = (
        f"translation by force in {blocks[0][0].symbol}, rotation by force and translation by"
        f" moment in {blocks[0][1].symbol}, rotation by moment in {blocks[1][1].symbol}"
    )
    return f'<table class="k"><tr><th></th>{heads}</tr>{"".join(rows)}</table>' + paragraph(
        units, "dim"
    )


_COLUMNS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")


def _far(column: int) -> str:
    return " class=far" if column == 3 else ""


def _three(value: float) -> float:
    """Return a value with three digits, and what is far below a thousandth of its unit as zero."""
    return 0.0 if abs(value) < 5e-4 else float(f"{value:.3g}")


def _block_unit(k: Array, row: int, column: int) -> DisplayUnit:
    """Return the unit of a block; coupling blocks of a symmetric matrix share theirs."""
    block = np.abs(k[3 * row : 3 * row + 3, 3 * column : 3 * column + 3])
    if row != column:
        block = np.maximum(np.abs(k[:3, 3:]), np.abs(k[3:, :3]).T)
    largest = float(block.max())
    size, prefix = next(((s, p) for s, p in _PREFIXES if largest >= s), _PREFIXES[-1])
    return DisplayUnit(f"{prefix}{_BLOCKS[row][column]}", size)
