"""Studies on disk: chunks that are whole or not there, and a table made of them."""

from __future__ import annotations

import errno
import os
import shutil
import tracemalloc
from collections.abc import Generator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffkit.errors import OutputError, StiffkitError
from stiffkit.study.sweep import (
    Column,
    InProcess,
    StudyDirectory,
    StudySpec,
    Varied,
    create_study,
    open_study,
    run_study,
)
from stiffkit.study.sweep.directory import chunk_size_of
from stiffkit.study.sweep.executors import Chunk
from stiffkit.study.sweep.files import alone_in, read_arrays, write_arrays
from stiffkit.study.sweep.work import prepare

SPEC = StudySpec(
    title="Arms",
    robot="five-bar",
    varied=(Varied("distal", (0.34, 0.35, 0.36, 0.1, 0.37), "mm"),),
    sample=None,
    seed=0,
    postures=30,
    models=("refined",),
    frequency_postures=0,
    columns=(
        Column("weakest", "min", "stiffness_translation_min"),
        Column("soft", "share above", "deflection_xy", "push", 2e-5),
    ),
)


@pytest.fixture(scope="module")
def fresh(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return create_study(
        tmp_path_factory.mktemp("fresh") / "out", SPEC, chunk_size=2, backend="numpy"
    ).path


@pytest.fixture
def study(fresh: Path, tmp_path: Path) -> StudyDirectory:
    """A study that has just begun."""
    shutil.copytree(fresh, tmp_path / "out")
    return open_study(tmp_path / "out")


class Counting(InProcess):
    """Notes the chunks that it is given, and stops after some of them."""

    def __init__(self, most: int = 1000) -> None:
        self.given: list[int] = []
        self.most = most

    def run(
        self, job: dict[str, Any], reference: dict[str, Any], chunks: Sequence[Chunk]
    ) -> Generator[tuple[int, Any], None, None]:
        for number, rows in super().run(job, reference, chunks):
            if len(self.given) == self.most:
                raise KeyboardInterrupt
            self.given.append(number)
            yield number, rows


def values_of(study: StudyDirectory) -> dict[str, bytes]:
    """Return the bytes of everything in the table of a finished study."""
    import xarray as xr

    with xr.open_dataset(study.table, engine="h5netcdf") as table:
        return {
            str(name): repr(v.values.tolist()).encode() if v.dtype == object else v.values.tobytes()
            for name, v in table.variables.items()
        }


def test_the_table_has_a_row_for_each_geometry_with_units(study: StudyDirectory) -> None:
    table = run_study(study)
    assert table.sizes == {"model": 1, "coordinate": 2, "geometry": 5}
    np.testing.assert_array_equal(table["distal"].values, SPEC.varied[0].values)
    assert table["distal"].attrs["units"] == "m"
    assert table["weakest"].attrs["units"] == "N/m"
    assert table["soft"].attrs["long_name"].startswith("share of postures with the deflection")
    assert table["geometry_status"].values.tolist() == [0, 0, 0, 2, 0]
    assert "no assembly" in str(table["reason"].values[3])
    assert all(v.attrs["units"] for n, v in table.data_vars.items() if n != "reason")


def test_a_drive_is_in_newtons_per_metre(tmp_path: Path) -> None:
    drives = (Varied("drive", (5e8, 1e9), "kN/mm"),)
    spec = replace(SPEC, robot="biglide", varied=drives, columns=SPEC.columns[:1])
    table = run_study(create_study(tmp_path / "out", spec, backend="numpy"))
    assert table["drive"].attrs["units"] == "N/m"
    assert table["weakest"].values[0, 0] < table["weakest"].values[0, 1]


def test_chunks_grow_with_the_square_root_of_the_study() -> None:
    def size(geometries: int, frequencies: int = 0) -> int:
        spec = replace(SPEC, sample=geometries, postures=1000, frequency_postures=frequencies)
        return chunk_size_of(spec)

    assert size(400_000) == pytest.approx(2 * size(100_000), rel=0.02)
    assert size(100_000, 10) < size(100_000)
    assert size(10) == size(1000) == 32
    assert size(10**9) == size(10**10) < 2000
    assert chunk_size_of(replace(SPEC, postures=10**7)) == 1


def test_what_chunks_begin_from_belongs_to_the_study(
    study: StudyDirectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A worker keeps what it made for a study by its key, also while another one is begun."""
    prepared = prepare(SPEC, "numpy")
    reference = {**prepared.reference, "q": prepared.reference["q"] * (1.0 + 1e-15)}
    other = replace(prepared, reference=reference)
    monkeypatch.setattr("stiffkit.study.sweep.directory.prepare", lambda *_: other)
    again = create_study(tmp_path / "again", SPEC, chunk_size=2, backend="numpy")
    assert again.job.key != study.job.key


def test_what_is_finished_is_not_computed_again(study: StudyDirectory) -> None:
    first, second = Counting(1), Counting()
    with pytest.raises(KeyboardInterrupt):
        run_study(study, first)
    assert study.finished() == [0]
    run_study(open_study(study.path), second)
    assert second.given == [1, 2]


def test_interrupted_or_not_the_table_is_the_same(study: StudyDirectory, tmp_path: Path) -> None:
    for most in (1, 1):
        with pytest.raises(KeyboardInterrupt):
            run_study(study, Counting(most))
    run_study(study)
    whole = create_study(tmp_path / "whole", SPEC, chunk_size=5, backend="numpy")
    run_study(whole)
    assert values_of(study) == values_of(whole)


@pytest.mark.parametrize("damage", ["cut", "flip", "empty", "other"])
def test_a_damaged_chunk_is_found_and_computed_again(damage: str, study: StudyDirectory) -> None:
    run_study(study)
    before = values_of(study)
    path = study.chunk_path(1)
    content = bytearray(path.read_bytes())
    if damage == "flip":
        content[len(content) // 2] ^= 1
    elif damage == "other":
        rows = study.read_chunk(1)
        assert rows is not None
        write_arrays(path, {**rows, "study": np.array("another")})
        content = bytearray(path.read_bytes())
    path.write_bytes(content[: {"cut": len(content) // 2, "empty": 0}.get(damage, len(content))])
    assert study.finished() == [0, 2]
    again = Counting()
    run_study(study, again)
    assert again.given == [1]
    assert values_of(study) == before


def test_a_full_disk_leaves_what_was_there(
    study: StudyDirectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with pytest.raises(KeyboardInterrupt):
        run_study(study, Counting(1))
    with monkeypatch.context() as patched:
        patched.setattr(os, "fsync", full)
        with pytest.raises(OutputError, match="No space left") as caught:
            run_study(study)
    assert "goes on" in caught.value.mend
    assert study.finished() == [0]
    assert not list(study.path.rglob("*.partial"))
    run_study(study)


def test_arrays_come_back_as_they_were(tmp_path: Path) -> None:
    arrays = {"a": np.array([1.0, np.nan]), "b": np.array(["", "why"]), "c": np.zeros((2, 0))}
    write_arrays(tmp_path / "x.npz", arrays)
    found = read_arrays(tmp_path / "x.npz")
    assert found is not None
    assert found.keys() == arrays.keys()
    for name, array in arrays.items():
        assert found[name].dtype == array.dtype
        assert found[name].tobytes() == array.tobytes()


def test_two_processes_do_not_work_on_one_study(study: StudyDirectory) -> None:
    with alone_in(study.path), pytest.raises(OutputError, match="another process"):
        run_study(study)


def test_another_study_is_not_overwritten(study: StudyDirectory) -> None:
    assert create_study(study.path, SPEC).chunk_size == 2
    with pytest.raises(OutputError, match="holds another study, 'Arms'"):
        create_study(study.path, replace(SPEC, postures=31))


def test_what_is_no_study_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match="holds no study"):
        create_study(tmp_path, SPEC)
    with pytest.raises(OutputError, match="there is no study"):
        open_study(tmp_path)
    (tmp_path / "study.json").write_text("{")
    with pytest.raises(OutputError, match="is damaged"):
        open_study(tmp_path)


def test_a_missing_reference_is_told(study: StudyDirectory) -> None:
    (study.path / "reference.npz").write_bytes(b"")
    with pytest.raises(OutputError, match="missing or damaged"):
        run_study(study)


def test_dask_is_asked_for_only_where_it_is_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    from stiffkit.study.sweep import Cluster

    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(StiffkitError, match="not installed") as caught:
        Cluster("tcp://127.0.0.1:1", print)
    assert "stiffkit[cluster]" in caught.value.mend


def test_memory_does_not_grow_with_the_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ten times the geometries, and so the postures, in chunks of the same size."""
    # What is remembered of parts is bounded too; a lower bound is reached sooner.
    monkeypatch.setattr("stiffkit.robot.memo._MOST_KEPT", 20)

    def peak(count: int) -> int:
        lengths = tuple(np.linspace(0.34, 0.4, count).tolist())
        spec = replace(SPEC, varied=(Varied("distal", lengths, "mm"),), postures=50)
        study = create_study(tmp_path / str(count), spec, chunk_size=20)
        tracemalloc.start()
        try:
            run_study(study)
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    # Both have as many anchors as a study has at most.
    few, many = peak(70), peak(700)
    assert many < 1.3 * few
