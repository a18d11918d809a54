"""PyNite: a frame in space, built once and moved by its nodes."""

from __future__ import annotations

from importlib.metadata import version

from Pynite import FEModel3D  # type: ignore[import-not-found]

from benchmarks.peers import case

WAY = "model built once, nodes moved; sparse solver, eigsh; the hinge at P is an end release"
_AXES = ("X", "Y", "Z")


def build(elements: int) -> FEModel3D:
    """Return the model; its nodes are yet to be moved."""
    model = FEModel3D()
    model.add_material("steel", case.E_MODULUS, case.G_MODULUS, case.NU, case.DENSITY)
    # The section's z axis is the normal of the plane for members in it.
    model.add_section("leg", case.AREA, case.I_Y, case.I_Z, case.TORSION)
    start = case.posture(0.5, 0.0)
    for leg in (0, 1):
        places = start.nodes(leg, elements)
        names = [_name(leg, i, elements) for i in range(elements + 1)]
        for name, (x, y) in zip(names, places, strict=True):
            if name not in model.nodes:
                model.add_node(name, x, y, 0.0)
        for i in range(elements):
            model.add_member(f"beam {leg} {i}", names[i], names[i + 1], "steel", "leg")
        model.def_support(names[0], True, False, True, True, True, False)
        model.def_support_spring(names[0], "DY", case.DRIVE)
    model.def_releases(f"beam 1 {elements - 1}", Rzj=True)
    for axis in _AXES:
        model.add_node_load("P", f"F{axis}", 1.0, case=axis)
        model.add_load_combo(axis, {axis: 1.0})
    return model


def _name(leg: int, i: int, elements: int) -> str:
    return "P" if i == elements else f"{leg} {i}"


def move(model: FEModel3D, posture: case.Posture, elements: int) -> None:
    """Move the nodes to a posture."""
    for leg in (0, 1):
        for i, (x, y) in enumerate(posture.nodes(leg, elements)):
            node = model.nodes[_name(leg, i, elements)]
            node.X, node.Y = x, y


def run(n: int) -> case.Answer:
    """Return the answer at n postures."""
    static, dynamic = build(1), build(case.ELEMENTS)
    # Masses are what weighs: with a gravity of one, loads and self-weight are kilograms.
    dynamic.add_member_self_weight("FY", -1.0, case="mass")
    dynamic.add_node_load("P", "FY", -case.TOOL_MASS, case="mass")
    dynamic.add_load_combo("mass", {"mass": 1.0})

    def compliance(posture: case.Posture) -> case.Matrix:
        move(static, posture, 1)
        static.analyze_linear()
        moved = static.nodes["P"]
        columns = [[float(getattr(moved, f"D{i}")[load]) for i in _AXES] for load in _AXES]
        return [[columns[j][i] for j in range(3)] for i in range(3)]

    def frequencies(posture: case.Posture) -> list[float]:
        move(dynamic, posture, case.ELEMENTS)
        dynamic.analyze_modal(case.N_MODES, mass_combo_name="mass")
        return sorted(float(f) for f in dynamic.frequencies)

    return case.answer("PyNite", version("PyNiteFEA"), WAY, compliance, frequencies, n)
