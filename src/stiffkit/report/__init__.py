"""The report of a stiffness map: one HTML file that works without a network."""

from __future__ import annotations

from stiffkit.report.page import write_report

__all__ = ["write_report"]
