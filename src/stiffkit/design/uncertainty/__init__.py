"""What error bars of parts and dimensions do to the stiffness of a robot."""

from stiffkit.design.uncertainty.read import SCHEMA_FILE, read_uncertainty
from stiffkit.design.uncertainty.spec import UncertaintySpec
from stiffkit.design.uncertainty.study import DATASET, UNCERTAINTY, run_uncertainty

__all__ = [
    "DATASET",
    "SCHEMA_FILE",
    "UNCERTAINTY",
    "UncertaintySpec",
    "read_uncertainty",
    "run_uncertainty",
]
