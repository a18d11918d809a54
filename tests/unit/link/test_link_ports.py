"""Link files of links with more than two ports."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.errors import FileError
from stiffkit.link import MATERIALS, Superelement, beam_compliance, beam_line, round_bar
from stiffkit.link.file import LinkFile, read_link_file, write_link_file
from stiffkit.link.ports import places_of, relative_to_base
from stiffkit.link.superelement import consistent_superelement
from stiffkit.spatial import Frame, axis_rotation, twist_shift

Array = NDArray[np.float64]

HALF = 0.1
STEEL = MATERIALS["steel"]
SECTION = round_bar(0.02)

TURN = np.kron(np.eye(2), axis_rotation("z", np.pi))
"""The right half of the axle points along -x."""

PORTS = {
    "left": Frame.at(HALF),
    "right": Frame(axis_rotation("z", np.pi), np.array([-HALF, 0.0, 0.0])),
}


def axle() -> Superelement:
    """Return an axle of two half beams whose inner ends are its base, with two modes of each."""
    half = consistent_superelement(
        beam_line(HALF, SECTION, STEEL, STEEL.density * SECTION.area * HALF), 4, 2
    )
    k = beam_compliance(HALF, SECTION, STEEL)
    compliance, mass = np.zeros((12, 12)), np.zeros((22, 22))
    for at, turn in enumerate((np.eye(6), TURN)):
        own = slice(6 * at, 6 * at + 6)
        compliance[own, own] = turn @ k @ turn.T
        rows = np.r_[0:6, 6 + 6 * at : 12 + 6 * at, 18 + 2 * at : 20 + 2 * at]
        whole = np.eye(14)
        whole[:6, :6] = whole[6:12, 6:12] = turn.T
        mass[np.ix_(rows, rows)] += whole.T @ half.mass @ whole
    values = np.tile(half.mode_stiffness, 2)
    # Modes in pairs of one frequency may come back in another order, but not by their stiffness.
    return Superelement(compliance, values, mass[:22, :22], "axle")


def axle_link(element: Superelement | None) -> LinkFile:
    return LinkFile("Axle", PORTS, axle().compliance, superelement=element, mass=1.0)


def message_of(path: Path) -> str:
    with pytest.raises(FileError) as caught:
        read_link_file(path)
    assert caught.value.line
    return f"{caught.value.key}: {caught.value}"


def test_relative_twists_vanish_for_rigid_motions() -> None:
    places = np.random.default_rng(0).normal(size=(3, 3))
    motion = np.vstack([np.eye(6), *(twist_shift(place) for place in places)])
    np.testing.assert_allclose(relative_to_base(places) @ motion, 0.0, atol=1e-15)


def test_every_port_comes_back(tmp_path: Path) -> None:
    path = tmp_path / "axle.link.yaml"
    write_link_file(axle_link(None), path)
    found = read_link_file(path)
    assert list(found.ports) == ["left", "right"]
    np.testing.assert_array_equal(found.compliance, axle().compliance)
    for name, frame in PORTS.items():
        np.testing.assert_allclose(found.ports[name].position, frame.position)
        np.testing.assert_allclose(found.ports[name].rotation, frame.rotation, atol=1e-15)
    assert (found.mass, found.notes) == (1.0, ())


def test_the_superelement_of_three_ports_comes_back(tmp_path: Path) -> None:
    path = tmp_path / "axle.link.yaml"
    given = axle()
    write_link_file(LinkFile("Axle", PORTS, given.compliance, superelement=given), path)
    found = read_link_file(path)
    assert found.superelement is not None
    assert found.notes == ()
    assert found.superelement.mass.shape == (22, 22)
    scale = np.sqrt(np.diag(given.compliance))
    np.testing.assert_allclose(
        found.superelement.compliance / np.outer(scale, scale),
        given.compliance / np.outer(scale, scale),
        atol=1e-9,
    )
    np.testing.assert_allclose(
        np.sort(found.superelement.mode_stiffness), np.sort(given.mode_stiffness), rtol=1e-8
    )
    # Mass and inertia of the whole axle: a rod about its middle.
    mass = 2.0 * STEEL.density * SECTION.area * HALF
    assert found.mass == pytest.approx(mass, rel=1e-9)
    assert found.center_of_mass is not None
    assert found.inertia is not None
    np.testing.assert_allclose(found.center_of_mass, 0.0, atol=1e-12)
    about = mass * (2.0 * HALF) ** 2 / 12.0 + 2.0 * STEEL.density * SECTION.Iz * HALF
    assert found.inertia[2, 2] == pytest.approx(about, rel=1e-9)


def test_millimetres_of_every_port(tmp_path: Path) -> None:
    """Both matrices by coordinates: mm and rad at each port, any unit of the modes."""
    given = axle()
    K, M = given.stiffness(places_of(PORTS)), given.mass
    scale = np.ones(len(K))
    scale[:18] = np.tile([1e-3] * 3 + [1.0] * 3, 3)
    for name, matrix in (("K.csv", K), ("M.csv", M)):
        np.savetxt(tmp_path / name, 1e3 * matrix * np.outer(scale, scale))
    path = tmp_path / "axle.link.yaml"
    path.write_text(
        "link: Axle\nsuperelement:\n  stiffness: K.csv\n  mass: M.csv\n  units: mm\n  ports:\n"
        "    left: {at: [100 mm, 0, 0]}\n    right: {at: [-100 mm, 0, 0], rotate: {z: 180 deg}}\n"
    )
    found = read_link_file(path)
    size = np.sqrt(np.diag(given.compliance))
    np.testing.assert_allclose(
        found.compliance / np.outer(size, size), given.compliance / np.outer(size, size), atol=1e-9
    )


def given_axle(matrix: Array, ports: str = "{left: {at: [0.1, 0, 0]}, right: {}}") -> str:
    return f"link: Axle\ncompliance: {{matrix: {json.dumps(matrix.tolist())}, ports: {ports}}}\n"


def indefinite() -> Array:
    k = axle().compliance
    k[2, 8] = k[8, 2] = -2.0 * np.sqrt(k[2, 2] * k[8, 8])
    return k


def coupled_too_much() -> Array:
    """Return a compliance each of whose pairs of entries may be, and that is no body's."""
    k = axle().compliance
    for i, j in ((0, 3), (3, 6), (0, 6)):
        k[i, j] = k[j, i] = -0.9 * np.sqrt(k[i, i] * k[j, j])
    return k


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (given_axle(axle().compliance, "{left: {}}"), "12 values, 6 are expected"),
        (given_axle(axle().compliance[:, :11]), "matrix[0]: "),
        (given_axle(axle().compliance, "{base: {}, tip: {}}"), "ports.base: "),
        (given_axle(axle().compliance, "{}"), "nothing is given"),
        (given_axle(axle().compliance, "{a b: {}, c: {}}"), "not allowed here"),
        (given_axle(axle().compliance, "{a: {}, a: {}}"), "a second time"),
        (given_axle(indefinite()), "entries 3,3"),
        (given_axle(coupled_too_much()), "Fx at left"),
        (
            given_axle(axle().compliance).replace("ports:", "tip: {}, ports:"),
            "'tip' and 'ports' are both given",
        ),
        (
            given_axle(axle().compliance) + f"covariance: {json.dumps(np.eye(36).tolist())}\n",
            "with two ports only",
        ),
    ],
)
def test_ports_and_matrices_that_do_not_fit(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "bad.link.yaml"
    path.write_text(text)
    assert words in message_of(path)


def test_repairs_reach_every_port(tmp_path: Path) -> None:
    k = axle().compliance
    right = k[10, 10]
    k[10, 10] *= -1.0
    path = tmp_path / "axle.link.yaml"
    text = given_axle(k).replace("ports:", f'repair: {{entries: {{"11,11": {right}}}}}, ports:')
    path.write_text(text)
    found = read_link_file(path)
    np.testing.assert_array_equal(found.compliance, axle().compliance)
    assert "entry (11,11) replaced" in found.notes[0]


def write_matrices(folder: Path, K: Array, M: Array, right: str = "[-0.1, 0, 0]") -> Path:
    np.savetxt(folder / "K.csv", K)
    np.savetxt(folder / "M.csv", M)
    path = folder / "bad.link.yaml"
    ports = f"{{left: {{at: [0.1, 0, 0]}}, right: {{at: {right}}}}}"
    path.write_text(f"link: x\nsuperelement: {{stiffness: K.csv, mass: M.csv, ports: {ports}}}\n")
    return path


def test_superelements_that_no_link_with_three_ports_has(tmp_path: Path) -> None:
    given = axle()
    K, M = given.stiffness(places_of(PORTS)), given.mass
    assert read_link_file(write_matrices(tmp_path, K, M)).notes == ()
    wrong_place = message_of(write_matrices(tmp_path, K, M, "[-0.2, 0, 0]"))
    assert "right x y z rx ry rz" in wrong_place
    assert "places of the ports" in wrong_place
    loose = K.copy()
    loose[12:18, :], loose[:, 12:18] = 0.0, 0.0
    assert "does not hold its right" in message_of(write_matrices(tmp_path, loose, M))
    half = np.r_[0:12]
    few = message_of(write_matrices(tmp_path, K[np.ix_(half, half)], M[np.ix_(half, half)]))
    assert "base, left and right alone need 18" in few


def test_compliance_and_superelement_name_the_same_ports(tmp_path: Path) -> None:
    path = tmp_path / "axle.link.yaml"
    write_link_file(axle_link(axle()), path)
    text = path.read_text()
    head, _, tail = text.partition("superelement:")
    path.write_text(f"{head}superelement:{tail.replace('right:', 'other:')}")
    assert "not those of the superelement" in message_of(path)
