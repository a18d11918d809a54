"""A map that does not come to its end leaves nothing that could be taken for one."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import stiffkit
from stiffkit.errors import OutputError
from stiffkit.study import whole_directory

from .commandline import ENDS_WITHIN, SMALL_ROBOT, STIFFKIT, output_of, refusal_of

LONG = ("map", "five-bar", "--points", "3000000", "-o", "out")
"""A map that takes far longer than a test waits."""


@contextmanager
def working_map(here: Path) -> Iterator[subprocess.Popen[str]]:
    """Give a process that computes a map into ``out``, and end it in any case."""
    process = subprocess.Popen(
        [STIFFKIT, *LONG],
        cwd=here,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heed_interruptions,
    )
    try:
        deadline = time.monotonic() + ENDS_WITHIN
        while not half_made(here) and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.02)
        assert half_made(here), "the map has not begun"
        time.sleep(0.3)
        assert process.poll() is None, "the map is too short to be interrupted"
        yield process
    finally:
        process.kill()
        process.communicate()


def heed_interruptions() -> None:
    """Undo what a shell does to processes in the background: it has them ignore Ctrl+C."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def half_made(here: Path) -> list[Path]:
    """Return the directories in which maps are being made."""
    return [path for path in here.rglob(".*.partial") if path.is_dir()]


def content(directory: Path) -> dict[str, bytes]:
    """Return the files of a directory, those that are being made left out."""
    return {
        str(path.relative_to(directory)): path.read_bytes()
        for path in directory.rglob("*")
        if path.is_file() and ".partial" not in str(path)
    }


@pytest.fixture(scope="module")
def earlier_map(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Return the files of a small map."""
    here = tmp_path_factory.mktemp("earlier")
    (here / "arms.yaml").write_text(SMALL_ROBOT, encoding="utf-8")
    output_of("map", "arms.yaml", "--points", "9", "-o", "out", cwd=here)
    return content(here / "out")


@pytest.fixture
def used_place(tmp_path: Path, earlier_map: dict[str, bytes]) -> Path:
    """Return a directory whose ``out`` holds the results of an earlier map, and notes."""
    for name, data in [*earlier_map.items(), ("notes.txt", b"mine")]:
        path = tmp_path / "out" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    return tmp_path


class TestInterrupted:
    """By the user, with Ctrl+C, or by a system that asks for an end."""

    @pytest.mark.parametrize("order", [signal.SIGINT, signal.SIGTERM])
    def test_new_place_stays_empty(self, order: signal.Signals, tmp_path: Path) -> None:
        with working_map(tmp_path) as process:
            process.send_signal(order)
            output, message = process.communicate(timeout=ENDS_WITHIN)
        assert process.returncode == 128 + order
        assert output == ""
        told = "interrupted; nothing was written" if order == signal.SIGINT else ""
        assert message.strip() == told
        assert list(tmp_path.iterdir()) == []

    def test_earlier_results_stay(self, used_place: Path) -> None:
        before = content(used_place)
        with working_map(used_place) as process:
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=ENDS_WITHIN)
        assert process.returncode == 130
        assert content(used_place) == before
        assert half_made(used_place) == []


class TestKilled:
    def test_new_place_stays_absent_and_can_be_used(self, tmp_path: Path) -> None:
        with working_map(tmp_path) as process:
            process.kill()
            process.wait(timeout=ENDS_WITHIN)
        assert process.returncode == -signal.SIGKILL
        assert not (tmp_path / "out").exists()
        (tmp_path / "arms.yaml").write_text(SMALL_ROBOT, encoding="utf-8")
        output_of("map", "arms.yaml", "--points", "9", "-o", "out", cwd=tmp_path)
        assert stiffkit.open_map(tmp_path / "out").sizes["x"] == 9

    def test_earlier_results_stay(self, used_place: Path) -> None:
        before = content(used_place)
        with working_map(used_place) as process:
            process.kill()
            process.wait(timeout=ENDS_WITHIN)
        assert content(used_place) == before
        assert stiffkit.open_map(used_place / "out").sizes["x"] == 9


class TestCannotBeWritten:
    @pytest.mark.parametrize("largest", [20, 1000], ids=["dataset", "report"])
    def test_a_file_that_cannot_grow(self, largest: int, used_place: Path) -> None:
        # The report is some megabytes large, the dataset some ten kilobytes.
        (used_place / "arms.yaml").write_text(SMALL_ROBOT, encoding="utf-8")
        before = content(used_place)
        message = refusal_of(
            *("map", "arms.yaml", "--points", "9", "-o", "out"),
            cwd=used_place,
            limit=f"-f {largest}",
        )
        assert "File too large" in message
        assert "mend: " in message
        assert content(used_place) == before
        assert half_made(used_place) == []

    def test_a_full_disk(self, used_place: Path) -> None:
        def write_until_full() -> None:
            with whole_directory(used_place / "out") as work:
                (work / "map.nc").write_bytes(b"half")
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        before = content(used_place)
        with pytest.raises(OutputError, match="out cannot be written: No space left") as caught:
            write_until_full()
        assert "make room" in caught.value.mend
        assert content(used_place) == before
        assert half_made(used_place) == []

    @pytest.mark.parametrize("failing", range(1, 7))
    def test_while_results_are_put_in_place(
        self, failing: int, used_place: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """Three old results go aside and three new ones come; one of the six moves fails."""
        rename = Path.rename
        moves: list[Path] = []

        def failing_rename(path: Path, target: Path) -> Path:
            moves.append(path)
            if len(moves) == failing:
                raise OSError(errno.EIO, os.strerror(errno.EIO))
            return rename(path, target)

        def replace_results() -> None:
            with whole_directory(used_place / "out") as work:
                for name in ("figures", "map.nc", "report.html"):
                    (work / name).write_bytes(b"new")
                monkeypatch.setattr(Path, "rename", failing_rename)

        before = content(used_place)
        with pytest.raises(OutputError, match="out cannot be written: Input/output error"):
            replace_results()
        assert content(used_place) == before
        assert half_made(used_place) == []


def test_the_other_kind_of_dataset_goes(tmp_path: Path) -> None:
    """A small map replaces a large one: what is read afterwards is the later of the two."""
    (tmp_path / "map.zarr").mkdir()
    (tmp_path / "map.zarr" / ".zgroup").touch()
    with whole_directory(tmp_path) as work:
        (work / "map.nc").write_bytes(b"new")
    assert [path.name for path in tmp_path.iterdir()] == ["map.nc"]


def test_a_link_to_a_directory_is_followed(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out").symlink_to("elsewhere")
    with whole_directory(tmp_path / "out") as work:
        (work / "map.nc").write_bytes(b"new")
    assert (tmp_path / "out").is_symlink()
    assert (tmp_path / "elsewhere" / "map.nc").read_bytes() == b"new"


def test_too_little_memory_is_told(tmp_path: Path) -> None:
    message = refusal_of(
        *("map", "five-bar", "--points", "100000000"), cwd=tmp_path, limit=f"-d {1024 * 1024}"
    )
    assert "more memory than there is mend: ask for fewer --points" in message
    assert list(tmp_path.iterdir()) == []
