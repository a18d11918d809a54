"""The robot as a network of parts between rigid clusters, and its series-parallel reduction.

An elastic link stands in it as a star: one part from its base to each of its other ports. What two
of them do under load is coupled by the link's compliance.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field

from stiffkit.robot import BASE, Freedom, Joint, Robot

Node = Hashable


@dataclass(frozen=True)
class LinkPart:
    """An elastic link, from its base port to another one."""

    name: str
    port: str = "tip"


@dataclass(frozen=True)
class JointPart:
    """A joint with directions that are passive, driven or elastic."""

    name: str


@dataclass(frozen=True)
class Series:
    """Parts one behind the other; they carry the same wrench."""

    parts: tuple[Part, ...]


@dataclass(frozen=True)
class Parallel:
    """Parts between the same two bodies; they make the same motion."""

    parts: tuple[Part, ...]


@dataclass(frozen=True)
class Coupled:
    """Chains between the same two bodies that begin or end at different ports of the same links."""

    chains: tuple[Part, ...]


Part = LinkPart | JointPart | Series | Parallel | Coupled


@dataclass(frozen=True)
class Edge:
    """A part between two nodes (rigid clusters of bodies and ports)."""

    a: Node
    b: Node
    part: Part


@dataclass(frozen=True)
class Network:
    """All parts of a robot that can deform or move, between rigid clusters."""

    base: Node
    tool: Node
    edges: tuple[Edge, ...] = field(repr=False)
    clusters: Mapping[Node, Node] = field(repr=False, compare=False)
    """The cluster that each (body, port) belongs to; a rigid body has its "base" only."""

    def cluster_of(self, body: str, port: str) -> Node:
        """Return the rigid cluster that a port of a body belongs to.

        A rigid body has one for all its ports, an elastic one has one for each.
        """
        return self.clusters.get((body, port), self.clusters[(body, "base")])


def build_network(robot: Robot) -> Network:
    """Return the network of a robot's elastic links and movable joints."""
    root: dict[Node, Node] = {}

    def find(node: Node) -> Node:
        while root.setdefault(node, node) != node:
            node = root[node]
        return node

    def side(body: str, port: str) -> Node:
        elastic = body != BASE and robot.links[body].compliance is not None
        return (body, port if elastic else BASE)

    edges: list[tuple[Node, Node, Part]] = [
        ((name, BASE), (name, port), LinkPart(name, port))
        for name, link in robot.links.items()
        if link.compliance is not None
        for port in link.other_ports
    ]
    for joint in robot.joints.values():
        a = side(joint.from_body, joint.from_port)
        b = side(joint.to_body, joint.to_port)
        if is_rigid(joint):
            root[find(a)] = find(b)
        else:
            edges.append((a, b, JointPart(joint.name)))
    base, tool = find((BASE, "base")), find(side(robot.tool.body, robot.tool.port))
    found = tuple(Edge(find(a), find(b), part) for a, b, part in edges)
    for name in robot.links:
        find((name, "base"))
    return Network(base, tool, found, {node: find(node) for node in list(root)})


def is_rigid(joint: Joint) -> bool:
    """Tell whether a joint holds all six directions without any compliance."""
    return all(
        freedom is Freedom.BLOCKED or (freedom is Freedom.DRIVEN and stiffness == float("inf"))
        for freedom, stiffness in zip(joint.freedoms, joint.stiffness, strict=True)
    )


def reduce_series_parallel(network: Network) -> Part | None:
    """Return the network as one part between base and tool, None if it is not series-parallel.

    Branches that end nowhere carry no load and are left out. That the parts of a link with more
    than two ports are coupled is for `stiffkit.network.coupling` to judge.
    """
    ends = {network.base, network.tool}
    edges = loaded_edges(network)
    if network.base == network.tool:
        return None
    while True:
        loaded = _without_dead_ends([edge for edge in edges if edge.a != edge.b], ends)
        reduced = _merge_parallel(_merge_series(loaded, ends))
        if len(reduced) == len(edges):
            break
        edges = reduced
    return edges[0].part if len(edges) == 1 else None


def loaded_edges(network: Network) -> list[Edge]:
    """Return the edges but those of branches that end nowhere."""
    return _without_dead_ends(list(network.edges), {network.base, network.tool})


def _degrees(edges: list[Edge]) -> dict[Node, list[Edge]]:
    at: dict[Node, list[Edge]] = {}
    for edge in edges:
        at.setdefault(edge.a, []).append(edge)
        at.setdefault(edge.b, []).append(edge)
    return at


def _without_dead_ends(edges: list[Edge], ends: set[Node]) -> list[Edge]:
    while True:
        at = _degrees(edges)
        kept = [
            edge
            for edge in edges
            if all(node in ends or len(at[node]) > 1 for node in (edge.a, edge.b))
        ]
        if len(kept) == len(edges):
            return kept
        edges = kept


def _merge_series(edges: list[Edge], ends: set[Node]) -> list[Edge]:
    while True:
        at = _degrees(edges)
        middle = next((n for n, es in at.items() if n not in ends and len(es) == 2), None)
        if middle is None:
            return edges
        first, second = at[middle]
        if first is second:
            return [edge for edge in edges if edge is not first]
        a = first.a if first.b == middle else first.b
        b = second.a if second.b == middle else second.b
        merged = Edge(a, b, Series((*_series_parts(first.part), *_series_parts(second.part))))
        edges = [merged if edge is first else edge for edge in edges if edge is not second]


def _series_parts(part: Part) -> tuple[Part, ...]:
    return part.parts if isinstance(part, Series) else (part,)


def _merge_parallel(edges: list[Edge]) -> list[Edge]:
    groups: dict[frozenset[Node], list[Edge]] = {}
    for edge in edges:
        groups.setdefault(frozenset((edge.a, edge.b)), []).append(edge)
    merged = []
    for group in groups.values():
        parts = tuple(
            p
            for edge in group
            for p in (edge.part.parts if isinstance(edge.part, Parallel) else (edge.part,))
        )
        merged.append(
            group[0] if len(group) == 1 else Edge(group[0].a, group[0].b, Parallel(parts))
        )
    return merged
