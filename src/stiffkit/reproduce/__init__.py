"""The tables and figures of the papers that the method comes from, computed again."""

from stiffkit.reproduce.briot_2009 import Briot2009, reproduce_briot_2009
from stiffkit.reproduce.briot_2009_family import PLACES
from stiffkit.reproduce.cantilever_entries import cantilever_as_json
from stiffkit.reproduce.entries import Entry, Verdict
from stiffkit.reproduce.over_constraint import (
    OverConstraint,
    study_over_constraint,
    without_over_constraints,
)
from stiffkit.reproduce.pashkevich_2009 import (
    AMPLITUDES,
    NoiseStudy,
    Reproduction,
    reproduce,
    study_noise,
)
from stiffkit.reproduce.pashkevich_2009_cantilever import (
    Cantilever,
    Level,
    Meshing,
    study_cantilever,
)
from stiffkit.reproduce.pashkevich_2009_orthoglide import Orthoglide, study_orthoglide
from stiffkit.reproduce.rows import PrintedRow, Standing
from stiffkit.reproduce.statements import Outcome, Statement

__all__ = [
    "AMPLITUDES",
    "PLACES",
    "Briot2009",
    "Cantilever",
    "Entry",
    "Level",
    "Meshing",
    "NoiseStudy",
    "Orthoglide",
    "Outcome",
    "OverConstraint",
    "PrintedRow",
    "Reproduction",
    "Standing",
    "Statement",
    "Verdict",
    "cantilever_as_json",
    "reproduce",
    "reproduce_briot_2009",
    "study_cantilever",
    "study_noise",
    "study_orthoglide",
    "study_over_constraint",
    "without_over_constraints",
]
