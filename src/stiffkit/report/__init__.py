"""Pages for people: a map, modes, an identified link, a link from CAD; none needs a network."""

from __future__ import annotations

from stiffkit.report.design_page import write_design_report
from stiffkit.report.identify_page import write_identify_page
from stiffkit.report.link_page import write_link_page
from stiffkit.report.modes_page import write_modes_page
from stiffkit.report.page import write_report
from stiffkit.report.uncertainty_page import write_uncertainty_page
from stiffkit.report.whole_map import WrittenMap, write_map
from stiffkit.report.words import status_in_words

__all__ = [
    "WrittenMap",
    "status_in_words",
    "write_design_report",
    "write_identify_page",
    "write_link_page",
    "write_map",
    "write_modes_page",
    "write_report",
    "write_uncertainty_page",
]
