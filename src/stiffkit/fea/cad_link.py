"""From a specification to a link: everything that `stiffkit link` does but for the page."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from stiffkit import __version__
from stiffkit.fea import cache
from stiffkit.fea.beams import BeamComparison, compare
from stiffkit.fea.link_spec import LinkSpec, PortSpec, read_link_spec
from stiffkit.fea.solve import describe_law, solve_spec
from stiffkit.fea.solved import Solved, from_plain, to_plain
from stiffkit.fea.sources import PartSource
from stiffkit.files import Row
from stiffkit.link.file import LinkFile, write_link_file
from stiffkit.link.ports import places_of
from stiffkit.progress import Progress, no_progress
from stiffkit.spatial.frame import Frame
from stiffkit.spatial.rotation import Array

_EDITION = 3
"""Raised when the same specification gives other results, so that older ones are not taken."""


@dataclass(frozen=True, eq=False)
class CadLink:
    """A link made of a part: all in link axes, SI, and how it was found."""

    spec: LinkSpec
    solved: Solved
    key: str
    """SHA-256 of everything that the result depends on."""
    cad_hash: str
    """SHA-256 of the part's file."""
    from_cache: bool
    """Whether it had been solved before."""
    notes: tuple[str, ...]
    """What to know before the numbers are used, in words."""

    @property
    def compliance(self) -> Array:
        """(6(m-1), 6(m-1)), of the ports but the base, in order, at their points, base held."""
        return self.solved.element.compliance

    @cached_property
    def beams(self) -> tuple[BeamComparison, ...]:
        """What the specification's approximations by beams give, in its order."""
        return compare(self.spec.beams, places_of(self.solved.ports)[0])

    @cached_property
    def link(self) -> LinkFile:
        """The content of the link file."""
        solved = self.solved
        return LinkFile(
            title=self.spec.title,
            ports=solved.ports,
            compliance=self.compliance,
            mass=solved.mass,
            center_of_mass=solved.center_of_mass,
            inertia=solved.inertia,
            superelement=solved.element,
            provenance=_provenance(self),
            notes=self.notes,
            content_hash=self.key,
        )

    def write(self, path: Path | str) -> None:
        """Write the link file, whole or not at all. Raises OutputError where it cannot be."""
        write_link_file(self.link, Path(path))


def link_from_cad(
    spec: LinkSpec | Path | str,
    progress: Progress | None = None,
    *,
    part: PartSource | None = None,
) -> CadLink:
    """Return the link that a specification, or the file of one, describes.

    ``part`` takes the place of the one that the file names, such as a `PythonPart` of your own.

    What has been solved before is taken from the user's cache. ``progress`` is told what is being
    done and the share that is done. Raises FileError, with its place and how to mend it, where
    the specification or the part is wrong, or no solution can be found.
    """
    report = progress or no_progress
    if not isinstance(spec, LinkSpec):
        spec = read_link_spec(spec, part)
    elif part is not None:
        spec = replace(spec, cad=part)
    cad_hash = spec.cad.digest()
    key = _key(spec, cad_hash)
    solved = _kept(key)
    notes = []
    from_cache = solved is not None
    if solved is None:
        solved = solve_spec(spec, report)
        failure = cache.keep(key, *to_plain(solved))
        if failure:
            notes.append(f"the solution could not be kept for the next time: {failure}")
    return CadLink(spec, solved, key, cad_hash, from_cache, (*_notes(solved), *notes))


def as_json(link: CadLink) -> dict[str, Any]:
    """Return a link as plain values, SI, link axes."""
    solved = link.solved
    return {
        "link": link.spec.title,
        "compliance": link.compliance.tolist(),
        "estimated_error": solved.estimate,
        "converged": solved.facts["converged"],
        "ports": {name: _frame(T_link_port) for name, T_link_port in solved.ports.items()},
        "mass": solved.mass,
        "center_of_mass": solved.center_of_mass.tolist(),
        "inertia": solved.inertia.tolist(),
        "mode_stiffness": solved.element.mode_stiffness.tolist(),
        "link_in_part": _frame(solved.T_part_link),
        "history": [vars(step) for step in solved.steps],
        "part": dict(solved.facts),
        "cad": {**link.spec.cad.as_plain(), "sha256": link.cad_hash},
        "beams": [
            {
                "name": one.name,
                "compliance": one.compliance.tolist(),
                "ratios": one.ratios(link.compliance).tolist(),
                "gap": one.gap,
            }
            for one in link.beams
        ],
        "from_cache": link.from_cache,
        "notes": list(link.notes),
    }


def _key(spec: LinkSpec, cad_hash: str) -> str:
    """Return the hash of everything that the result depends on."""
    content = {
        "version": __version__,
        "edition": _EDITION,
        "cad": cad_hash,
        "kind": spec.cad.kind,
        "scale": spec.scale,
        "material": describe_law(spec.material),
        "solids": {name: describe_law(law) for name, law in sorted(spec.solids.items())},
        "ports": [[name, _port(port)] for name, port in spec.ports],
        "up": spec.up,
        "tolerance": spec.tolerance,
        "features": spec.features,
        "modes": spec.n_modes,
        "mesh": None if spec.mesh is None else vars(spec.mesh),
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _port(port: PortSpec) -> dict[str, Any]:
    return {
        "faces": [vars(pick) for pick in port.picks],
        "kind": port.kind,
        "point": port.point,
        "axes": None if port.axes is None else port.axes.tolist(),
    }


def _kept(key: str) -> Solved | None:
    found = cache.load(key)
    if found is None:
        return None
    try:
        return from_plain(*found)
    except (KeyError, TypeError):
        return None


def _notes(solved: Solved) -> list[str]:
    facts = solved.facts
    notes = []
    if facts["tolerance"] is None:
        notes.append("one mesh was asked for, so no error is estimated")
    elif not facts["converged"]:
        why = f": {facts['stopped']}" if facts["stopped"] else ""
        reached = "unknown" if solved.estimate is None else f"{100.0 * solved.estimate:.2g} %"
        notes.append(
            f"the error asked for, {100.0 * facts['tolerance']:.2g} %, was not reached; it is "
            f"{reached}{why}"
        )
    if facts["failures"]:
        notes.append(f"meshing failed {len(facts['failures'])} times before it succeeded")
    return notes


def _provenance(link: CadLink) -> Mapping[str, Any]:
    spec, facts = link.spec, link.solved.facts
    content: dict[str, Any] = {"program": f"stiffkit {__version__}"}
    if spec.content_hash:
        content["specification"] = {"file": spec.path.name, "sha256": spec.content_hash}
    content["cad"] = {
        **_origin(spec.cad),
        "sha256": link.cad_hash,
        "unit": facts["unit"],
        "scale": 1.0 if spec.scale is None else spec.scale,
        "size": Row(facts["size"]),
    }
    content["materials"] = dict(facts["materials"])
    content["interfaces"] = {
        name: one | {"numbers": Row(one["numbers"]), "at": Row(one["at"])}
        for name, one in facts["interfaces"].items()
    }
    # Per 1 N and 1 N m: how far the faces are from moving rigidly, which is no error of the fit.
    content["residuals"] = {
        name: Row([load["sigma"] for load in one["loads"].values()])
        for name, one in facts["readings"].items()
    }
    frame = _frame(link.solved.T_part_link)
    content["link_in_part"] = {
        "at": Row(frame["at"]),
        "axes": [Row(axis) for axis in frame["axes"]],
    }
    content |= {key: facts[key] for key in ("mesh", "elements", "order", "unknowns", "tolerance")}
    content["estimated_error"] = link.solved.estimate
    if link.notes:
        content["notes"] = list(link.notes)
    return content


def _origin(cad: PartSource) -> dict[str, Any]:
    """Return what a part comes from, without the folders of this machine."""
    return cad.as_plain() | ({"file": cad.name} if "file" in cad.as_plain() else {})


def _frame(T: Frame) -> dict[str, Any]:
    return {"at": T.position.tolist(), "axes": T.rotation.T.tolist()}
