"""The README as the package index shows it, which has neither the pictures nor the other pages.

Hatchling calls this when it makes the package's metadata.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

_PICTURE = re.compile(r"^!\[[^\]]*\]\((?!https:)[^)]*\)\n\n(?:\*[^*]+\*\n\n)?", re.MULTILINE)
"""A picture on a line of its own, with its caption if it has one."""
_LINK = re.compile(r"\[([^\]]*)\]\((?!https:|#)[^)]*\)")


def long_description(readme: str) -> str:
    """Return a README without pictures and links that lead to files beside it."""
    return _LINK.sub(r"\1", _PICTURE.sub("", readme))


class LongDescription(MetadataHookInterface):
    """Gives the metadata their long description."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Set the README in a project's ``metadata``."""
        text = Path(self.root, "README.md").read_text(encoding="utf-8")
        metadata["readme"] = {"content-type": "text/markdown", "text": long_description(text)}
