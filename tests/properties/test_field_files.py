"""Reading back what was written gives what was there."""

import tempfile
from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from stiffkit.identify.readers import FieldFile, read_field_file
from tests.unit.field_files import csv_text, field_file, frd_text


@st.composite
def fields(draw: st.DrawFn, size: float) -> FieldFile:
    """A field of up to nine nodes and three load cases."""
    count = draw(st.integers(1, 9))
    vectors = arrays(float, (count, 3), elements=st.floats(-size, size))
    node = st.integers(1, 99_999)
    ids = draw(st.lists(node, min_size=count, max_size=count, unique=True))
    cases = {f"step {n}": draw(vectors) for n in range(1, draw(st.integers(1, 3)) + 1)}
    return field_file(draw(vectors), cases, ids=np.array(ids))


def read_back(text: str, suffix: str) -> FieldFile:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"a{suffix}")
        path.write_text(text, encoding="utf-8")
        return read_field_file(path)


def assert_same(read: FieldFile, ids: np.ndarray, vectors: dict[str, np.ndarray]) -> None:
    np.testing.assert_array_equal(read.ids, ids)
    np.testing.assert_array_equal(read.points, vectors.pop("points"))
    assert list(read.cases) == list(vectors)
    for name, values in vectors.items():
        np.testing.assert_array_equal(read.cases[name], values)


@given(fields(size=1e30), st.booleans(), st.sampled_from(["\n", "\r\n"]))
def test_frd(field: FieldFile, long: bool, end: str) -> None:
    """The numbers are those that Python reads from the same text."""

    def rounded(values: np.ndarray) -> np.ndarray:
        return np.array([[float(f"{x:12.5E}") for x in row] for row in values.tolist()])

    vectors = {"points": field.points, **field.cases}
    kept = {name: rounded(values) for name, values in vectors.items()}
    # Exponents of three digits do not fit into twelve columns; CalculiX writes none.
    kept = {name: np.where(np.abs(values) < 1e-90, 0.0, values) for name, values in kept.items()}
    made = field_file(kept["points"], {name: kept[name] for name in field.cases}, ids=field.ids)
    assert_same(read_back(frd_text(made, long, end), ".frd"), field.ids, kept)


@given(fields(size=1e300), st.sampled_from([(",", False), (";", True), ("\t", True), (";", False)]))
def test_csv(field: FieldFile, style: tuple[str, bool]) -> None:
    vectors = {"points": field.points, **field.cases}
    assert_same(read_back(csv_text(field, *style), ".csv"), field.ids, dict(vectors))
