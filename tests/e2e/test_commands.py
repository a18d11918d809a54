"""Every command does what its help says, from an empty directory."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stiffkit
from stiffkit.robot import describe_robots

from .commandline import STIFFKIT, output_of, run

COMMANDS = (
    *("robots", "check", "pose", "modes", "map"),
    *("identify", "advise", "parts", "reproduce", "schema", "completion"),
)


def pose_of(*arguments: str, cwd: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(output_of("pose", *arguments, "--json", cwd=cwd))
    return found


class TestHelp:
    def test_lists_all_commands_and_a_first_look(self, tmp_path: Path) -> None:
        shown = output_of("--help", cwd=tmp_path)
        listed = [line.split()[0] for line in shown.partition("Commands:")[2].splitlines() if line]
        assert set(COMMANDS) <= set(listed)
        assert "stiffkit map biglide" in shown

    @pytest.mark.parametrize("command", COMMANDS)
    def test_has_an_example(self, command: str, tmp_path: Path) -> None:
        shown = output_of(command, "--help", cwd=tmp_path)
        example = shown.partition("Example:")[2]
        assert f"stiffkit {command}" in example

    def test_no_command_shows_help(self, tmp_path: Path) -> None:
        ended = run(cwd=tmp_path)
        assert ended.returncode == 2
        assert "Commands:" in ended.stderr

    def test_version(self, tmp_path: Path) -> None:
        assert output_of("--version", cwd=tmp_path).split()[-1] == stiffkit.__version__


class TestRobots:
    def test_lists_the_catalogue(self, tmp_path: Path) -> None:
        lines = output_of("robots", cwd=tmp_path).splitlines()
        assert [line.split()[0] for line in lines] == list(stiffkit.list_robots())
        assert {"biglide", "five-bar", "delta", "3-puu", "hexapod-cubic"} <= {
            line.split()[0] for line in lines
        }

    def test_schema_is_the_published_one(self, tmp_path: Path) -> None:
        schema = json.loads(output_of("schema", cwd=tmp_path))
        assert schema["$schema"].startswith("https://json-schema.org/")
        assert {"links", "joints", "tool", "home", "workspace", "loads"} <= set(
            schema["properties"]
        )


@pytest.mark.parametrize("robot", [robot.name for robot in describe_robots() if not robot.from_cad])
def test_check_tells_the_structure(robot: str, tmp_path: Path) -> None:
    shown = output_of("check", robot, cwd=tmp_path)
    facts = dict(line.split("  ", 1) for line in shown.splitlines() if "  " in line)
    assert facts["robot"].strip() == stiffkit.load_robot(robot).title
    counted = int(facts["mobility, counted"].split()[0])
    at_home = int(facts["mobility at home"].split()[0].rstrip(","))
    assert at_home - counted == int(facts["degree of over-constraint"])
    assert facts["free motions"].strip() == "none"
    assert list(tmp_path.iterdir()) == []


class TestPose:
    def test_text_shows_deflections_and_matrices(self, tmp_path: Path) -> None:
        shown = output_of(
            "pose", "biglide", "--at", "x=0.4975,y=0", "--load", "fz=1000", cwd=tmp_path
        )
        assert "x 497.5 mm, y 0 mm" in shown
        deflection = next(line for line in shown.splitlines() if "fz=1000" in line).split()
        result = stiffkit.analyse_pose(stiffkit.load_robot("biglide"), {"x": 0.4975, "y": 0.0})
        assert result.compliance is not None
        np.testing.assert_allclose(float(deflection[3]), 1e9 * result.compliance[2, 2], rtol=1e-3)
        assert "compliance (m/N" in shown
        assert "stiffness (N/m" in shown

    @pytest.mark.parametrize("model", ["refined", "simplified"])
    def test_json_agrees_with_the_api(self, model: str, tmp_path: Path) -> None:
        found = pose_of("biglide", "--at", "x=0.4,y=0.1", "--model", model, cwd=tmp_path)
        result = stiffkit.analyse_pose(
            stiffkit.load_robot("biglide"),
            {"x": 0.4, "y": 0.1},
            model="simplified" if model == "simplified" else "refined",
        )
        assert (found["status"], found["model"], found["robot"]) == ("ok", model, "biglide")
        assert result.compliance is not None
        np.testing.assert_allclose(found["compliance"], result.compliance, rtol=1e-12)
        for name in ("f_x", "f_y", "f_z"):
            np.testing.assert_allclose(found["deflections"][name], result.deflections[name])
        if model == "simplified":
            # What has no compliance in the model has no finite stiffness.
            assert found["stiffness"] is None
        else:
            assert result.stiffness is not None
            np.testing.assert_allclose(found["stiffness"], result.stiffness, rtol=1e-12)

    def test_json_is_si_in_world_axes_at_the_tool_translation_first(self, tmp_path: Path) -> None:
        # Two drives at right angles carry a slide: 1/1e6 m/N along x, 1/4e6 m/N along y, and the
        # tool 0.5 m out along x turns with the arm, which a torsion spring of 1e3 N m/rad holds.
        (tmp_path / "slides.yaml").write_text(
            """\
robot: Two slides and a turntable
links:
  cross: {rigid: {ports: {}}}
  table: {rigid: {ports: {}}}
  arm: {rigid: {length: 500 mm}}
joints:
  along_x: {prismatic: x, from: base, to: cross, drive: 1 N/um}
  along_y: {prismatic: y, from: cross, to: table, drive: 4 N/um}
  turn: {revolute: z, from: table, to: arm.base, drive: 1e3 N m/rad}
tool: {at: arm.tip}
home: {turn: 0}
""",
            encoding="utf-8",
        )
        found = pose_of("slides.yaml", "--load", "fy=1kN", cwd=tmp_path)
        k = np.zeros((6, 6))
        k[0, 0], k[1, 1] = 1e-6, 0.25e-6 + 0.5**2 / 1e3
        k[5, 5], k[1, 5], k[5, 1] = 1e-3, 0.5e-3, 0.5e-3
        np.testing.assert_allclose(found["compliance"], k, rtol=1e-9, atol=1e-18)
        np.testing.assert_allclose(
            found["deflections"]["fy=1kN"], 1000.0 * k[:, 1], rtol=1e-9, atol=1e-15
        )

    def test_coordinates_with_units_are_the_same_as_si(self, tmp_path: Path) -> None:
        si = pose_of("hexapod-cubic", "--at", "x=0.02,rz=0.1", cwd=tmp_path)
        units = pose_of(
            "hexapod-cubic", "--at", "x=20mm", "--at", f"rz={np.degrees(0.1)}deg", cwd=tmp_path
        )
        np.testing.assert_allclose(si["tool"]["x"], 0.02, rtol=1e-12)
        np.testing.assert_allclose(si["tool"]["rz"], 0.1, rtol=1e-12)
        np.testing.assert_allclose(units["compliance"], si["compliance"], rtol=1e-9, atol=1e-20)

    def test_dependent_coordinates_follow(self, tmp_path: Path) -> None:
        at_x_y = pose_of("five-bar", "--at", "x=0.05,y=0.38", cwd=tmp_path)
        turned = at_x_y["tool"]["rz"]
        assert at_x_y["tool"]["z"] == 0.0
        # Asked for, a coordinate that would follow becomes one that is chosen.
        at_x_rz = pose_of("five-bar", "--at", f"x=0.05,rz={turned!r}", cwd=tmp_path)
        assert abs(at_x_rz["tool"]["y"] - 0.38) < 1e-8
        np.testing.assert_allclose(
            at_x_rz["compliance"], at_x_y["compliance"], rtol=1e-6, atol=1e-15
        )

    def test_loads_by_name_and_inline(self, tmp_path: Path) -> None:
        found = pose_of(
            "biglide", "--load", "f_z", "--load", "fz=1kN", "--load", "mx=2 N m,fy=-3", cwd=tmp_path
        )
        k = np.array(found["compliance"])
        loads = found["deflections"]
        assert list(loads) == ["f_z", "fz=1kN", "mx=2 N m,fy=-3"]
        assert loads["f_z"] == loads["fz=1kN"]
        np.testing.assert_allclose(loads["mx=2 N m,fy=-3"], k @ [0, -3, 0, 2, 0, 0], rtol=1e-12)

    def test_parameters_can_be_replaced(self, tmp_path: Path) -> None:
        stiff = pose_of("biglide", "--model", "simplified", cwd=tmp_path)
        soft = pose_of("biglide", "--model", "simplified", "--set", "drive=1e5 N/mm", cwd=tmp_path)
        np.testing.assert_allclose(
            soft["compliance"], 10.0 * np.array(stiff["compliance"]), rtol=1e-9, atol=1e-25
        )

    def test_out_of_reach_is_a_status_and_no_number(self, tmp_path: Path) -> None:
        found = pose_of("five-bar", "--at", "y=2", cwd=tmp_path)
        assert found["status"] == "unreachable"
        assert "y = 2 m" in found["reason"]
        assert found["compliance"] is None
        assert found["stiffness"] is None
        assert set(found["tool"].values()) == {None}
        assert "unreachable" in output_of("pose", "five-bar", "--at", "y=2", cwd=tmp_path)


class TestMap:
    def test_writes_all_and_nothing_else(self, biglide_map: Path) -> None:
        assert sorted(p.name for p in biglide_map.iterdir()) == ["figures", "map.nc", "report.html"]
        assert [p.name for p in biglide_map.parent.iterdir()] == [biglide_map.name]
        figures = list((biglide_map / "figures").iterdir())
        assert {p.stem for p in figures if p.suffix == ".png"} == {
            p.stem for p in figures if p.suffix == ".svg"
        }
        assert {p.suffix for p in figures} == {".png", ".svg"}
        for figure in figures:
            start = figure.read_bytes()[:1000]
            assert start.startswith(b"\x89PNG") if figure.suffix == ".png" else b"<svg" in start

    def test_dataset_agrees_with_pose(self, biglide_map: Path, tmp_path: Path) -> None:
        dataset = stiffkit.open_map(biglide_map)
        assert (dataset["status"] == 0).all()
        robot = stiffkit.load_robot("biglide")
        for i, j in ((0, 0), (5, 3), (9, 11), (-1, -1)):
            x, y = float(dataset["x"][i]), float(dataset["y"][j])
            for model in ("refined", "simplified"):
                here = dataset.sel(model=model).isel(x=i, y=j)
                posed = stiffkit.analyse_pose(
                    robot, {"x": x, "y": y}, model="refined" if model == "refined" else "simplified"
                )
                assert posed.compliance is not None
                k = here["compliance"].transpose("direction", "direction_load").to_numpy()
                scale = np.sqrt(np.outer(np.diag(k), np.diag(k)))
                np.testing.assert_allclose(
                    posed.compliance, k, rtol=1e-9, atol=1e-9 * float(scale.max())
                )
        x, y = float(dataset["x"][5]), float(dataset["y"][3])
        found = pose_of("biglide", "--at", f"x={x!r},y={y!r}", cwd=tmp_path)
        here = dataset.sel(model="refined").isel(x=5, y=3)
        for load, deflection in found["deflections"].items():
            np.testing.assert_allclose(
                here["deflection"].sel(load=load), deflection, rtol=1e-6, atol=1e-15
            )
            np.testing.assert_allclose(
                here["deflection_translation"].sel(load=load),
                np.linalg.norm(deflection[:3]),
                rtol=1e-9,
            )

    def test_says_what_is_out_of_reach(self, small_robot: Path) -> None:
        text = small_robot.read_text(encoding="utf-8").replace("[200 mm, 400 mm]", "[3, 4]")
        small_robot.write_text(text, encoding="utf-8")
        shown = output_of("map", small_robot.name, "--points", "9", cwd=small_robot.parent)
        assert "0 of 9 postures have an answer" in shown
        assert "9 (100 %) are out of reach" in shown

    def test_names_the_report_and_keeps_what_is_not_its_own(self, small_robot: Path) -> None:
        here = small_robot.parent
        first = output_of("map", small_robot.name, "--points", "9", cwd=here)
        report = here / first.splitlines()[-1].removeprefix("open ")
        assert report == here / "stiffkit-two-arms" / "report.html"
        notes = report.with_name("notes.txt")
        notes.write_text("mine", encoding="utf-8")
        (report.parent / "figures" / "old.svg").touch()
        output_of("map", small_robot.name, "--points", "11", cwd=here)
        assert stiffkit.open_map(report.parent).sizes["x"] == 11
        assert notes.read_text(encoding="utf-8") == "mine"
        assert not (report.parent / "figures" / "old.svg").exists()
        assert sorted(p.name for p in here.iterdir()) == ["stiffkit-two-arms", "two-arms.yaml"]


class TestPipes:
    def test_a_reader_that_has_enough_is_no_error(self, tmp_path: Path) -> None:
        reading, writing = os.pipe()
        os.close(reading)
        try:
            ended = subprocess.run(
                [STIFFKIT, "robots"],
                cwd=tmp_path,
                stdout=writing,
                stderr=subprocess.PIPE,
                timeout=60,
                check=False,
            )
        finally:
            os.close(writing)
        assert ended.stderr == b""

    def test_a_full_disk_is_told(self, tmp_path: Path) -> None:
        with Path("/dev/full").open("wb") as full:
            ended = subprocess.run(
                [STIFFKIT, "schema"],
                cwd=tmp_path,
                stdout=full,
                stderr=subprocess.PIPE,
                timeout=60,
                check=False,
            )
        assert ended.returncode == 2
        assert ended.stderr == b"error: the output cannot be written: No space left on device\n"


class TestCompletion:
    @pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
    def test_script(self, shell: str, tmp_path: Path) -> None:
        script = output_of("completion", shell, cwd=tmp_path)
        assert f"_STIFFKIT_COMPLETE={shell}_complete" in script
        if shutil.which(shell):
            checked = subprocess.run([shell, "-n"], input=script, text=True, check=False)
            assert checked.returncode == 0

    @pytest.mark.parametrize(
        ("words", "expected"),
        [
            ("stiffkit ma", {"map"}),
            ("stiffkit check biglide-e", {"biglide-elastic-tool"}),
            ("stiffkit pose biglide --mod", {"--model"}),
            ("stiffkit pose biglide --model s", {"simplified"}),
        ],
    )
    def test_in_bash(self, words: str, expected: set[str], tmp_path: Path) -> None:
        script = output_of("completion", "bash", cwd=tmp_path)
        typed = words.split()
        # bash itself provides `compopt`, but only while it completes.
        asked = f"""
compopt() {{ :; }}
{script}
COMP_WORDS=({words}); COMP_CWORD={len(typed) - 1}
_stiffkit_completion {STIFFKIT}
printf '%s\\n' "${{COMPREPLY[@]}}"
"""
        ended = subprocess.run(
            ["bash", "-c", asked], cwd=tmp_path, capture_output=True, text=True, check=True
        )
        assert set(ended.stdout.split()) == expected
        assert ended.stderr == ""
