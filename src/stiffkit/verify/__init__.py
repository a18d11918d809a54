"""Finite elements of a whole robot at given postures: a proof of the reduced model."""

from stiffkit.verify.meshes import Resolution
from stiffkit.verify.posture import verify_postures
from stiffkit.verify.result import (
    SIGNIFICANT,
    Compared,
    Verification,
    VerifiedPart,
    VerifiedPosture,
)

__all__ = [
    "SIGNIFICANT",
    "Compared",
    "Resolution",
    "Verification",
    "VerifiedPart",
    "VerifiedPosture",
    "verify_postures",
]
