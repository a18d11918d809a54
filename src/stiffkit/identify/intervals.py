"""Confidence intervals of estimates whose noise is itself estimated."""

from __future__ import annotations

from dataclasses import dataclass

from scipy.special import ndtri, stdtrit

from stiffkit.errors import FieldError

MANY = 300.0
"""Degrees of freedom from where Student's t is the normal distribution to 1 % at three sigma."""
THREE_SIGMA = 0.9973
"""Share of normally distributed values within three standard deviations."""


@dataclass(frozen=True)
class Multiplier:
    """How many standard errors an interval reaches to either side."""

    value: float
    level: float
    """Share of such intervals that hold the true value."""
    distribution: str
    """normal or Student t."""
    reason: str
    """Why that distribution."""


def multiplier(level: float, degrees_of_freedom: float) -> Multiplier:
    """Return the half width, in standard errors, of the two-sided interval at a level in (0, 1).

    It is Student's t, because sigma is estimated from the same residuals, and the normal
    distribution where so many degrees of freedom are left that the two agree. Raises `FieldError`
    for a level that is none.
    """
    if not 0.0 < level < 1.0:
        raise FieldError(
            f"the confidence level is {level:g} and must lie between 0 and 1",
            mend="95 % is written 0.95",
        )
    tail = (1.0 + level) / 2.0
    freedom = f"sigma rests on {degrees_of_freedom:.4g} degrees of freedom"
    if degrees_of_freedom >= MANY:
        return Multiplier(
            float(ndtri(tail)), level, "normal", f"{freedom}, as good as known exactly"
        )
    return Multiplier(
        float(stdtrit(degrees_of_freedom, tail)),
        level,
        "Student t",
        f"{freedom}, so that its own uncertainty counts",
    )
