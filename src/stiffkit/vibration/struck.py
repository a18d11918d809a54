"""Passive joints as Briot et al. 2009 make them, for comparison with the paper."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stiffkit.link.superelement import Struck, lumped_superelement
from stiffkit.robot import BASE, Freedom, Joint, Link, Robot
from stiffkit.vibration.bodies import link_line

Array = NDArray[np.float64]


def struck_robot(robot: Robot, n_elements: int) -> Robot:
    """Return the robot with its links lumped and passive directions struck out of their springs.

    S. Briot, A. Pashkevich, D. Chablat, 2009, eq. 25: the stiffness of the spring beside a passive
    joint loses the rows and columns of the passive directions, instead of being condensed. The
    spring is that of the link on the joint's ``to`` side, or on its ``from`` side if that one has
    no springs. Raises LinkError where a link cannot be lumped.
    """
    passive: dict[str, dict[str, list[Array]]] = {}
    for joint in robot.joints.values():
        for body, port, directions in _sides(joint):
            if body != BASE and _is_lumped(robot.links[body]):
                passive.setdefault(body, {}).setdefault(port, []).append(directions)
                break
    links = {
        name: _struck(link, passive.get(name, {}), n_elements) if _is_lumped(link) else link
        for name, link in robot.links.items()
    }
    return replace(robot, links=links)


def _is_lumped(link: Link) -> bool:
    has_line = link.compliance is not None and bool(link.mass) and link.superelement is None
    return has_line and link_line(link) is not None


def _sides(joint: Joint) -> Iterator[tuple[str, str, Array]]:
    """Yield body, port and passive directions (6, n) in link axes, of both sides of a joint."""
    passive = [i for i, freedom in enumerate(joint.freedoms) if freedom is Freedom.PASSIVE]
    if not passive:
        return
    for body, port, frame in (
        (joint.to_body, joint.to_port, joint.T_to_joint),
        (joint.from_body, joint.from_port, joint.T_from_joint),
    ):
        yield body, port, np.asarray(np.kron(np.eye(2), frame.rotation)[:, passive])


def _struck(link: Link, passive: dict[str, list[Array]], n_elements: int) -> Link:
    """Return an elastic link whose superelement has the passive directions of its joints struck."""
    line = link_line(link)
    if line is None:
        return link
    none = np.zeros((6, 0))
    at_base, at_tip = (np.hstack([none, *passive.get(port, [])]) for port in link.ports)
    struck = Struck(at_base, at_tip)
    element = lumped_superelement(line, n_elements, None, struck)
    if link.line is None:
        element = replace(element, rule=f"{element.rule}; the compliance is the equivalent beam's")
    return replace(link, compliance=element.compliance, superelement=element)
