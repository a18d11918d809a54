"""Briot 2009: what longer legs do to a Biglide, by a simplified and by a refined model.

S. Briot, A. Pashkevich, D. Chablat, "On the optimal design of parallel robots taking into account
their deformations and natural frequencies", Proc. ASME IDETC/CIE 2009. The text prints the data of
the machine and few results; its figures are pictures, so its sentences are compared.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from stiffkit.progress import Progress
from stiffkit.reproduce.briot_2009_conclusions import (
    RigidLegs,
    family_statements,
    study_rigid_legs,
)
from stiffkit.reproduce.briot_2009_machine import Machine, study_machine
from stiffkit.reproduce.briot_2009_optimum import STEPS, Family, study_family
from stiffkit.reproduce.briot_2009_words import machine_statements
from stiffkit.reproduce.statements import Statement

COARSE = 8
"""Values of alpha for what stands beside the figures."""


@dataclass(frozen=True, eq=False)
class Briot2009:
    """What the paper says beside what comes out here, and the data of its figures."""

    statements: tuple[Statement, ...]
    machine: Machine
    family: Family
    rigid_legs: RigidLegs

    def as_json(self) -> dict[str, Any]:
        """Return plain data for JSON, SI."""
        return {
            "statements": [statement.as_json() for statement in self.statements],
            "machine": self.machine.as_json(),
            "family": self.family.as_json(),
            "rigid_legs": {
                "alpha": self.rigid_legs.alphas.tolist(),
                "deflection": {
                    load: values.tolist() for load, values in self.rigid_legs.deflections.items()
                },
            },
        }


def reproduce_briot_2009(*, steps: int = STEPS, progress: Progress | None = None) -> Briot2009:
    """Compute what the text of the paper says, and its figures 3, 5 to 7, 10, 12 and 13.

    ``steps`` values of alpha are in figures 6, 12 and 13. ``progress`` is told what is being done
    and the share that is done.
    """
    machine = study_machine()
    family = study_family(steps, progress)
    rigid = study_rigid_legs(COARSE)
    other = study_family(COARSE, reading="stiffness")
    statements = [*machine_statements(machine), *family_statements(family, rigid, other)]
    return Briot2009(tuple(statements), machine, family, rigid)
