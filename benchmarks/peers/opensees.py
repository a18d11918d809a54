"""OpenSees by OpenSeesPy: a frame in space, built anew for each posture, as its users do it."""

from __future__ import annotations

import math

import openseespy.opensees as ops  # type: ignore[import-not-found]

from benchmarks.peers import case

WAY = "model built for each posture; linear static analysis, eigen with ARPACK"


def build(posture: case.Posture, elements: int) -> None:
    """Build the model: legs of elements with consistent mass, hinges as equal displacements."""
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    ops.geomTransf("Linear", 1, 0.0, 0.0, 1.0)
    ops.uniaxialMaterial("Elastic", 1, case.DRIVE)
    for leg in (0, 1):
        base = 1000 * (leg + 1)
        for i, (x, y) in enumerate(posture.nodes(leg, elements)):
            ops.node(base + i, x, y, 0.0)
        x, y = posture.sliders[leg]
        ops.node(base + 900, x, y, 0.0)
        ops.fix(base + 900, 1, 1, 1, 1, 1, 1)
        ops.fix(base, 1, 0, 1, 1, 1, 0)
        ops.element("zeroLength", base + 900, base + 900, base, "-mat", 1, "-dir", 2)
        for i in range(elements):
            ops.element(
                *("elasticBeamColumn", base + i, base + i, base + i + 1),
                *(case.AREA, case.E_MODULUS, case.G_MODULUS, case.TORSION),
                # The local z axis is the normal of the plane.
                *(case.I_Y, case.I_Z, 1, "-mass", case.DENSITY * case.AREA, "-cMass"),
            )
    tips = (1000 + elements, 2000 + elements)
    ops.equalDOF(*tips, 1, 2, 3, 4, 5)
    ops.mass(tips[0], *([case.TOOL_MASS] * 3), 0.0, 0.0, 0.0)
    ops.constraints("Transformation")
    ops.numberer("RCM")


def compliance(posture: case.Posture) -> case.Matrix:
    """Return the compliance of P by three load cases."""
    build(posture, 1)
    ops.system("BandSPD")
    ops.test("NormDispIncr", 1e-10, 1)
    ops.algorithm("Linear")
    ops.integrator("LoadControl", 1.0)
    ops.analysis("Static", "-noWarnings")
    ops.timeSeries("Constant", 1)
    columns = []
    for axis in range(3):
        ops.pattern("Plain", axis + 1, 1)
        ops.load(1001, *(1.0 if i == axis else 0.0 for i in range(6)))
        ops.analyze(1)
        columns.append([ops.nodeDisp(1001, i + 1) for i in range(3)])
        ops.remove("loadPattern", axis + 1)
    return [[columns[j][i] for j in range(3)] for i in range(3)]


def frequencies(posture: case.Posture) -> list[float]:
    """Return the lowest frequencies, Hz."""
    build(posture, case.ELEMENTS)
    return [math.sqrt(value) / (2.0 * math.pi) for value in ops.eigen(case.N_MODES)]


def run(n: int) -> case.Answer:
    """Return the answer at n postures."""
    return case.answer("OpenSees", str(ops.version()), WAY, compliance, frequencies, n)
