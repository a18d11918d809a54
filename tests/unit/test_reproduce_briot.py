"""Sentences of Briot 2009 beside ours, as data, text, page and figures."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import stiffkit.reproduce
from stiffkit.cli.commands import main
from stiffkit.reproduce import Outcome, Statement, reproduce_briot_2009
from stiffkit.reproduce.trend import Trend

X = np.linspace(0.0, 2.0, 41)


@pytest.mark.parametrize(
    ("y", "shape", "words"),
    [
        (2.0 - X / 2.0, "falls", "falls from 20 to 10"),
        (1.0 + X, "rises", "rises from 10 to 30"),
        (np.full(41, 3.0), "constant", "constant, 30"),
        (np.full(41, 1e-8), "constant", "nil"),
        (1.0 + (X - 0.5) ** 2, "falls, then rises", "falls from 12.5 to 10 at 0.5, then rises"),
        (4.0 - (X - 1.5) ** 2, "rises, then falls", "rises from 17.5 to 40 at 1.5, then falls"),
        (2.0 + np.sin(8.0 * X), "varies", "varies between 10 and 30"),
        (100.0 + 10.0 * X, "rises", "rises from 1000 to 1200"),
    ],
)
def test_trends_in_words(y: np.ndarray, shape: str, words: str) -> None:
    trend = Trend(X, y, 3.0)
    assert trend.shape == shape
    assert trend.words(10.0).startswith(words)


def test_rounding_is_no_turn() -> None:
    y = 1.0 + X + 1e-12 * np.random.default_rng(1).standard_normal(41)
    y[20:25] = y[20]
    assert Trend(X, y, 3.0).shape == "rises"


def test_an_outcome_is_what_holds() -> None:
    assert Outcome.of(True, True) is Outcome.AGREES
    assert Outcome.of(True, False) is Outcome.PARTLY
    assert Outcome.of(False, False) is Outcome.DIFFERS
    plain = Statement("1", "it rises", "it falls", Outcome.DIFFERS).as_json()
    assert plain["verdict"] == "differs"
    assert plain["why"] is None


EXPECTED = {
    "Figs 6, 12, 13 (c)": ["differs"],
    "Fig. 3": ["cannot be compared"],
    "Fig. 5": ["cannot be compared"],
    "2.2, Fig. 5": ["agrees"],
    "2.2, Figs 3 and 5": ["agrees", "agrees in part"],
    "3.1, Fig. 7": ["agrees"],
    "Fig. 10": ["cannot be compared"],
    "3.2, Fig. 11a": ["agrees"],
    "3.2, Fig. 11b": ["agrees in part"],
    "3.2": ["agrees"] * 3,
    "1": ["differs"],
    "Appendix, foot_1": ["differs"],
    "Appendix, leg_1": ["differs"],
    "Appendix, tool": ["differs"],
    "Appendix, leg_2": ["differs"],
    "Fig. 6": ["cannot be compared"],
    "Fig. 12": ["cannot be compared"],
    "Fig. 13": ["cannot be compared"],
    "2.3, Fig. 6": ["agrees in part", *["agrees"] * 4],
    "3.3, Fig. 12": ["agrees in part"],
    "3.3, Fig. 13": ["agrees", "agrees in part", "agrees"],
    "3.3, Figs 12 and 13": ["agrees"] * 2,
}


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        stiffkit.reproduce, "reproduce_briot_2009", partial(reproduce_briot_2009, steps=8)
    )
    target = tmp_path / "out"
    done = CliRunner().invoke(main, ["reproduce", "briot-2009", "-o", str(target)])
    assert done.exit_code == 0, done.output
    content = json.loads((target / "reproduction.json").read_text("utf-8"))
    assert content["paper"] == "briot-2009"
    verdicts: dict[str, list[str]] = {}
    for statement in content["statements"]:
        verdicts.setdefault(statement["where"], []).append(statement["verdict"])
    assert verdicts == EXPECTED
    assert all(s["why"] for s in content["statements"] if s["verdict"] != "agrees")
    assert len(content["family"]["alpha"]) == 8
    assert "15 agrees" in done.output
    numbers = (3, 5, 6, 7, 10, 12, 13)
    figures = {f"briot-2009-figure-{n}.{kind}" for n in numbers for kind in ("svg", "png")}
    names = {path.name for path in target.iterdir()}
    assert names == {"reproduction.json", "reproduction.html"} | figures
    page = (target / "reproduction.html").read_text("utf-8")
    assert page.count("<img") == 7
    assert page.index("Figure 3") < page.index("Figure 10")
    assert "http:" not in page
    assert "https:" not in page
