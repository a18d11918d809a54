"""The tables and figures of the papers that the method comes from, computed again."""

from stiffkit.reproduce.entries import Entry, Verdict
from stiffkit.reproduce.pashkevich_2009 import NoiseStudy, Reproduction, reproduce, study_noise

__all__ = ["Entry", "NoiseStudy", "Reproduction", "Verdict", "reproduce", "study_noise"]
