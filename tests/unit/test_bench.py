"""The benchmarks: what is counted, what is compared, how tables read."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Generator, Sequence
from typing import Any

import numpy as np
import pytest
from benchmarks import simulation
from benchmarks.clock import timed
from benchmarks.cluster import ChunkWork, Killing
from benchmarks.operations import Operations, operations
from benchmarks.peers import case, ours
from benchmarks.peers.__main__ import MOST, difference, disagreeing
from benchmarks.table import table

from stiffkit.kinematics import Kinematics
from stiffkit.stiffness import Stiffness, full_matrices


def test_operations_are_counted_once_each() -> None:
    heyoka = pytest.importorskip("heyoka")
    x, y = heyoka.make_vars("x", "y")
    shared = x * y
    outputs = [
        shared + heyoka.sin(x),
        shared - heyoka.sqrt(y),
        1.0 / x,
        heyoka.select(heyoka.lt(x, y), x, -y),
        heyoka.acos(x),
    ]
    counted = operations(heyoka.cfunc(outputs, [x, y]))
    assert counted == Operations(arithmetic=5, functions=2, divisions=2)


def test_an_unknown_step_is_not_passed_over() -> None:
    heyoka = pytest.importorskip("heyoka")
    (x,) = (heyoka.make_vars("x"),)
    with pytest.raises(ValueError, match="exp"):
        operations(heyoka.cfunc([heyoka.exp(x)], [x]))


def test_columns_of_numbers_are_aligned_to_the_right() -> None:
    lines = table(("name", "rate"), [("a", 1234.5), ("long name", 0.5)]).splitlines()
    assert lines == ["name       rate", "a          1234", "long name   0.5"]


def test_the_task_of_the_peers_is_a_mechanism() -> None:
    for posture in case.postures(5):
        for (x, y), length in zip(posture.sliders, case.LENGTHS, strict=True):
            assert math.hypot(posture.x - x, posture.y - y) == pytest.approx(length)
            assert x in (0.0, case.A)
        assert posture.nodes(0, 4)[-1] == pytest.approx((posture.x, posture.y))


def test_our_robot_is_that_of_the_task() -> None:
    kinematics = Kinematics(ours.robot())
    posture = case.postures(3)[0]
    postures = kinematics.solve(np.array([[posture.x], [posture.y]]))
    names = kinematics.joint_names
    for name, (_, y) in zip(("slide_1.y", "slide_2.y"), posture.sliders, strict=True):
        assert postures.joints[names.index(name), 0] == pytest.approx(y)
    k = full_matrices(Stiffness(kinematics).at(postures).lower)[:3, :3, 0]
    # In the plane the legs are bars between hinges, each in series with its drive.
    bars = np.zeros((2, 2))
    for (x, y), length in zip(posture.sliders, case.LENGTHS, strict=True):
        u = np.array([posture.x - x, posture.y - y]) / length
        flexibility = length / (case.E_MODULUS * case.AREA) + u[1] ** 2 / case.DRIVE
        bars += np.outer(u, u) / flexibility
    np.testing.assert_allclose(k[:2, :2], np.linalg.inv(bars), rtol=1e-9)


def an_answer(program: str, compliance: float, frequency: float) -> case.Answer:
    k, f = [[[compliance, 0.0], [0.0, 1e-9]]], [[frequency, 2.0 * frequency]]
    return case.Answer(program, "1", "", k, f, 0.0, 0.0, 0.0, 0.0)


def test_a_peer_that_does_another_task_is_told() -> None:
    exact = an_answer("ours", 1e-8, 50.0)
    near = an_answer("near", 1e-8 * (1.0 + 0.5 * MOST["compliance"]), 50.0)
    slow = an_answer("slow", 1e-8, 50.0 * (1.0 - 2.0 * MOST["frequencies"]))
    none = an_answer("none", math.nan, 50.0)
    assert difference(near.compliance, exact.compliance) == pytest.approx(0.5 * MOST["compliance"])
    told = disagreeing([exact, near, slow, none])
    assert told == ["the frequencies of slow", "the compliance of none"]


# --- many machines, simulated ---------------------------------------------------------------------

WORK = ChunkWork(constant=0.004, per_geometry=0.004, spread=0.05, first=0.0)
SERIAL = 0.005


def test_a_server_without_cost_leaves_the_work_to_the_workers() -> None:
    assert simulation.makespan([1.0] * 12, 1, 0.0) == pytest.approx(12.0)
    assert simulation.makespan([1.0] * 12, 4, 0.0) == pytest.approx(3.0)
    assert simulation.makespan([1.0] * 12, 4, 0.0, first=2.0) == pytest.approx(5.0)
    assert simulation.makespan([1.0, 5.0, 1.0], 2, 0.0) == pytest.approx(5.0)


def test_a_busy_server_is_what_limits() -> None:
    n, serial = 3000, 0.01
    assert simulation.makespan([0.1] * n, 1000, serial) == pytest.approx(n * serial, rel=0.05)
    assert simulation.makespan([1.0] * n, 10, serial) == pytest.approx(n / 10, rel=0.02)


@pytest.mark.parametrize(("geometries", "workers"), [(20_000, 20), (100_000, 100), (10**7, 1000)])
def test_the_size_of_chunks_is_near_the_best(geometries: int, workers: int) -> None:
    sizes = [2**k for k in range(2, 13)]
    rows = simulation.simulated([(geometries, workers)], sizes, WORK, SERIAL)
    _, chosen, _ = simulation.chosen(rows, geometries, workers)
    best = max(row.efficiency for row in rows)
    assert best > 0.75
    assert float(chosen.rstrip("%")) > 85.0 * best


class FakeExecutor:
    """Gives chunks back one by one."""

    def run(
        self, _job: dict[str, Any], _reference: Any, chunks: Sequence[Any]
    ) -> Generator[tuple[int, Any], None, None]:
        yield from chunks


class Victim:
    """A process that only notes when it is killed."""

    def __init__(self, told: list[str], name: str) -> None:
        self.told = told
        self.name = name

    def kill(self) -> None:
        self.told.append(self.name)


def test_workers_are_killed_after_a_quarter_and_after_half_of_the_chunks() -> None:
    told: list[str] = []
    victims: Any = [Victim(told, "first"), Victim(told, "second")]
    chunks = [(i, np.zeros((1, 1))) for i in range(16)]
    for number, _ in Killing(FakeExecutor(), victims, len(chunks)).run({}, {}, chunks):
        told.append(str(number))
    assert told.index("first") == told.index("4") - 1
    assert told.index("second") == told.index("8") - 1
    assert len(told) == 18


def test_calls_are_added_up() -> None:
    class Owner:
        @staticmethod
        def work(n: int) -> int:
            return sum(range(n))

    seconds = Counter[str]()
    timed(Owner, "work", seconds, "sums")
    assert Owner.work(200_000) == sum(range(200_000))
    assert 0.0 < seconds["sums"] < 5.0
