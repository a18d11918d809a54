"""Tables as text."""

from __future__ import annotations

from collections.abc import Sequence

Cell = str | int | float


def table(heads: Sequence[str], rows: Sequence[Sequence[Cell]]) -> str:
    """Return a table with aligned columns; floats have three significant digits."""
    texts = [list(heads), *([_text(cell) for cell in row] for row in rows)]
    widths = [max(len(row[i]) for row in texts) for i in range(len(heads))]
    numeric = [rows and not isinstance(rows[0][i], str) for i in range(len(heads))]
    lines = [
        "  ".join(
            cell.rjust(width) if right else cell.ljust(width)
            for cell, width, right in zip(row, widths, numeric, strict=True)
        ).rstrip()
        for row in texts
    ]
    return "\n".join(lines)


def show(title: str, heads: Sequence[str], rows: Sequence[Sequence[Cell]]) -> None:
    """Print a table under its title."""
    print(f"{title}\n{table(heads, rows)}\n", flush=True)


def _text(cell: Cell) -> str:
    if isinstance(cell, float):
        return f"{cell:.3g}" if abs(cell) < 1e3 else f"{cell:.0f}"
    return str(cell)
