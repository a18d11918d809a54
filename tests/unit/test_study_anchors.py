"""How long anchors of a study are looked for, where hardly a geometry can be assembled."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.study.sweep import StudySpec, Varied, prepare
from stiffkit.study.sweep.anchors import Anchors
from stiffkit.study.sweep.family import Family
from stiffkit.study.sweep.group import Groups

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def groups() -> Groups:
    spec = StudySpec(
        title="Arms",
        robot="five-bar",
        varied=(Varied("proximal", tuple(np.linspace(0.15, 0.26, 100).tolist()), "mm"),),
        sample=None,
        seed=0,
        postures=4,
        models=("refined",),
        frequency_postures=0,
        columns=(),
    )
    return Groups(Family(spec), "numpy")


class Candidates:
    """Stands for reaching a candidate, which succeeds only at some of the calls."""

    def __init__(self, successes: set[int]) -> None:
        self.successes = successes
        self.calls = 0

    def __call__(self, _: Groups, anchors: Anchors, values: Array) -> Anchors | None:
        self.calls += 1
        if self.calls not in self.successes:
            return None
        own = {name: array[:, :1] for name, array in anchors.arrays().items()}
        return Anchors(**{**own, "values": values[:, None]})


def looked_for(
    groups: Groups, monkeypatch: pytest.MonkeyPatch, *successes: int
) -> tuple[Anchors, int]:
    candidates = Candidates(set(successes))
    monkeypatch.setattr(prepare, "_next", candidates)
    return prepare.make_anchors(groups), candidates.calls


def test_a_hopeless_study_is_given_up_soon(groups: Groups, monkeypatch: Any) -> None:
    anchors, calls = looked_for(groups, monkeypatch)
    assert calls == prepare._MOST_IN_VAIN
    np.testing.assert_array_equal(anchors.values, [[0.2]])


def test_only_failures_in_a_row_count(groups: Groups, monkeypatch: Any) -> None:
    most = prepare._MOST_IN_VAIN
    anchors, calls = looked_for(groups, monkeypatch, 3, most + 2, 2 * most + 2)
    assert anchors.number == 4
    assert calls == 3 * most + 2


def test_nothing_is_given_up_where_all_goes_well(groups: Groups, monkeypatch: Any) -> None:
    anchors, calls = looked_for(groups, monkeypatch, *range(1, 1000))
    assert anchors.number == 64
    assert calls == 63
