import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stiffkit.link import (
    Material,
    Section,
    beam_compliance,
    beam_inertia,
    box,
    check_compliance,
    check_inertia,
    doubts_inertia,
    rectangle,
    round_bar,
    tube,
)
from stiffkit.spatial import Frame, exp_rotation, shift_compliance

size = st.floats(1e-3, 0.3)
length = st.floats(0.01, 3.0)
share = st.floats(0.01, 0.49)

materials = st.builds(
    Material,
    st.just("any"),
    E=st.floats(1e9, 4e11),
    nu=st.floats(-0.9, 0.49),
    density=st.floats(500, 20000),
)
sections = st.one_of(
    st.builds(round_bar, size),
    st.builds(lambda d, part: tube(d, part * d), size, share),
    st.builds(rectangle, size, size),
    st.builds(lambda w, h, part: box(w, h, part * min(w, h)), size, size, share),
)
frames = st.builds(
    lambda turn, shift: Frame(exp_rotation(turn), np.array(shift)),
    st.tuples(*[st.floats(-3, 3)] * 3),
    st.tuples(*[st.floats(-2, 2)] * 3),
)


@given(length, sections, materials)
def test_every_beam_is_an_elastic_body(L: float, section: Section, material: Material) -> None:
    assert check_compliance(beam_compliance(L, section, material)) == []
    mass, _, inertia = beam_inertia(L, section, material)
    assert check_inertia(mass, inertia) == []
    assert doubts_inertia(mass, inertia) == []


@given(sections, materials)
def test_torsion_constant_is_below_the_polar_moment(section: Section, material: Material) -> None:
    assert section.torsion <= (section.Iy + section.Iz) * (1 + 1e-12)
    shear_y, shear_z = section.shear_coefficients(material.nu)
    assert shear_y is not None
    assert shear_z is not None
    assert 0 < shear_y < 1
    assert 0 < shear_z < 1


@given(length, st.floats(0.05, 0.95), sections, materials)
def test_two_pieces_in_a_row_are_the_whole_beam(
    L: float, cut: float, section: Section, material: Material
) -> None:
    whole = beam_compliance(L, section, material)
    first = beam_compliance(cut * L, section, material)
    second = beam_compliance((1 - cut) * L, section, material)
    # In the frame of the whole beam's tip the end of the first piece lies at -(1 - cut) L.
    chain = shift_compliance(first, Frame.at(-(1 - cut) * L)) + second
    scale = np.sqrt(np.outer(np.diag(whole), np.diag(whole)))
    np.testing.assert_allclose(chain / scale, whole / scale, atol=1e-12)


@given(length, st.floats(0.05, 0.95), sections, materials)
def test_two_pieces_weigh_what_the_whole_beam_does(
    L: float, cut: float, section: Section, material: Material
) -> None:
    mass, center, inertia = beam_inertia(L, section, material)
    pieces = [beam_inertia(part * L, section, material) for part in (cut, 1 - cut)]
    centers = [pieces[0][1], pieces[1][1] + [cut * L, 0, 0]]
    masses = [piece[0] for piece in pieces]
    steiner = np.zeros((3, 3))
    for m, c, piece in zip(masses, centers, pieces, strict=True):
        r = c - center
        steiner += piece[2] + m * (r @ r * np.eye(3) - np.outer(r, r))
    assert np.isclose(sum(masses), mass)
    np.testing.assert_allclose(steiner, inertia, rtol=1e-9, atol=1e-12 * inertia.max())


@given(length, sections, materials, frames)
def test_seen_from_elsewhere_it_is_still_the_same_body(
    L: float, section: Section, material: Material, T: Frame
) -> None:
    k = beam_compliance(L, section, material)
    moved = shift_compliance(k, T)
    back = shift_compliance(moved, T.inverse)
    tolerance = 1e-11 * moved.max()
    np.testing.assert_allclose(back, k, atol=tolerance, rtol=0)
    # Rotational compliance only turns with the axes, wherever the point is.
    np.testing.assert_allclose(
        np.linalg.eigvalsh(moved[3:, 3:]), np.linalg.eigvalsh(k[3:, 3:]), rtol=1e-9
    )


@given(length, sections, materials, frames, st.tuples(*[st.floats(-1, 1)] * 6))
def test_energy_does_not_depend_on_the_frame(
    L: float,
    section: Section,
    material: Material,
    T_A_B: Frame,
    load: tuple[float, ...],
) -> None:
    k_B = beam_compliance(L, section, material)
    wrench_B = np.array(load)
    # The same load in A at A's origin.
    R, p = T_A_B.rotation, T_A_B.position
    force = R @ wrench_B[:3]
    wrench_A = np.concatenate([force, R @ wrench_B[3:] + np.cross(p, force)])
    k_A = shift_compliance(k_B, T_A_B)
    energy = wrench_B @ k_B @ wrench_B
    assert np.isclose(wrench_A @ k_A @ wrench_A, energy, rtol=0, atol=1e-11 * k_A.max())


@given(length, sections, materials)
def test_a_stiffer_material_deforms_less(L: float, section: Section, material: Material) -> None:
    stiffer = Material("stiffer", 2 * material.E, material.nu, material.density)
    np.testing.assert_allclose(
        beam_compliance(L, section, stiffer), beam_compliance(L, section, material) / 2
    )
