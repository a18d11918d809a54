"""From displacement fields to compliances with statistics."""

from stiffkit.identify.advisor import DeflectionNoise, LoadAdvice, advise
from stiffkit.identify.as_json import as_json
from stiffkit.identify.comparison import Alternative
from stiffkit.identify.compliance import identify
from stiffkit.identify.estimate import Estimate
from stiffkit.identify.estimators import Estimator, RigidFit, fit
from stiffkit.identify.field import Field
from stiffkit.identify.identified import Identified, Options
from stiffkit.identify.identified_link import (
    IdentifiedLink,
    asymmetry_of,
    estimator_word,
    identify_link,
    outlier_words,
)
from stiffkit.identify.intervals import Multiplier, multiplier
from stiffkit.identify.load_advice import LinkAdvice, advise_link
from stiffkit.identify.loads import Loads, check_loads
from stiffkit.identify.outliers import Outliers
from stiffkit.identify.readers import FieldFile, read_field_file, read_node_sets
from stiffkit.identify.residual_fields import ResidualFields, residual_fields
from stiffkit.identify.residuals import residual_sums, residuals
from stiffkit.identify.robust import RobustFit, robust_fit
from stiffkit.identify.selection import (
    Box,
    InSet,
    Layer,
    Listed,
    Near,
    Selection,
    Sphere,
    field_of,
    select,
)
from stiffkit.identify.spec import Spec, read_spec
from stiffkit.identify.spread import Spread
from stiffkit.identify.statistics import Precision, precision
from stiffkit.identify.structure import CaseStructure, residual_structure
from stiffkit.identify.treatment import Treatment
from stiffkit.identify.weights import area_weights, volume_weights

__all__ = [
    "Alternative",
    "Box",
    "CaseStructure",
    "DeflectionNoise",
    "Estimate",
    "Estimator",
    "Field",
    "FieldFile",
    "Identified",
    "IdentifiedLink",
    "InSet",
    "Layer",
    "LinkAdvice",
    "Listed",
    "LoadAdvice",
    "Loads",
    "Multiplier",
    "Near",
    "Options",
    "Outliers",
    "Precision",
    "ResidualFields",
    "RigidFit",
    "RobustFit",
    "Selection",
    "Spec",
    "Sphere",
    "Spread",
    "Treatment",
    "advise",
    "advise_link",
    "area_weights",
    "as_json",
    "asymmetry_of",
    "check_loads",
    "estimator_word",
    "field_of",
    "fit",
    "identify",
    "identify_link",
    "multiplier",
    "outlier_words",
    "precision",
    "read_field_file",
    "read_node_sets",
    "read_spec",
    "residual_fields",
    "residual_structure",
    "residual_sums",
    "residuals",
    "robust_fit",
    "select",
    "volume_weights",
]
