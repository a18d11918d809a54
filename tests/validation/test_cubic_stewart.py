"""The cubic Gough-Stewart platform in closed form.

Z. J. Geng, L. S. Haynes, "Six degree-of-freedom active vibration control using the Stewart
platforms", IEEE Transactions on Control Systems Technology 2(1), 1994: six legs of stiffness c
along the edges of a cube of side a that touch neither its lowest nor its highest corner. With n_i
the directions of the legs and m_i their moments about the cube's centre,

    sum n n^T = 2 I,   sum m n^T = 0,   sum m m^T = a^2/2 (I + u u^T * 3),  u the cube's diagonal,

since each pair of parallel edges has opposite moments a/2 (1, 0, 1) and its permutations in the
cube's axes: eigenvalues 2 a^2 about the diagonal and a^2/2 across it.
"""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.robot import Robot, load_robot
from stiffkit.spatial import skew
from stiffkit.study import analyse_pose

Array = NDArray[np.float64]

SIDE, DRIVE = 0.4, 1e7  # m, N/m


def closed_form(c: float, offset: Array) -> Array:
    """Stiffness about a point ``offset`` (3,) from the cube's centre, diagonal along z."""
    K = np.zeros((6, 6))
    K[:3, :3] = 2 * c * np.eye(3)
    K[3:, 3:] = c * SIDE**2 * np.diag([0.5, 0.5, 2.0])
    # The twist at the centre is that at the point, carried back over the offset.
    X = np.eye(6)
    X[:3, 3:] = skew(offset)
    return np.asarray(X.T @ K @ X)


def cubic(directory: Path, offset: Array, rigid: bool) -> Robot:
    text = files("stiffkit.robot").joinpath("catalogue/hexapod-cubic.yaml").read_text()
    text = text.replace(
        "tool: {at: platform}", f"tool: {{at: platform, offset: {offset.tolist()}}}"
    ).replace(
        "home: {x: 0, y: 0, z: = half",
        f"home: {{x: {offset[0]}, y: {offset[1]}, z: = half + {offset[2]}",
    )
    if rigid:
        for part, length in (("barrel", "0.6"), ("rod", "0.4")):
            start = text.index(f'"{part}_{{k}}": {{beam')
            end = text.index("\n", start)
            text = (
                text[:start]
                + f'"{part}_{{k}}": {{rigid: {{length: = {length} * edge}}}}'
                + text[end:]
            )
    path = directory / "cubic.yaml"
    path.write_text(text)
    return load_robot(path)


def leg_compliance(robot: Robot, rigid: bool) -> float:
    """Drive, barrel and rod in series: a leg between two ball-like ends carries only its axis."""
    elastic = [robot.links[name].compliance for name in ("barrel_1", "rod_1")]
    return 1 / DRIVE + sum(float(k[0, 0]) for k in elastic if k is not None and not rigid)


@pytest.mark.parametrize("rigid", [True, False], ids=["drives only", "elastic legs"])
@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0), (0.0, 0.0, 0.15), (0.03, -0.07, 0.11)])
def test_stiffness_about_any_point(
    tmp_path: Path, offset: tuple[float, float, float], rigid: bool
) -> None:
    d = np.array(offset)
    robot = cubic(tmp_path, d, rigid)
    c = 1.0 / leg_compliance(robot, rigid)
    K = analyse_pose(robot).stiffness
    assert K is not None
    expected = closed_form(c, d)
    scale = np.diag([1, 1, 1, 1 / SIDE, 1 / SIDE, 1 / SIDE])
    assert np.abs(scale @ (K - expected) @ scale).max() < 1e-9 * 2 * c


def test_translational_stiffness_is_twice_a_leg_in_every_direction() -> None:
    result = analyse_pose(load_robot("hexapod-cubic"), model="simplified")
    assert result.translation is not None
    assert result.translation.stiffness == pytest.approx([2 * DRIVE] * 3, rel=1e-9)
    assert result.rotation is not None
    assert result.rotation.stiffness == pytest.approx(
        [DRIVE * SIDE**2 / 2, DRIVE * SIDE**2 / 2, 2 * DRIVE * SIDE**2], rel=1e-9
    )
