"""The studio's worker: the newest of each kind is done, whatever came before."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stiffkit.studio.latest import Latest

PATIENCE = 20.0
"""Seconds after which something that should come is held not to."""


class Held:
    """A job that tells when it begins, and ends when it is let go."""

    def __init__(self) -> None:
        self.begun = threading.Event()
        self.let_go = threading.Event()

    def __call__(self) -> None:
        self.begun.set()
        assert self.let_go.wait(PATIENCE)


@pytest.fixture
def errors() -> list[Exception]:
    return []


@pytest.fixture
def latest(errors: list[Exception]) -> Iterator[Latest]:
    worker = Latest(errors.append)
    yield worker
    worker.close()


@pytest.fixture
def held(latest: Latest) -> Iterator[Held]:
    """A job that is being done until it is let go."""
    job = Held()
    latest.submit("held", job)
    assert job.begun.wait(PATIENCE)
    yield job
    job.let_go.set()


def test_only_the_newest_of_a_kind_is_done(latest: Latest, held: Held) -> None:
    done: list[int] = []
    for i in range(100):
        latest.submit("slider", partial(done.append, i))
    assert latest.is_pending("slider")
    held.let_go.set()
    assert latest.wait(PATIENCE)
    assert done == [99]
    assert not latest.is_pending("slider")


def test_the_same_kind_may_come_again_while_it_is_done(latest: Latest, held: Held) -> None:
    done: list[str] = []
    assert not latest.is_pending("held")
    latest.submit("held", lambda: done.append("again"))
    assert latest.is_pending("held")
    assert latest.doing == "held"
    held.let_go.set()
    assert latest.wait(PATIENCE)
    assert done == ["again"]


def test_kinds_take_turns_by_who_waits_longest(latest: Latest, held: Held) -> None:
    done: list[str] = []
    for name in ("a", "b", "a", "c", "a"):
        latest.submit(name, partial(done.append, name))
    held.let_go.set()
    assert latest.wait(PATIENCE)
    assert done == ["a", "b", "c"]


def test_errors_are_told_and_the_next_job_is_done(latest: Latest, errors: list[Exception]) -> None:
    done: list[int] = []
    latest.submit("bad", lambda: 1 / 0)
    assert latest.wait(PATIENCE)
    latest.submit("good", lambda: done.append(1))
    assert latest.wait(PATIENCE)
    assert [type(error) for error in errors] == [ZeroDivisionError]
    assert done == [1]


def test_an_error_in_telling_of_errors_ends_nothing() -> None:
    def fail(_error: Exception) -> None:
        raise RuntimeError

    worker, done = Latest(fail), []
    worker.submit("bad", lambda: 1 / 0)
    worker.submit("good", lambda: done.append(1))
    assert worker.wait(PATIENCE)
    worker.close()
    assert done == [1]


def test_busy_is_told(latest: Latest, held: Held) -> None:
    assert latest.busy
    assert not latest.wait(0.0)
    held.let_go.set()
    assert latest.wait(PATIENCE)
    assert (latest.busy, latest.doing) == (False, None)


def test_closing_ends_the_job_in_work_and_drops_what_waits(latest: Latest, held: Held) -> None:
    done: list[int] = []
    latest.submit("slider", lambda: done.append(1))
    closing = threading.Thread(target=latest.close)
    closing.start()
    held.let_go.set()
    closing.join(PATIENCE)
    assert not closing.is_alive()
    latest.submit("slider", lambda: done.append(2))
    assert not latest.busy
    assert done == []
    latest.close()


def test_a_job_may_close_its_own_worker() -> None:
    worker = Latest(lambda _error: None)
    worker.submit("end", worker.close)
    assert worker.wait(PATIENCE)
    worker.submit("late", lambda: None)
    assert not worker.busy


@settings(max_examples=30, deadline=None)
@given(st.lists(st.sampled_from("abc"), max_size=30))
def test_the_last_of_each_kind_is_never_lost(kinds: list[str]) -> None:
    """Some threads submit at once; each one's last job of a kind that is its own is done."""
    worker = Latest(lambda _error: None)
    done: list[tuple[str, int, int]] = []

    def submit(thread: int) -> None:
        for number, kind in enumerate(kinds):
            worker.submit((kind, thread), partial(done.append, (kind, thread, number)))

    with ThreadPoolExecutor(3) as threads:
        list(threads.map(submit, range(3)))
    assert worker.wait(PATIENCE)
    worker.close()
    for thread in range(3):
        for kind in set(kinds):
            mine = [n for k, t, n in done if (k, t) == (kind, thread)]
            assert mine == sorted(mine)
            assert mine[-1] == max(n for n, k in enumerate(kinds) if k == kind)
