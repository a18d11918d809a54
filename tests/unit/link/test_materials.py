import math

import pytest

from stiffkit.errors import LinkError
from stiffkit.link import MATERIALS, Material


def test_shear_modulus() -> None:
    material = Material("any", E=200e9, nu=0.25, density=1.0)
    assert math.isclose(material.G, 80e9)


def test_the_table_has_the_usual_ones_under_their_own_names() -> None:
    usual = {"steel", "stainless_steel", "aluminium", "titanium", "cast_iron", "brass", "pom"}
    assert usual <= set(MATERIALS)
    assert all(material.name == name for name, material in MATERIALS.items())


def test_metals_carry_sound_at_the_speed_of_metals() -> None:
    for name in set(MATERIALS) - {"pom", "peek"}:
        material = MATERIALS[name]
        assert 3000 < math.sqrt(material.E / material.density) < 5300


@pytest.mark.parametrize("E", [0.0, -1e9, math.nan, math.inf])
def test_youngs_modulus_must_be_positive(E: float) -> None:
    with pytest.raises(LinkError, match="material odd: Young's modulus") as caught:
        Material("odd", E=E, nu=0.3, density=1000.0)
    assert f"is {E:g} Pa" in caught.value.what


@pytest.mark.parametrize("nu", [-1.0, 0.5, 0.7, math.nan])
def test_poissons_ratio_has_bounds(nu: float) -> None:
    with pytest.raises(LinkError, match=f"Poisson's ratio is {nu:g}"):
        Material("odd", E=1e9, nu=nu, density=1000.0)


@pytest.mark.parametrize("density", [0.0, -7850.0, math.nan])
def test_density_must_be_positive(density: float) -> None:
    with pytest.raises(LinkError, match=f"the density is {density:g}"):
        Material("odd", E=1e9, nu=0.3, density=density)
