"""Chains that links with more than two ports couple, in a network that is series-parallel.

Two bars between two whole axles are such chains: they stand between the same two bodies, and begin
and end at different ports of the same links. Their compliances do not add up one by one, but
together they are one part.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator

from stiffkit.network.graph import (
    Coupled,
    LinkPart,
    Network,
    Parallel,
    Part,
    Series,
    loaded_edges,
    reduce_series_parallel,
)


def reduce_network(network: Network) -> Part | None:
    """Return the network as one part between base and tool, None if there is no such part.

    A link that carries loads at more than two ports is allowed where all its parts begin chains
    that stand side by side: these are `Coupled`.
    """
    part = reduce_series_parallel(network)
    counts = Counter(
        edge.part.name for edge in loaded_edges(network) if isinstance(edge.part, LinkPart)
    )
    coupled = {name: count for name, count in counts.items() if count > 1}
    if part is None or not coupled:
        return part
    bound = _bound(part)
    found: Counter[str] = Counter()
    for group in _coupled_parts(bound):
        if not all(_is_plain(chain) for chain in group.chains):
            return None
        # All parts of a link stand in one group, or it ties together more than that group.
        own = Counter(link.name for chain in group.chains for link in links_of(chain))
        found.update({name: count for name, count in own.items() if counts[name] == count > 1})
    return bound if found == coupled else None


def links_of(chain: Part) -> list[LinkPart]:
    """Return the links of a chain, those inside of its parallel groups not among them."""
    return [part for part in members(chain) if isinstance(part, LinkPart)]


def members(chain: Part) -> tuple[Part, ...]:
    """Return the parts that stand one behind the other in a chain."""
    return chain.parts if isinstance(chain, Series) else (chain,)


def _bound(part: Part) -> Part:
    """Return a part in which parallel branches that share a link are one part."""
    if isinstance(part, Series):
        return Series(tuple(_bound(p) for p in part.parts))
    if not isinstance(part, Parallel):
        return part
    groups: list[list[Part]] = []
    for branch in part.parts:
        sharing = [group for group in groups if _share_a_link(group, branch)]
        joined = [*(chain for group in sharing for chain in group), branch]
        groups = [*(group for group in groups if group not in sharing), joined]
    parts = [Coupled(tuple(g)) if len(g) > 1 else _bound(g[0]) for g in groups]
    return parts[0] if len(parts) == 1 else Parallel(tuple(parts))


def _share_a_link(group: Iterable[Part], branch: Part) -> bool:
    names = {link.name for chain in group for link in links_of(chain)}
    return any(link.name in names for link in links_of(branch))


def _coupled_parts(part: Part) -> Iterator[Coupled]:
    if isinstance(part, Coupled):
        yield part
    elif isinstance(part, Series | Parallel):
        for inner in part.parts:
            yield from _coupled_parts(inner)


def _is_plain(chain: Part) -> bool:
    """Tell whether a chain has no groups inside, and no link twice."""
    names = [link.name for link in links_of(chain)]
    has_groups = any(isinstance(part, Parallel | Coupled) for part in members(chain))
    return not has_groups and len(set(names)) == len(names)
