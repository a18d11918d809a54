"""What moves freely, in words that a designer understands."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.network import FreeMotion
from stiffkit.spatial import Screw

Array = NDArray[np.float64]


def describe_free_motion(motion: FreeMotion, tool: Array, length: float) -> str:
    """Return a sentence on a motion that nothing holds.

    ``tool`` (6,) is the tool pose, ``length`` (m) the robot's size.
    """
    joints = motion.joints
    if not np.any(motion.twist):
        where = "at" if len(joints) == 1 else "between"
        return f"what hangs {where} {_listed(joints)} can spin or shift, without any effect"
    screw = Screw.of_twist(motion.twist, tool[:3], length)
    words = f"the tool {screw.describe()} with all drives locked"
    return f"{words} (moving: {_listed(joints)})" if joints else words


def _listed(names: list[str]) -> str:
    if len(names) > 6:
        names = [*names[:5], f"{len(names) - 5} more"]
    return ", ".join(names)
