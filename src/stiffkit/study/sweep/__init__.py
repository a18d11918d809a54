"""Long studies: many geometries of a robot, many postures of each, reduced to a table."""

from stiffkit.study.sweep.cluster import Cluster
from stiffkit.study.sweep.directory import StudyDirectory, create_study, open_study
from stiffkit.study.sweep.executors import Executor, InProcess, Processes
from stiffkit.study.sweep.read import SCHEMA_FILE, read_study
from stiffkit.study.sweep.run import run_study
from stiffkit.study.sweep.spec import STATISTICS, Column, StudySpec, Varied
from stiffkit.study.sweep.table import describe, make_table

__all__ = [
    "SCHEMA_FILE",
    "STATISTICS",
    "Cluster",
    "Column",
    "Executor",
    "InProcess",
    "Processes",
    "StudyDirectory",
    "StudySpec",
    "Varied",
    "create_study",
    "describe",
    "make_table",
    "open_study",
    "read_study",
    "run_study",
]
