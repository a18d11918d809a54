"""The mechanism as a graph: a spanning tree of bodies, and the joints that close its loops."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import dataclass

from stiffkit.robot import BASE, Freedom, Joint, Robot


@dataclass(frozen=True, eq=False)
class TreeJoint:
    """A joint of the tree, seen from the base."""

    joint: Joint
    parent: str
    child: str
    coordinates: slice
    """Where its coordinates are among those of the tree."""

    @property
    def forward(self) -> bool:
        """Whether the child is the joint's ``to`` body."""
        return self.joint.to_body == self.child


@dataclass(frozen=True, eq=False)
class SpanningTree:
    """All bodies hung from the base by as few joint coordinates as can be."""

    robot: Robot
    joints: tuple[TreeJoint, ...]
    """In an order in which each parent comes before its children."""
    chords: tuple[Joint, ...]
    """The joints left over; each closes a loop."""
    n_coordinates: int

    @staticmethod
    def of(robot: Robot) -> SpanningTree:
        """Return the tree that keeps joints with few motions and leaves those with many as chords.

        A loop closed by a spherical joint costs three equations and no coordinate, where keeping
        the joint would cost six equations and three coordinates. Driven joints come before all
        others, so that the drives' coordinates are among the tree's.
        """
        ranked = sorted(
            robot.joints.values(),
            key=lambda joint: (Freedom.DRIVEN not in joint.freedoms, len(joint.motions)),
        )
        kept = _spanning_forest(ranked)
        order = {name: i for i, name in enumerate(robot.joints)}
        neighbours: dict[str, list[tuple[Joint, str]]] = {}
        for joint in sorted(kept, key=lambda joint: order[joint.name]):
            neighbours.setdefault(joint.from_body, []).append((joint, joint.to_body))
            neighbours.setdefault(joint.to_body, []).append((joint, joint.from_body))
        joints: list[TreeJoint] = []
        reached, queue, n = {BASE}, [BASE], 0
        while queue:
            parent = queue.pop(0)
            for joint, child in neighbours.get(parent, []):
                if child in reached:
                    continue
                end = n + len(joint.motions)
                joints.append(TreeJoint(joint, parent, child, slice(n, end)))
                reached.add(child)
                queue.append(child)
                n = end
        in_tree = {tree_joint.joint.name for tree_joint in joints}
        chords = tuple(joint for name, joint in robot.joints.items() if name not in in_tree)
        return SpanningTree(robot, tuple(joints), chords, n)

    def path(self, body: str) -> list[TreeJoint]:
        """Return the tree joints from the base to a body, in that order."""
        by_child = {tree_joint.child: tree_joint for tree_joint in self.joints}
        path: list[TreeJoint] = []
        while body != BASE:
            path.append(by_child[body])
            body = path[-1].parent
        return path[::-1]

    def loop(self, chord: Joint) -> tuple[list[TreeJoint], list[TreeJoint]]:
        """Return the tree joints on the ``from`` side and on the ``to`` side of a chord's loop."""
        a, b = self.path(chord.from_body), self.path(chord.to_body)
        shared = 0
        while shared < min(len(a), len(b)) and a[shared] is b[shared]:
            shared += 1
        return a[shared:], b[shared:]

    @property
    def coordinate_names(self) -> list[str]:
        """Names such as "motor_left.rz", one for each coordinate of the tree."""
        return [f"{t.joint.name}.{motion}" for t in self.joints for motion in t.joint.motions]

    @property
    def motions(self) -> list[str]:
        """The direction of each coordinate of the tree in its joint's frame."""
        return [motion for t in self.joints for motion in t.joint.motions]

    @property
    def topology(self) -> Hashable:
        """What decides the shape of the kernels, apart from constants."""
        return (
            tuple(
                (j.name, j.kind, j.axes, j.from_body, j.to_body) for j in self.robot.joints.values()
            ),
            tuple(t.joint.name for t in self.joints),
            self.robot.tool.body,
        )


def _spanning_forest(ranked: Iterable[Joint]) -> list[Joint]:
    """Return the joints that Kruskal's algorithm keeps, taking them in the order given."""
    root: dict[str, str] = {}

    def find(body: str) -> str:
        while root.setdefault(body, body) != body:
            body = root[body]
        return body

    kept = []
    for joint in ranked:
        a, b = find(joint.from_body), find(joint.to_body)
        if a != b:
            root[a] = b
            kept.append(joint)
    return kept
