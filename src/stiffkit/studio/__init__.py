"""The studio: a robot in the browser, whose tool and parameters are moved with the hand."""

from stiffkit.studio.app import Studio, open_studio
from stiffkit.studio.machine import Machine
from stiffkit.studio.variant import Variant
from stiffkit.studio.view import PoseView

__all__ = ["Machine", "PoseView", "Studio", "Variant", "open_studio"]
