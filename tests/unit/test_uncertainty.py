"""Error bars of the first order, against theory and against samples."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from tests.unit.identified_beam import beam_compliance

from stiffkit.design.uncertainty import read_uncertainty, run_uncertainty
from stiffkit.design.uncertainty.links import covariance_of, root_of
from stiffkit.design.uncertainty.spec import UncertainLink
from stiffkit.design.uncertainty.summary import part_rows, summaries
from stiffkit.errors import LinkError, StiffkitError
from stiffkit.link.file import LinkFile, write_link_file
from stiffkit.robot import Link
from stiffkit.robot.catalogue import find_robot
from stiffkit.spatial import Frame
from stiffkit.spatial.rotation import Array

BEAM = """\
robot: One beam
parameters: {reach: 500 mm}
links:
  beam: {beam: {length: = reach, section: {round: 20 mm}, material: steel}}
joints:
  root: {prismatic: z, from: base, to: beam.base, drive: rigid}
tool: {at: beam.tip}
home: {z: 0}
workspace: {z: [-10 mm, 10 mm]}
loads:
  down: {force: [0, 0, -10 N]}
  pull: {force: [10 N, 0, 0]}
"""


def run(here: Path, robot: str, text: str) -> xr.Dataset:
    """Run a study of a robot, of the catalogue or the text of a file; few postures, no samples."""
    if "\n" in robot:
        (here / "own.yaml").write_text(robot, encoding="utf-8")
        robot = "own.yaml"
    few = "".join(
        f"{key}: {value}\n"
        for key, value in {"postures": 9, "samples": 0}.items()
        if f"{key}:" not in text
    )
    path = here / "study.yaml"
    path.write_text(f"uncertainty: Test\nrobot: {robot}\n{text}{few}", encoding="utf-8")
    return run_uncertainty(read_uncertainty(path), backend="numpy")


# --- where the first order is exact ---------------------------------------------------------------


def test_a_deflection_scatters_as_the_one_link_that_yields(tmp_path: Path) -> None:
    text = "links: {beam: {sigma: 3 %}}\nquantities: {sag: {deflection_z: down}}\nsamples: 2000\n"
    found = run(tmp_path, BEAM, text)
    sag = found["sag"].sel(model="refined").values
    # Euler-Bernoulli: F L^3 / (3 E I), and a little for shear.
    bending = 10.0 * 0.5**3 / (3.0 * 2.1e11 * np.pi * 0.02**4 / 64.0)
    np.testing.assert_allclose(sag, bending, rtol=0.02)
    np.testing.assert_allclose(found["sag_sigma"].values[0], 0.03 * sag, rtol=1e-9)
    width = found["sag_high"] - found["sag_low"]
    np.testing.assert_allclose(width.values[0], 2.0 * 1.959964 * 0.03 * sag, rtol=1e-6)
    sampled = found["sag_sampled_sigma"] / found["sag_sampled_first_order_sigma"]
    np.testing.assert_allclose(sampled, 1.0, atol=4.0 / np.sqrt(2 * 2000))
    coverage = found["sag_sampled_coverage"].values
    np.testing.assert_allclose(coverage, 0.95, atol=4.0 * np.sqrt(0.95 * 0.05 / 2000))
    assert found.attrs["samples"] == 2000
    assert found.attrs["samples_refused"] == 0


def test_a_length_carries_its_error_through_its_power(tmp_path: Path) -> None:
    """Tension goes with the length, so its relative error is that of the length."""
    text = "parameters: {reach: {tolerance: 3 mm}}\nquantities: {long: {deflection_xy: pull}}\n"
    found = run(tmp_path, BEAM, text)
    relative = (found["long_sigma"] / found["long"]).values
    np.testing.assert_allclose(relative, 3e-3 / 0.5 / np.sqrt(3.0), rtol=1e-7)


def test_sources_add_as_variances(tmp_path: Path) -> None:
    text = (
        "parameters: {reach: {sigma: 4 %}}\nlinks: {beam: {sigma: 3 %}}\n"
        "quantities: {long: {deflection_xy: pull}}\n"
    )
    found = run(tmp_path, BEAM, text)
    np.testing.assert_allclose((found["long_sigma"] / found["long"]).values, 0.05, rtol=1e-7)
    causes = found["long_cause"].sel(model="refined").mean("z")
    np.testing.assert_allclose(causes.sel(source=["reach", "beam"]), [0.64, 0.36], rtol=1e-7)
    (summary,) = summaries(found)
    assert list(summary.causes) == ["reach", "beam"]


# --- identified links -----------------------------------------------------------------------------


def covariance(k: Array) -> Array:
    """Return a covariance (36, 36) with correlations, in proportion to a compliance (6, 6)."""
    random = np.random.default_rng(4)
    scale = 0.02 * np.sqrt(np.outer(np.diag(k), np.diag(k))).ravel()
    roots = scale[:, None] * random.normal(size=(36, 50)) / np.sqrt(50)
    return np.asarray(roots @ roots.T)


def identified(here: Path) -> Array:
    """Write an identified link, all of whose elements are there, and return its covariance."""
    k = beam_compliance()
    tilt = 1e-3 * np.sqrt(np.outer(np.diag(k), np.diag(k)))
    of_elements = covariance(k)
    link = LinkFile("beam", {"tip": Frame.at(1.0)}, k + tilt, covariance=of_elements)
    write_link_file(link, here / "beam.link.yaml")
    return of_elements


def test_an_identified_link_carries_its_covariance(tmp_path: Path) -> None:
    of_elements = identified(tmp_path)
    robot = BEAM.replace(
        "{beam: {length: = reach, section: {round: 20 mm}, material: steel}}",
        "{compliance: beam.link.yaml}",
    )
    text = "quantities: {sag: {deflection_z: down}}\nsamples: 3000\n"
    found = run(tmp_path, robot, text)
    assert list(found["source"].values) == ["beam"]
    # Under a force along z the deflection along z is 10 N times k33.
    expected = 10.0 * np.sqrt(of_elements[6 * 2 + 2, 6 * 2 + 2])
    np.testing.assert_allclose(found["sag_sigma"].values, expected, rtol=1e-9)
    sampled = found["sag_sampled_sigma"].values
    np.testing.assert_allclose(sampled, expected, rtol=4.0 / np.sqrt(2 * 3000))


def test_the_lower_triangle_is_that_of_the_symmetric_part() -> None:
    k = beam_compliance()
    k += 1e-3 * np.sqrt(np.outer(np.diag(k), np.diag(k)))
    of_elements = covariance(k)
    link = Link("beam", {"base": Frame()}, compliance=k, covariance=of_elements)
    found = covariance_of(link, UncertainLink("beam", None))
    random = np.random.default_rng(0)
    samples = random.multivariate_normal(np.zeros(36), of_elements, size=20_000, method="eigh")
    matrices = samples.reshape(-1, 6, 6)
    symmetric = 0.5 * (matrices + matrices.transpose(0, 2, 1))
    lower = symmetric[:, *np.tril_indices(6)]
    size = np.sqrt(np.outer(np.diag(found), np.diag(found)))
    np.testing.assert_allclose(np.cov(lower.T) / size, found / size, atol=0.05)


def test_a_root_gives_its_covariance_back() -> None:
    of_elements = covariance(beam_compliance())
    root = root_of(of_elements)
    size = np.sqrt(np.outer(np.diag(of_elements), np.diag(of_elements)))
    np.testing.assert_allclose(root @ root.T / size, of_elements / size, atol=1e-9)
    assert root_of(np.outer([1.0, 2.0, 0.0], [1.0, 2.0, 0.0])).shape == (3, 1)


def test_what_cannot_scatter_is_refused() -> None:
    rigid = Link("arm", {"base": Frame()})
    with pytest.raises(LinkError, match="rigid"):
        covariance_of(rigid, UncertainLink("arm", 0.02))
    beam = Link("arm", {"base": Frame()}, compliance=beam_compliance())
    with pytest.raises(LinkError, match="not identified"):
        covariance_of(beam, UncertainLink("arm", None))
    zeros = Link("arm", {}, compliance=beam_compliance(), covariance=covariance(beam_compliance()))
    with pytest.raises(LinkError, match="exactly zero"):
        covariance_of(zeros, UncertainLink("arm", None))


# --- whole robots ---------------------------------------------------------------------------------


@pytest.mark.parametrize("robot", ["biglide", "five-bar", "gough-stewart", "3-rrr"])
def test_the_shares_of_parts_add_up_to_one(robot: str, tmp_path: Path) -> None:
    name = {"biglide": "a", "five-bar": "base"}.get(robot, "base_radius")
    found = run(tmp_path, robot, f"parameters: {{{name}: {{sigma: 0.1 %}}}}\n")
    for summary in summaries(found):
        rows = part_rows(found, summary.name)
        assert sum(row.share for row in rows) == pytest.approx(1.0, abs=1e-9)
        assert sum(row.share_at_worst for row in rows) == pytest.approx(1.0, abs=1e-9)
        assert rows == sorted(rows, key=lambda row: -round(row.share, 9))
        for row in rows:
            assert row.kind in ("link", "drive", "joint")
            if np.isfinite(row.mass):
                assert row.gain_per_kg == pytest.approx(row.share / row.mass)


def test_a_share_is_what_stiffening_the_part_gains(tmp_path: Path) -> None:
    text = (
        "parameters: {base: {sigma: 0.1 %}}\nquantities: {push: {deflection_translation: push}}\n"
    )
    found = run(tmp_path, "five-bar", text)
    shares = {row.name: row.share for row in part_rows(found, "push")}
    stiffer = find_robot("five-bar").read_text(encoding="utf-8")
    assert "drive: 2e4 N m/rad" in stiffer
    after = run(tmp_path, stiffer.replace("drive: 2e4 N m/rad", "drive: 2.02e4 N m/rad"), text)
    gained = 1.0 - (after["push"] / found["push"]).values.mean()
    drives = shares["motor_left"] + shares["motor_right"]
    assert gained == pytest.approx(drives * (1.0 - 1.0 / 1.01), rel=1e-3)


@pytest.mark.parametrize("robot", ["five-bar", "biglide"])
def test_samples_agree_with_the_first_order(robot: str, tmp_path: Path) -> None:
    text = {
        "five-bar": "parameters: {proximal: {tolerance: 0.1 mm}, distal: {sigma: 0.1 %}}\n"
        "links: {left_arm: {sigma: 2 %}}\nquantities: {push: {deflection_translation: push}}\n",
        "biglide": "parameters: {L1: {tolerance: 1 mm}, drive: {sigma: 2 %}}\n"
        "links: {leg_1: {sigma: 2 %}}\nquantities: {push: {deflection_translation: f_y}}\n",
    }[robot]
    n = 300
    found = run(tmp_path, robot, f"{text}samples: {n}\nseed: 2\nsampled postures: 9\n")
    ratio = found["push_sampled_sigma"] / found["push_sampled_first_order_sigma"]
    np.testing.assert_allclose(ratio, 1.0, atol=4.0 / np.sqrt(2 * n))
    coverage = found["push_sampled_coverage"].values
    np.testing.assert_allclose(coverage, 0.95, atol=4.0 * np.sqrt(0.95 * 0.05 / n))


def test_the_same_seed_draws_the_same_robots(tmp_path: Path) -> None:
    text = "links: {beam: {sigma: 3 %}}\nquantities: {sag: {deflection_z: down}}\nsamples: 20\n"
    first, again = run(tmp_path, BEAM, text), run(tmp_path, BEAM, text)
    other = run(tmp_path, BEAM, f"{text}seed: 1\n")
    assert first["sag_sampled_mean"].equals(again["sag_sampled_mean"])
    assert not first["sag_sampled_mean"].equals(other["sag_sampled_mean"])


def test_rounding_errors_do_not_scatter(tmp_path: Path) -> None:
    """A planar robot whose drives alone yield does not deflect across its plane."""
    text = (
        "parameters: {base: {sigma: 0.1 %}}\nmodels: [refined, simplified]\nsamples: 20\n"
        "quantities: {lifted: {deflection_z: lift}}\n"
    )
    found = run(tmp_path, "five-bar", text).sel(model="simplified")
    assert (found["lifted"] == 0.0).all()
    assert (found["lifted_sigma"] == 0.0).all()
    assert np.isnan(found["lifted_sampled_coverage"]).all()


def test_a_robot_without_derivatives_is_refused(tmp_path: Path) -> None:
    robot = find_robot("five-bar").read_text(encoding="utf-8")
    passive = "elbow_left: {revolute: z,"
    assert passive in robot
    robot = robot.replace(passive, f"{passive} drive: 1e4 N m/rad,")
    with pytest.raises(StiffkitError, match="no exact derivatives"):
        run(tmp_path, robot, "parameters: {base: {sigma: 0.1 %}}\nmodels: [simplified]\n")
