"""Files that people write: YAML with units, arithmetic and repeated sections, read as data.

Every value is known with its line and its path of keys, so that whatever is wrong with it can be
told where it stands.
"""

from stiffkit.files.entry import Entry, Scope
from stiffkit.files.frames import read_frame
from stiffkit.files.names import suggest
from stiffkit.files.parameters import Given
from stiffkit.files.problems import Problems
from stiffkit.files.schema import check_shape
from stiffkit.files.source import Source, read_source
from stiffkit.files.tree import Node, read_tree
from stiffkit.files.write import Row, write_yaml

__all__ = [
    "Entry",
    "Given",
    "Node",
    "Problems",
    "Row",
    "Scope",
    "Source",
    "check_shape",
    "read_frame",
    "read_source",
    "read_tree",
    "suggest",
    "write_yaml",
]
