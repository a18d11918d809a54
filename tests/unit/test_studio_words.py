"""What the studio says beside the scene, and what it lets in and writes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffkit.errors import OutputError, StiffkitError
from stiffkit.kinematics import Status
from stiffkit.plots import Kind
from stiffkit.plots.scale import Scale
from stiffkit.studio import legend, numbers
from stiffkit.studio.looks import NO_ANSWER, map_colours
from stiffkit.studio.saving import Saver
from stiffkit.studio.server import is_allowed, start_server


def test_a_compliance_has_a_unit_for_each_block() -> None:
    k = np.diag([2e-8, 3e-8, 4e-8, 5e-5, 6e-5, 7e-5])
    k[0, 4] = k[4, 0] = 1.5e-6
    table = numbers.compliance_table(k)
    assert "<td>20</td>" in table
    assert "nm/N" in table
    assert "1.5" in table
    assert "µrad/N" in table
    assert "<td>70</td>" in table
    assert "µrad/(N m)" in table


def test_numbers_beside_pinned_ones_tell_the_change() -> None:
    told = numbers.row("weakest", [1.1e6, 1.0e6], Kind.STIFFNESS)
    assert told == ("weakest (N/µm)", ["1.1", "1", "+10.0 %"])
    assert numbers.row("weakest", [1.1e6], Kind.STIFFNESS) == ("weakest", ["1.1 N/µm"])
    assert numbers.row("weakest", [1.0, 0.0], Kind.STIFFNESS)[1][2] == "–"
    assert numbers.row("mode 1", [np.nan], Kind.FREQUENCY)[1] == ["– Hz"]


def test_text_is_never_markup() -> None:
    text = "<script>alert(1)</script>"
    for piece in (
        numbers.paragraph(text),
        numbers.heading(text),
        numbers.table([(text, [text])], [text]),
        legend.worst_key(text),
    ):
        assert "<script" not in piece


def test_ticks_of_a_legend_are_round_and_do_not_touch() -> None:
    values = np.geomspace(1.0, 900.0, 50)
    scale = Scale.of(values)
    bar = legend.colour_bar(scale, values, "µm")
    ticks = [float(part.split("<")[0]) for part in bar.split('fill="#222">')[1:]]
    assert len(ticks) >= 3
    assert set(ticks) <= {m * 10.0**d for m in (1, 2, 5) for d in range(4)}
    places = [float(scale.norm(tick)) for tick in ticks]
    assert np.diff(places).min() > 0.1


def test_colours_tell_values_apart_and_answers_from_none() -> None:
    values = np.array([1.0, 2.0, 3.0, np.nan, np.nan])
    status = np.array([0, 0, 0, Status.UNREACHABLE, Status.SINGULAR], dtype=np.int8)
    colours = map_colours(values, status, Scale.of(values))
    assert len({tuple(c) for c in colours}) == 5
    assert tuple(colours[3]) == NO_ANSWER[Status.UNREACHABLE]
    assert tuple(colours[4]) == NO_ANSWER[Status.SINGULAR]
    # From dark to light, so that they can be told apart in grey.
    grey = colours[:3] @ np.array([0.3, 0.59, 0.11])
    assert np.all(np.diff(grey) > 20)


@pytest.mark.parametrize(
    ("host", "headers", "allowed"),
    [
        ("127.0.0.1", {"Host": "127.0.0.1:80"}, True),
        ("127.0.0.1", {"Host": "localhost:80", "Origin": "http://localhost:80"}, True),
        ("127.0.0.1", {"Host": "localhost:80", "Origin": "http://localhost:81"}, False),
        ("127.0.0.1", {"Host": "evil.example"}, False),
        ("127.0.0.1", {"Host": "10.0.0.1:80"}, False),
        ("127.0.0.1", {}, False),
        ("127.0.0.1", {"Host": "127.0.0.1:80", "Origin": "null"}, False),
        ("0.0.0.0", {"Host": "10.0.0.1:80", "Origin": "http://10.0.0.1:80"}, True),  # noqa: S104
        ("0.0.0.0", {"Host": "evil.example:80"}, False),  # noqa: S104
        ("robot.lan", {"Host": "robot.lan:80"}, True),
    ],
)
def test_only_own_requests_are_answered(host: str, headers: dict[str, str], allowed: bool) -> None:
    assert is_allowed(headers, host) is allowed


def test_an_address_that_is_none_is_told() -> None:
    with pytest.raises(StiffkitError, match="nothing can listen at"):
        start_server("203.0.113.1", 0)


@pytest.mark.parametrize(
    "name", ["", "..", "../a", "a/b", "/etc/a", ".hidden", "a\0b", "a\nb", "x" * 200]
)
def test_names_that_lead_elsewhere_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(OutputError, match="cannot be the name of a file"):
        Saver(tmp_path, "five-bar").robot_file(name, {})
    assert list(tmp_path.iterdir()) == []


def test_what_is_there_is_kept(tmp_path: Path) -> None:
    outside = tmp_path / "outside.yaml"
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "a.yaml").symlink_to(outside)
    (folder / "a-2.yaml").write_text("mine")
    written = Saver(folder, "five-bar").robot_file("a", {"base": 0.25})
    assert written.name == "a-3.yaml"
    assert "250" in written.read_text()
    assert not outside.exists()
    assert (folder / "a-2.yaml").read_text() == "mine"


def test_a_folder_that_is_none_is_told(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="is no folder"):
        Saver(tmp_path / "missing", "five-bar")
