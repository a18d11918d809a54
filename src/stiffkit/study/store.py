"""Datasets on disk: whole or not there at all."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from stiffkit.errors import OutputError

if TYPE_CHECKING:
    import xarray as xr

LARGE = 200_000_000
"""Bytes above which a dataset is stored as Zarr instead of NetCDF."""

_DATASETS = ("map.nc", "map.zarr")


@dataclass(frozen=True)
class Kind:
    """What a kind of results is made of on disk."""

    word: str
    marks: tuple[str, ...]
    """Names of which one is there wherever such results are."""
    others: tuple[str, ...]
    """Names beside it, which somebody else might use too."""


MAP = Kind("map", _DATASETS, ("figures", "report.html"))
MODES = Kind("study of modes", ("modes.html",), ("modes",))
REPRODUCTION = Kind(
    "reproduction",
    ("reproduction.json",),
    tuple(
        f"{paper}-figure-{n}.{kind}"
        for paper, numbers in (
            ("pashkevich-2009", (1, 2, 3)),
            ("briot-2009", (3, 5, 6, 7, 10, 12, 13)),
        )
        for n in numbers
        for kind in ("svg", "png")
    ),
)

VERIFICATION = Kind("verification", ("verify.json",), ())

FACES = Kind("picture of faces", ("faces.png",), ("faces.svg",))


def cad_link(link_file: str) -> Kind:
    """Return what a link from CAD is made of, whose file has this name."""
    return Kind("link from CAD", (link_file,), ("figures", "report.html"))


def identification(link_file: str) -> Kind:
    """Return what the identification of a link is made of, whose file has this name."""
    return Kind("identification", (link_file,), ("report.html",))


def dataset_name(dataset: xr.Dataset) -> str:
    """Return the file name that a dataset gets: map.nc, or map.zarr if it is large."""
    small, large = _DATASETS
    return large if dataset.nbytes > LARGE else small


def write_dataset(dataset: xr.Dataset, directory: Path) -> Path:
    """Write a dataset as NetCDF-4, or as Zarr if it is large, and return where."""
    path = directory / dataset_name(dataset)
    if path.suffix == ".zarr":
        dataset.to_zarr(path, mode="w", zarr_format=2)
    else:
        # In memory first: where a disk is full, HDF5 brings the whole process down.
        path.write_bytes(dataset.to_netcdf(engine="h5netcdf"))
    return path


def open_map(path: str | Path) -> xr.Dataset:
    """Return a dataset that `write_dataset` wrote, or the one in the directory of a map."""
    import xarray as xr

    path = Path(path)
    for name in _DATASETS:
        if (path / name).exists():
            path = path / name
            break
    opened: xr.Dataset
    if path.suffix == ".zarr":
        opened = xr.open_zarr(path)
    else:
        opened = xr.open_dataset(path, engine="h5netcdf")
    return opened


@contextmanager
def whole_directory(target: Path, kind: Kind = MAP) -> Iterator[Path]:
    """Give a directory to write in, whose content appears in ``target`` only when all is done.

    Whatever is interrupted leaves ``target`` as it was. Earlier results of the same kind there are
    replaced, all other files are kept. Raises OutputError if ``target`` cannot be written, or if
    something that is no such result would be replaced.
    """
    target = Path(target)
    with _told(target, "choose another directory with -o"):
        _check_place(target, kind)
        is_new = not target.exists()
        target.parent.mkdir(parents=True, exist_ok=True)
        # Beside a new target, inside an old one: an old one may be a mounted file system, or the
        # only directory here that the user may write to.
        work = Path(
            tempfile.mkdtemp(
                prefix=f".{target.name}." if is_new else ".map.",
                suffix=".partial",
                dir=target.parent if is_new else target,
            )
        )
    try:
        with _told(target, "make room, or choose another directory with -o"):
            results = work / "results"
            results.mkdir()
            yield results
            if is_new and not target.exists():
                results.rename(target)
            else:
                _replace_items(results, target, kind, aside=work)
    finally:
        shutil.rmtree(work, ignore_errors=True)


@contextmanager
def _told(target: Path, mend: str) -> Iterator[None]:
    """Turn what the system says of files into an OutputError."""
    try:
        yield
    except OSError as error:
        raise OutputError(
            f"{target} cannot be written: {error.strerror or error}", mend=mend
        ) from error


def _check_place(target: Path, kind: Kind) -> None:
    """Raise OutputError where results must not be written."""
    above = next(path for path in (target, *target.parents) if path.exists())
    if not above.is_dir():
        raise OutputError(
            f"{target} cannot be written: {above} is not a directory",
            mend="choose another directory with -o",
        )
    theirs = [target / name for name in kind.others if (target / name).exists()]
    if theirs and not any((target / name).exists() for name in kind.marks):
        raise OutputError(
            f"{theirs[0]} is there already and is not of an earlier {kind.word}",
            mend="choose another directory with -o",
        )


def _replace_items(results: Path, target: Path, kind: Kind, aside: Path) -> None:
    """Move results into a directory, and what they replace aside; all of them or none."""
    old = aside / "old"
    old.mkdir()
    new = sorted(path.name for path in results.iterdir())
    # A dataset in the other format would be taken for that of the new map.
    replaced = [name for name in {*new, *kind.marks} if (target / name).exists()]
    with ExitStack() as undo:
        for name, source, destination in (
            *((name, target, old) for name in replaced),
            *((name, results, target) for name in new),
        ):
            (source / name).rename(destination / name)
            undo.callback((destination / name).rename, source / name)
        undo.pop_all()
