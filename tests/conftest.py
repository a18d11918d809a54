"""Settings of all tests."""

from __future__ import annotations

from hypothesis import settings

# The same examples in every run: a failure means a change of the code, never luck.
settings.register_profile(
    "stiffkit", deadline=None, derandomize=True, print_blob=True, max_examples=50, database=None
)
settings.load_profile("stiffkit")
