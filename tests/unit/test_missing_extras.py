"""What is said where an optional part is not installed, or cannot be loaded."""

from __future__ import annotations

import pytest

from stiffkit.errors import MissingExtraError, StiffkitError, how_to_install, optional


def test_what_is_not_installed_is_named_with_its_extra() -> None:
    with (
        pytest.raises(MissingExtraError) as caught,
        optional("Nowhere", needed_for="nothing", extra="fea"),
    ):
        import nowhere_to_be_found  # type: ignore[import-not-found]  # noqa: F401
    assert caught.value.what == "Nowhere is needed for nothing and is not installed"
    assert caught.value.mend == "pip install 'stiffkit[fea]'" == how_to_install("fea")
    assert caught.value.extra == "fea"


def test_another_way_is_told() -> None:
    with (
        pytest.raises(MissingExtraError) as caught,
        optional("pymoo", needed_for="evolution", extra="design", or_="or wait"),
    ):
        raise ModuleNotFoundError
    assert caught.value.mend == "pip install 'stiffkit[design]', or wait"


def test_what_is_broken_is_not_called_missing() -> None:
    with (
        pytest.raises(MissingExtraError, match=r"cannot be loaded \(libGL\.so\.1: cannot open\)"),
        optional("NGSolve", needed_for="links from CAD", extra="fea"),
    ):
        raise ImportError("libGL.so.1: cannot open")


def test_other_errors_pass() -> None:
    with (
        pytest.raises(StiffkitError, match="something else"),
        optional("NGSolve", needed_for="links from CAD", extra="fea"),
    ):
        raise StiffkitError("something else")
