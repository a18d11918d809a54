"""A study of uncertainty from its specification to a dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffkit.compiled import Backend, decided, default_backend
from stiffkit.compiled.threads import limited_threads
from stiffkit.design.uncertainty.check import add_check
from stiffkit.design.uncertainty.dataset import dataset_of
from stiffkit.design.uncertainty.first_order import FirstOrder
from stiffkit.design.uncertainty.sampling import sample
from stiffkit.design.uncertainty.spec import UncertaintySpec
from stiffkit.kinematics.numeric import one_thread
from stiffkit.progress import Progress, no_progress
from stiffkit.study.store import Kind
from stiffkit.study.sweep.family import Family
from stiffkit.study.sweep.group import Groups

if TYPE_CHECKING:
    import xarray as xr

DATASET = "uncertainty.nc"
"""File that the command writes the dataset to."""

UNCERTAINTY = Kind("study of uncertainty", (DATASET,), ("figures", "report.html"))
"""What the command leaves in a directory."""


def run_uncertainty(
    spec: UncertaintySpec, progress: Progress | None = None, backend: Backend | None = None
) -> xr.Dataset:
    """Return quantities over the workspace with bands, the share of each source, and the check.

    Raises FileError, AssemblyError or PoseError where the robot file is at fault, LinkError where a
    link cannot scatter as it should, and StiffkitError where a model has no derivatives.
    """
    report = progress or no_progress
    own = decided(backend or default_backend())
    with one_thread(), limited_threads(1):
        report("error bars of the first order", 0.0)
        everywhere = FirstOrder(spec, Groups(Family(spec.study(spec.postures)), own))
        report("error bars of the first order", 0.5)
        dataset = dataset_of(spec, everywhere)
        if spec.samples:
            report("sampling", 0.0)
            few = FirstOrder(spec, Groups(Family(spec.study(spec.sampled_postures)), own))
            add_check(dataset, spec, few, sample(spec, few, report))
    return dataset
