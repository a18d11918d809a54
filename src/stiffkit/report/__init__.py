"""The report of a stiffness map: one HTML file that works without a network."""

from __future__ import annotations

from stiffkit.report.page import write_report
from stiffkit.report.words import status_in_words

__all__ = ["status_in_words", "write_report"]
