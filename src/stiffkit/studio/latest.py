"""Work for one thread, where only the newest of each kind counts."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from contextlib import suppress

Job = Callable[[], object]


class Latest:
    """A thread that does jobs, the newest of each kind; older ones that wait are dropped.

    Kinds take turns in the order in which their oldest waiting job came, so none waits for ever,
    and the last job of a kind is always done unless the thread is closed before.
    """

    def __init__(self, failed: Callable[[Exception], object]) -> None:
        """Start the thread; ``failed`` is told there of the errors of jobs."""
        self._failed = failed
        self._changed = threading.Condition()
        self._waiting: OrderedDict[Hashable, Job] = OrderedDict()
        self._doing: Hashable | None = None
        self._is_doing = False
        self._is_closed = False
        self._thread = threading.Thread(target=self._run, name="studio-latest", daemon=True)
        self._thread.start()

    def submit(self, kind: Hashable, job: Job) -> None:
        """Have a job done, instead of one of the same kind that still waits.

        Nothing happens once this is closed.
        """
        with self._changed:
            if self._is_closed:
                return
            self._waiting[kind] = job
            self._changed.notify_all()

    def is_pending(self, kind: Hashable) -> bool:
        """Tell whether a job of a kind waits, so that an older one in work may as well end."""
        with self._changed:
            return kind in self._waiting

    @property
    def busy(self) -> bool:
        """Whether a job is being done or waits."""
        with self._changed:
            return self._is_doing or bool(self._waiting)

    @property
    def doing(self) -> Hashable | None:
        """The kind of the job that is being done, None if none is."""
        with self._changed:
            return self._doing if self._is_doing else None

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until nothing is left to do, or for some seconds; tell whether nothing is."""
        with self._changed:
            return self._changed.wait_for(
                lambda: not (self._is_doing or self._waiting), timeout=timeout
            )

    def close(self) -> None:
        """Drop what waits, and end the thread when it has done what it is doing."""
        with self._changed:
            self._is_closed = True
            self._waiting.clear()
            self._changed.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._is_closed)
                if self._is_closed:
                    return
                self._doing, job = self._waiting.popitem(last=False)
                self._is_doing = True
            try:
                self._do(job)
            finally:
                with self._changed:
                    self._is_doing = False
                    self._changed.notify_all()

    def _do(self, job: Job) -> None:
        try:
            job()
        except Exception as error:
            # Whatever it is, the next job must be done; so it must if telling of it fails as well.
            with suppress(Exception):
                self._failed(error)
