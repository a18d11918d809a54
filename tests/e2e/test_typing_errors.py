"""A slip of the fingers gives one message that names the nearest right word, and status 2."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest

from stiffkit.errors import OutputError
from stiffkit.study import whole_directory

from .commandline import refusal_of

SLIPS = [
    ("chek biglide", "No such command 'chek'", "'check'"),
    ("check --jsn biglide", "No such option '--jsn'", "Try 'stiffkit check --help'"),
    ("pose biglide --jsn", "No such option '--jsn'", "'--json'"),
    ("map biglide --pionts 9", "No such option '--pionts'", "Did you mean one of: '--points'"),
    ("check", "Missing argument 'ROBOT'", "Try 'stiffkit check --help'"),
    ("check biglide delta", "unexpected extra argument (delta)", "Try 'stiffkit check --help'"),
    ("check biglde", "biglde: there is no robot of this name", "did you mean 'biglide'"),
    ("check Biglide", "Biglide: there is no robot of this name", "did you mean 'biglide'"),
    ("check ./biglide", "there is no such file", "of the catalogue: did you mean 'biglide'"),
    ("check robots/mine.yaml", "robots/mine.yaml: there is no such file", "check the path"),
    ("pose biglide --at X=1", "'X' is no tool coordinate", "did you mean 'x'?"),
    ("pose biglide --at w=1", "'w' is no tool coordinate", "known here: x, y, z, rx, ry, rz"),
    ("pose biglide --at x", "'x' in --at is not of the form name=value", "--at x=0.4975,y=-20mm"),
    ("pose biglide --at x=", "'x=' in --at is not of the form name=value", "--at x=0.4975"),
    ("pose biglide --at x=1,x=2", "'x' is given twice in --at", "keep one of them"),
    ("pose biglide --at x=5mmm", "'mmm' is no unit known here", "'mm'"),
    ("pose biglide --at x=5kg", "'5kg' is a mass", "a length is expected (for example '310 mm')"),
    ("pose biglide --at rz=5mm", "'5mm' is a length", "an angle is expected"),
    ("pose biglide --at x=nan", "'nan' is no quantity", "write a number and its unit"),
    ("pose biglide --at x=1e400", "'1e400' is too large a number", ""),
    ("pose biglide --at z=10mm", "makes it 0 m", "independent tool coordinates of biglide are: x"),
    ("pose biglide --load f_zz", "biglide has no load case 'f_zz'", "did you mean 'f_z'?"),
    ("pose biglide --load f_z=1", "'f_z' is no component of a load", "did you mean 'fz'?"),
    ("pose biglide --load fz=1mm", "'1mm' is a length", "a force is expected"),
    ("pose biglide --load mz=1N", "'1N' is a force", "a moment is expected"),
    ("pose biglide --model simple", "'simple' is not one of", "'refined', 'simplified'"),
    ("pose biglide --set l1=2", "the robot has no parameter 'l1'", "did you mean 'L1'?"),
    ("pose biglide --set L1=2kg", "'2kg' is a mass", "parameter L1 is a length (0.85 m)"),
    ("map biglide --points 0", "0 is not in the range 1<=x", ""),
    ("map biglide --points many", "'many' is not a valid integer", ""),
    ("completion csh", "'csh' is not one of", "'bash', 'zsh', 'fish'"),
    ("--versoin", "No such option '--versoin'", "Did you mean '--version'?"),
]


@pytest.mark.parametrize(("typed", "told", "mend"), SLIPS, ids=[slip[0] for slip in SLIPS])
def test_slip(typed: str, told: str, mend: str, tmp_path: Path) -> None:
    message = refusal_of(*typed.split(), cwd=tmp_path)
    assert told in message
    assert mend in message
    assert list(tmp_path.iterdir()) == []


class TestOutput:
    """Where a map must not be written is told before anything is computed."""

    @pytest.fixture
    def here(self, tmp_path: Path) -> Path:
        (tmp_path / "file").write_text("mine", encoding="utf-8")
        (tmp_path / "paper" / "figures").mkdir(parents=True)
        (tmp_path / "paper" / "figures" / "mine.svg").touch()
        return tmp_path

    @pytest.mark.parametrize(
        ("output", "told"),
        [
            ("file", "file cannot be written: file is not a directory"),
            ("file/below", "file/below cannot be written: file is not a directory"),
            ("/dev/null", "/dev/null is not a directory"),
            ("/proc/map", "/proc/map cannot be written: "),
            ("x" * 300, "cannot be written: File name too long"),
            ("paper", "paper/figures is there already and is not of an earlier map"),
        ],
    )
    def test_wrong_place(self, output: str, told: str, here: Path) -> None:
        before = sorted(here.rglob("*"))
        message = refusal_of("map", "biglide", "-o", output, cwd=here)
        assert told in message
        assert "mend: choose another directory with -o" in message
        assert sorted(here.rglob("*")) == before
        assert (here / "file").read_text(encoding="utf-8") == "mine"

    def test_no_permission(self, here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        # A directory refuses its owner too, but not root, as whom containers run.
        def refuse(**_: object) -> str:
            raise PermissionError(13, "Permission denied")

        monkeypatch.setattr(tempfile, "mkdtemp", refuse)
        with (
            pytest.raises(OutputError, match=r"out cannot be written: Permission denied"),
            whole_directory(here / "out"),
        ):
            pytest.fail("nothing can be written there")
        assert not (here / "out").exists()
