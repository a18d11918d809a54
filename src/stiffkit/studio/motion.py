"""A motion that is played: a shape, there and back, again and again."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np

_RATE_HZ = 20.0
_PERIOD_S = 1.6


class Motion:
    """A thread that calls ``draw(share)`` with a share from -1 to 1 of the largest displacement."""

    def __init__(self, draw: Callable[[float], None]) -> None:
        """Take what draws one moment; nothing moves before `play`."""
        self._draw = draw
        self._plays = threading.Event()
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run, name="studio-motion", daemon=True)
        self._thread.start()

    def play(self, is_playing: bool) -> None:
        """Begin or stop."""
        if is_playing:
            self._plays.set()
        else:
            self._plays.clear()

    def close(self) -> None:
        """End the thread."""
        self._ends.set()
        self._plays.set()
        self._thread.join()

    def _run(self) -> None:
        began = time.monotonic()
        while self._plays.wait() and not self._ends.is_set():
            phase = 2.0 * np.pi * (time.monotonic() - began) / _PERIOD_S
            self._draw(float(np.sin(phase)))
            self._ends.wait(1.0 / _RATE_HZ)
