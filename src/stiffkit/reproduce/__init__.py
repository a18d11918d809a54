"""The tables and figures of the papers that the method comes from, computed again."""

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

__all__ = [
    "AMPLITUDES",
    "Cantilever",
    "Entry",
    "Level",
    "Meshing",
    "NoiseStudy",
    "Orthoglide",
    "OverConstraint",
    "PrintedRow",
    "Reproduction",
    "Standing",
    "Verdict",
    "cantilever_as_json",
    "reproduce",
    "study_cantilever",
    "study_noise",
    "study_orthoglide",
    "study_over_constraint",
    "without_over_constraints",
]
