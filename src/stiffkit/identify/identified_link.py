"""From a specification to a link: everything that `stiffkit identify` does but for the page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from stiffkit import __version__
from stiffkit.errors import FileError
from stiffkit.files import Row
from stiffkit.identify.comparison import Alternative, alternatives
from stiffkit.identify.compliance import identify
from stiffkit.identify.gather import Chosen, choose, content_hash, loads_of, read_files
from stiffkit.identify.identified import Identified, Mask
from stiffkit.identify.sizes import size_doubts
from stiffkit.identify.spec import ESTIMATORS, Spec, blamed_on, read_spec
from stiffkit.link.checks import check_compliance
from stiffkit.link.file import LinkFile, write_link_file
from stiffkit.link.ports import TIP
from stiffkit.progress import Progress, no_progress
from stiffkit.spatial import Frame
from stiffkit.spatial.rotation import Array


@dataclass(frozen=True, eq=False)
class IdentifiedLink:
    """A link's compliance at its tip, in the axes of the link, SI, and how it was found."""

    spec: Spec
    chosen: Chosen
    """The nodes that the deflection is read from."""
    wrenches: Array
    """(m, 6), N and N m, of the load cases, at the tip in link axes."""
    found: Identified
    alternatives: tuple[Alternative, ...]
    doubts: tuple[str, ...]
    """What looks like a wrong unit, in words."""
    notes: tuple[str, ...]
    """What to know before the numbers are used, in words."""

    @property
    def compliance(self) -> Array:
        """(6, 6), as it is written: symmetrised and cleaned if the specification says so."""
        k = self.found.symmetrised if self.spec.symmetrize else self.found.compliance
        return np.where(self.significant, k, 0.0) if self.spec.clean else k

    @property
    def covariance(self) -> Array:
        """(36, 36), of the elements of the compliance before it was cleaned, row by row."""
        found = self.found
        return found.symmetrised_covariance if self.spec.symmetrize else found.covariance

    @property
    def standard_error(self) -> Array:
        """(6, 6), of the elements of the compliance before it was cleaned."""
        return np.sqrt(np.diag(self.covariance)).reshape(6, 6)

    @property
    def significant(self) -> Mask:
        """(6, 6), elements whose confidence interval does not hold zero."""
        found = self.found
        return found.symmetrised_significant if self.spec.symmetrize else found.significant

    @property
    def sigma(self) -> float:
        """Standard deviation of the noise of a node's displacement along an axis, m."""
        return self.found.sigma

    @cached_property
    def link(self) -> LinkFile:
        """The content of the link file."""
        return LinkFile(
            title=self.spec.title,
            ports={TIP: Frame(position=self.found.reference)},
            compliance=self.compliance,
            covariance=self.covariance,
            provenance=_provenance(self),
        )

    def write(self, path: Path | str) -> None:
        """Write the link file, whole or not at all.

        Raises FileError if the compliance is not that of a body, which no robot could take, and
        OutputError where the file cannot be written.
        """
        self.check()
        write_link_file(self.link, Path(path))

    def check(self) -> None:
        """Raise FileError if the compliance is not that of a body."""
        faults = self.found.faults
        if not faults and self.spec.clean:
            faults = tuple(check_compliance((self.compliance + self.compliance.T) / 2.0))
        if faults:
            raise FileError(
                "; ".join(["what was identified is not the compliance of a body", *faults]),
                path=self.spec.path,
                mend=" ".join(self.doubts)
                or "check the loads, the reference point and the units; with --json and without "
                "-o the command shows the numbers",
            )


def identify_link(spec: Spec | Path | str, progress: Progress | None = None) -> IdentifiedLink:
    """Return the link that a specification, or the file of one, describes.

    ``progress`` is told what is being done and the share that is done. Raises FileError, with its
    place and how to mend it, where the specification or a file that it names is wrong.
    """
    report = progress or no_progress
    spec = spec if isinstance(spec, Spec) else read_spec(spec)
    file = read_files(spec, report)
    names, wrenches_file = loads_of(spec, file)
    T = spec.T_file_base
    chosen = choose(file, spec.nodes, names, T)
    others = {name: choose(file, one, names, T) for name, one in spec.compare.items()}
    wrenches = (wrenches_file.reshape(-1, 3) @ T.rotation).reshape(-1, 6)
    report("identifying", 0.6)
    tip = T.inverse.point(spec.reference)
    with blamed_on(spec.place("loads")):
        found = identify(chosen.field, wrenches, tip, spec.options)
    known = (file.points - T.position) @ T.rotation
    doubts = size_doubts(known, chosen.field.displacements, found.symmetrised, tip)
    return IdentifiedLink(
        spec=spec,
        chosen=chosen,
        wrenches=wrenches,
        found=found,
        alternatives=tuple(alternatives(found, chosen, others, wrenches, report)),
        doubts=(*doubts, *found.doubts),
        notes=(*found.notes, *_notes(spec, found, tuple(file.cases), names)),
    )


def _notes(
    spec: Spec, found: Identified, cases: tuple[str, ...], used: tuple[str, ...]
) -> list[str]:
    notes = []
    left_out = [name for name in cases if name not in used]
    if left_out:
        notes.append(f"load cases without a load, left out: {', '.join(left_out)}")
    if not spec.symmetrize and any("symmetric" in f for f in check_compliance(found.compliance)):
        notes.append(
            "the compliance is written as estimated, not symmetric, and no robot can take it so"
        )
    return notes


def estimator_word(found: Identified) -> str:
    """Return the estimator by its word in specifications."""
    return next(word for word, name in ESTIMATORS.items() if name == found.options.estimator)


def outlier_words(found: Identified) -> str:
    """Return what was done about outliers."""
    report = found.outliers
    if report is None:
        return "all nodes kept"
    counts = [len(nodes) for nodes in report.nodes]
    how = "robust fit, beyond four sigma" if report.method == "robust" else "dropped"
    return f"{how}: {min(counts)} to {max(counts)} of {found.node_count} nodes of each load case"


def asymmetry_of(found: Identified) -> float:
    """Return the largest asymmetry of the estimate, over the roots of two diagonal elements."""
    return float(np.abs(np.nan_to_num(found.asymmetry)).max())


def _provenance(link: IdentifiedLink) -> Mapping[str, Any]:
    spec, found = link.spec, link.found
    T = spec.T_file_base
    content: dict[str, Any] = {
        "program": f"stiffkit {__version__}",
        "specification": _named(spec.path, spec.path.parent, spec.content_hash),
        "fields": [
            _named(source.path, spec.path.parent, content_hash(source.path))
            for source in spec.fields
        ],
    }
    if spec.sets:
        content["sets"] = [
            _named(source.path, spec.path.parent, content_hash(source.path)) for source in spec.sets
        ]
    content |= {
        "reference_in_files": Row(spec.reference.tolist()),
        "base_in_files": {
            "at": Row(T.position.tolist()),
            "axes": [Row(axis) for axis in T.rotation.T.tolist()],
        },
        "load_cases": list(found.case_names),
        "nodes": link.chosen.words,
        "node_count": found.node_count,
        "weights": link.chosen.weights_words,
        "estimator": estimator_word(found),
        "outliers": outlier_words(found),
        "sigma": found.sigma,
        "confidence": found.options.level,
        "intervals": "nominal: residuals have a shape" if found.structured else "of random noise",
        "asymmetry": asymmetry_of(found),
        "symmetrized": spec.symmetrize,
        "cleaned": spec.clean,
    }
    if link.doubts:
        content["doubts"] = list(link.doubts)
    return content


def _named(path: Path, folder: Path, sha256: str) -> dict[str, str]:
    shown = path.relative_to(folder) if path.is_relative_to(folder) else path
    return {"file": str(shown), "sha256": sha256}
