"""Random mechanisms that are closed at a posture known beforehand.

Bodies are put anywhere in the world first. A joint between two of them gets random coordinates and
a random place, from which its frames on both bodies follow; so every loop is closed whatever the
joints are. Because all frames are known, compliances can be computed from them in another way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from hypothesis import strategies as st
from hypothesis.vendor.pretty import RepresentationPrinter
from numpy.typing import NDArray

from stiffkit.kinematics import SpanningTree
from stiffkit.robot import BASE, DIRECTIONS, Freedom, Home, Joint, Link, Robot, Tool, Workspace
from stiffkit.spatial import Frame, axis_rotation, exp_rotation

Array = NDArray[np.float64]
Rng = np.random.Generator

LENGTH = 0.5
"""Size of the mechanisms, m."""

AXES_OF_KIND: dict[str, list[tuple[str, ...]]] = {
    "fixed": [()],
    "revolute": [("x",), ("y",), ("z",)],
    "prismatic": [("x",), ("y",), ("z",)],
    "cylindrical": [("x",), ("z",)],
    "universal": [("x", "y"), ("y", "x"), ("z", "x"), ("y", "z")],
    "spherical": [()],
    "planar": [("x",), ("y",), ("z",)],
}


# What a mechanism is made of: chains of joints, links and groups of parallel chains.


@dataclass(frozen=True)
class JointSpec:
    """A joint; `motions` and `held` say what its free and its other directions do."""

    kind: str
    axes: tuple[str, ...] = ()
    motions: Freedom = Freedom.PASSIVE
    held: Freedom = Freedom.BLOCKED
    reverse: bool = False
    coaxial: bool = False
    """Whether the joint lies in the frame of the one before it."""


@dataclass(frozen=True)
class LinkSpec:
    """An elastic link, as a beam or with any positive definite compliance; or a rigid one."""

    body: str = "beam"


@dataclass(frozen=True)
class GroupSpec:
    """Chains in parallel."""

    chains: tuple[Chain, ...]


Element = JointSpec | LinkSpec | GroupSpec
Chain = tuple[Element, ...]

Port = tuple[str, str]
"""A body and the name of its port."""


def revolute(axis: str = "z", **more: Freedom | bool) -> JointSpec:
    """Return a revolute joint."""
    return replace(JointSpec("revolute", (axis,)), **more)  # type: ignore[arg-type]


# Numbers.


Style = Literal["general", "planar", "aligned"]
"""How frames lie: anywhere; turned about z only; or along the axes of the world and on a grid, as
designers draw them, so that many entries vanish exactly."""


def random_frame(rng: Rng, style: Style = "general") -> Frame:
    """Return a frame in a style."""
    if style == "aligned":
        R = np.linalg.matrix_power(_QUARTER_TURN, int(rng.integers(6)))
        return Frame(np.asarray(R, dtype=float), LENGTH * rng.integers(-1, 2, 3).astype(float))
    turn = rng.uniform(-2.0, 2.0, 3) * ((0.0, 0.0, 1.0) if style == "planar" else 1.0)
    return Frame(exp_rotation(turn), rng.uniform(-LENGTH, LENGTH, 3))


_QUARTER_TURN = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
"""A rotation whose powers turn each axis into each other one."""


def random_coordinates(
    rng: Rng, motions: tuple[str, ...], style: Style = "general"
) -> tuple[float, ...]:
    """Return coordinates of a joint, m and rad, less than half a turn."""
    if style == "aligned" and rng.random() < 0.7:
        return (0.0,) * len(motions)
    return tuple(
        float(rng.uniform(-1.7, 1.7) if motion.startswith("r") else rng.uniform(-0.2, 0.2))
        for motion in motions
    )


def motions_of(kind: str, axes: tuple[str, ...]) -> tuple[str, ...]:
    """Return the directions in which a joint moves, in the order of its coordinates."""
    nowhere = Frame()
    return Joint(
        "", kind, axes, "", nowhere, "", nowhere, freedoms=(), stiffness=np.zeros(6)
    ).motions


def motion_frame(kind: str, motions: tuple[str, ...], q: tuple[float, ...]) -> Frame:
    """Return T_from_to of a joint at its coordinates."""
    if kind == "spherical":
        return Frame(exp_rotation(q))
    frame = Frame()
    for motion, value in zip(motions, q, strict=True):
        if motion.startswith("r"):
            frame = frame @ Frame(axis_rotation(motion[1], value))
        else:
            frame = frame @ Frame(position=value * np.eye(3)["xyz".index(motion)])
    return frame


def random_compliance(rng: Rng, body: str) -> Array:
    """Return the compliance (6, 6) of a link of some decimetres, SI."""
    if body == "beam":
        L, E, width = rng.uniform(0.1, 0.5), 2.1e11, rng.uniform(0.02, 0.05)
        EI, GJ = E * width**4 / 12, 0.14 * width**4 * 8e10
        k = np.diag([L / (E * width**2), L**3 / (3 * EI), L**3 / (3 * EI), L / GJ, L / EI, L / EI])
        k[1, 5] = k[5, 1] = L**2 / (2 * EI)
        k[2, 4] = k[4, 2] = -(L**2) / (2 * EI)
        return k
    A = rng.normal(size=(6, 6)) + 2.0 * np.eye(6)
    unit = np.diag([LENGTH] * 3 + [1.0] * 3)
    return np.asarray(10.0 ** rng.uniform(-7, -6) * unit @ A @ A.T @ unit)


def random_stiffness(rng: Rng, direction: str) -> float:
    """Return the stiffness of a drive, a bearing or a flexure, N/m or N m/rad."""
    unit = LENGTH**2 if direction.startswith("r") else 1.0
    return float(10.0 ** rng.uniform(6, 8) * unit)


# Mechanisms.


@dataclass(frozen=True, eq=False, repr=False)
class Mechanism:
    """A robot, and a posture at which its loops are closed."""

    robot: Robot
    T_world: dict[str, Frame]
    """Frame of each body."""
    q_of: dict[str, tuple[float, ...]]
    """Coordinates of each joint."""
    legs: tuple[tuple[str, ...], ...] = ()
    """Names of the bodies and joints of each chain between base and platform."""

    def __repr__(self) -> str:
        """Return links and joints without their numbers."""
        elastic = [n for n, link in self.robot.links.items() if link.compliance is not None]
        joints = [
            f"{j.name}: {j.kind} {''.join(j.axes)} {j.from_body} - {j.to_body}"
            f" ({''.join(freedom.value[0] for freedom in j.freedoms)})"
            for j in self.robot.joints.values()
        ]
        return "\n  ".join([f"elastic: {', '.join(elastic)}", *joints])

    def _repr_pretty_(self, printer: RepresentationPrinter, _cycle: bool) -> None:
        printer.text(repr(self))

    @property
    def tree(self) -> SpanningTree:
        """The robot's spanning tree."""
        return SpanningTree.of(self.robot)

    def coordinates(self, tree: SpanningTree) -> Array:
        """Return the coordinates (n,) of a tree of the robot."""
        return np.array([x for t in tree.joints for x in self.q_of[t.joint.name]])

    @property
    def T_world_tool(self) -> Frame:
        """The tool's frame."""
        return self.T_world[self.robot.tool.body] @ self.robot.tool.T_body_tool

    def only(self, legs: list[int]) -> Mechanism:
        """Return the mechanism with some of its legs only."""
        kept = {name for i in legs for name in self.legs[i]}
        return self.with_parts(
            {n: x for n, x in self.robot.links.items() if n in kept or n == "platform"},
            {n: x for n, x in self.robot.joints.items() if n in kept},
        )

    def with_parts(self, links: dict[str, Link], joints: dict[str, Joint]) -> Mechanism:
        """Return the mechanism with other links and joints."""
        home = Home(joints={name: self.q_of[name] for name in joints})
        return replace(self, robot=replace(self.robot, links=links, joints=joints, home=home))


@dataclass
class _Builder:
    rng: Rng
    style: Style
    links: dict[str, Link] = field(default_factory=dict)
    joints: dict[str, Joint] = field(default_factory=dict)
    T_world: dict[str, Frame] = field(default_factory=lambda: {BASE: Frame()})
    q_of: dict[str, tuple[float, ...]] = field(default_factory=dict)

    def place(self) -> Frame:
        return random_frame(self.rng, self.style)

    def rigid(self, name: str = "") -> Port:
        name = name or f"body{len(self.links)}"
        self.links[name] = Link(name, {"base": Frame()})
        self.T_world[name] = self.place()
        return name, "base"

    def elastic(self, body: str) -> str:
        name = f"link{len(self.links)}"
        ports = {"base": Frame(), "tip": self.place()}
        self.links[name] = Link(name, ports, random_compliance(self.rng, body), origin="compliance")
        self.T_world[name] = self.place()
        return name

    def connect(
        self, a: Port, b: Port, spec: JointSpec, T_world_from: Frame | None = None
    ) -> Frame:
        """Put a joint between two ports; return the world frame of its ``to`` side."""
        (from_body, from_port), (to_body, to_port) = (b, a) if spec.reverse else (a, b)
        name = f"joint{len(self.joints)}"
        motions = motions_of(spec.kind, spec.axes)
        q = random_coordinates(self.rng, motions, self.style)
        T_world_from = T_world_from or self.place()
        T_world_to = T_world_from @ motion_frame(spec.kind, motions, q)
        freedoms = tuple(spec.motions if d in motions else spec.held for d in DIRECTIONS)
        self.joints[name] = Joint(
            name,
            spec.kind,
            spec.axes,
            from_body=from_body,
            T_from_joint=self.T_world[from_body].inverse @ T_world_from,
            to_body=to_body,
            T_to_joint=self.T_world[to_body].inverse @ T_world_to,
            freedoms=freedoms,
            stiffness=np.array([*map(self.stiffness, freedoms, DIRECTIONS)]),
            from_port=from_port,
            to_port=to_port,
        )
        self.q_of[name] = q
        return T_world_to

    def stiffness(self, freedom: Freedom, direction: str) -> float:
        if freedom is Freedom.PASSIVE:
            return 0.0
        return np.inf if freedom is Freedom.BLOCKED else random_stiffness(self.rng, direction)

    def chain(self, start: Port, end: Port, chain: Chain) -> None:
        """Put elements one behind the other between two ports."""
        here, T_joint = start, None
        for element in chain:
            if isinstance(element, JointSpec):
                there = self.rigid()
                T_joint = self.connect(here, there, element, T_joint if element.coaxial else None)
                here = there
            elif isinstance(element, LinkSpec):
                rigid = element.body == "rigid"
                name = self.rigid()[0] if rigid else self.elastic(element.body)
                self.connect(here, (name, "base"), JointSpec("fixed"))
                here = name, "base" if rigid else "tip"
            else:
                there = self.rigid()
                for branch in element.chains:
                    self.chain(here, there, branch)
                here = there
        self.connect(here, end, JointSpec("fixed"))


def build(chains: tuple[Chain, ...], seed: int, style: Style = "general") -> Mechanism:
    """Return a platform that hangs on chains from the base; ``seed`` decides all numbers."""
    b = _Builder(np.random.default_rng(seed), style)
    platform = b.rigid("platform")
    legs: list[tuple[str, ...]] = []
    for chain in chains:
        before = {*b.links, *b.joints}
        b.chain((BASE, "base"), platform, chain)
        legs.append(tuple(name for name in [*b.links, *b.joints] if name not in before))
    robot = Robot(
        name="random",
        title="Random mechanism",
        links=b.links,
        joints=b.joints,
        tool=Tool("platform", b.place()),
        home=Home(joints=b.q_of),
        workspace=Workspace(),
        loads={},
        parameters={},
    )
    return Mechanism(robot, b.T_world, b.q_of, tuple(legs))


def moved(mechanism: Mechanism, T_new_old: Frame) -> Mechanism:
    """Return the mechanism in another world frame."""
    joints = {}
    for name, joint in mechanism.robot.joints.items():
        if joint.from_body == BASE:
            joint = replace(joint, T_from_joint=T_new_old @ joint.T_from_joint)
        if joint.to_body == BASE:
            joint = replace(joint, T_to_joint=T_new_old @ joint.T_to_joint)
        joints[name] = joint
    T_world = {
        name: frame if name == BASE else T_new_old @ frame
        for name, frame in mechanism.T_world.items()
    }
    return replace(mechanism.with_parts(dict(mechanism.robot.links), joints), T_world=T_world)


def split(mechanism: Mechanism, body: str, rng: Rng) -> Mechanism:
    """Return the mechanism with a rigid link cut in two, and the pieces joined by a fixed joint.

    The second piece takes over every other joint; the tool stays on the first one.
    """
    T_body_piece, T_body_cut = random_frame(rng), random_frame(rng)
    joints: dict[str, Joint] = {}
    touching = 0
    for name, joint in mechanism.robot.joints.items():
        if body in (joint.from_body, joint.to_body):
            touching += 1
            if touching % 2:
                joint = _attached_to_piece(joint, body, T_body_piece)
        joints[name] = joint
    joints["cut"] = Joint(
        "cut", "fixed", (), body, T_body_cut, "piece", T_body_piece.inverse @ T_body_cut,
        (Freedom.BLOCKED,) * 6, np.full(6, np.inf),
    )  # fmt: skip
    links = {**mechanism.robot.links, "piece": Link("piece", {"base": Frame()})}
    cut = replace(
        mechanism,
        T_world={**mechanism.T_world, "piece": mechanism.T_world[body] @ T_body_piece},
        q_of={**mechanism.q_of, "cut": ()},
    )
    return cut.with_parts(links, joints)


def _attached_to_piece(joint: Joint, body: str, T_body_piece: Frame) -> Joint:
    if joint.from_body == body:
        return replace(
            joint, from_body="piece", T_from_joint=T_body_piece.inverse @ joint.T_from_joint
        )
    return replace(joint, to_body="piece", T_to_joint=T_body_piece.inverse @ joint.T_to_joint)


# Strategies.

seeds = st.integers(0, 2**32 - 1)

_KINDS = [(kind, axes) for kind, options in AXES_OF_KIND.items() for axes in options]


@st.composite
def joint_specs(draw: st.DrawFn, kinds: tuple[str, ...] = tuple(AXES_OF_KIND)) -> JointSpec:
    """Draw a joint: mostly passive; sometimes driven, a flexure, or in elastic bearings."""
    kind, axes = draw(st.sampled_from([(k, a) for k, a in _KINDS if k in kinds]))
    passive, driven, elastic = Freedom.PASSIVE, Freedom.DRIVEN, Freedom.ELASTIC
    return JointSpec(
        kind,
        axes,
        motions=draw(st.sampled_from([passive, passive, driven, elastic])),
        held=draw(st.sampled_from([Freedom.BLOCKED, Freedom.BLOCKED, elastic])),
        reverse=draw(st.booleans()),
        coaxial=draw(st.sampled_from([False, False, False, True])),
    )


link_specs = st.builds(LinkSpec, st.sampled_from(["beam", "any", "rigid"]))
elastic_links = st.builds(LinkSpec, st.sampled_from(["beam", "any"]))
SMALL_KINDS = ("fixed", "revolute", "prismatic", "universal", "cylindrical")


@st.composite
def legs(draw: st.DrawFn, *, depth: int = 0) -> Chain:
    """Draw a leg: an elastic link, and joints, links and closed sub-loops around it."""
    elements: list[Element] = [draw(elastic_links)]
    elements += draw(st.lists(st.one_of(joint_specs(SMALL_KINDS), joint_specs()), max_size=3))
    elements += draw(st.lists(link_specs, max_size=1))
    if depth > 0 and draw(st.booleans()):
        branches = draw(st.lists(legs(depth=depth - 1), min_size=2, max_size=2))
        elements.append(GroupSpec(tuple(branches)))
    return tuple(draw(st.permutations(elements)))


@st.composite
def mechanisms(draw: st.DrawFn, *, depth: int = 1, most_legs: int = 3) -> Mechanism:
    """Draw a platform on one to a few legs."""
    chains = draw(st.lists(legs(depth=depth), min_size=1, max_size=most_legs))
    style: Style = draw(st.sampled_from(["general", "aligned"]))
    return build(tuple(chains), draw(seeds), style)


@st.composite
def planar_mechanisms(draw: st.DrawFn) -> Mechanism:
    """Draw an over-constrained planar mechanism: all hinges are parallel."""
    hinge = st.builds(
        revolute,
        st.just("z"),
        motions=st.sampled_from([Freedom.PASSIVE, Freedom.PASSIVE, Freedom.DRIVEN]),
        reverse=st.booleans(),
    )
    chains = []
    for _ in range(draw(st.integers(2, 3))):
        pieces = draw(st.lists(st.tuples(hinge, elastic_links), min_size=1, max_size=3))
        chains.append(tuple(element for piece in pieces for element in piece))
    return build(tuple(chains), draw(seeds), "planar")


def elements_of(chains: tuple[Chain, ...]) -> Iterator[Element]:
    """Yield all elements, those inside groups too."""
    for chain in chains:
        for element in chain:
            yield element
            if isinstance(element, GroupSpec):
                yield from elements_of(element.chains)
