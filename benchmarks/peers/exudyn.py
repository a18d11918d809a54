"""Exudyn: geometrically exact beams and joints, linearised at each posture."""

from __future__ import annotations

import math
from typing import Any

import exudyn  # type: ignore[import-not-found]
import numpy as np
from exudyn.itemInterface import (  # type: ignore[import-not-found]
    CartesianSpringDamper,
    GenericJoint,
    MarkerBodyRigid,
    MarkerNodeRigid,
    NodeRigidBodyRotVecLG,
    ObjectBeamGeometricallyExact,
    ObjectGround,
    ObjectRigidBody,
)
from exudyn.solver import (  # type: ignore[import-not-found]
    ComputeLinearizedSystem,
    ComputeODE2Eigenvalues,
)

from benchmarks.peers import case

WAY = (
    "model built for each posture; geometrically exact beams, a million times as stiff in shear,"
    " sixteen elements for each leg; linearised, constraints projected out by Exudyn, NumPy"
)
_ELEMENTS = 2 * case.ELEMENTS
"""These beams are straight between nodes and bend at them, so they need more of them, for
compliances too."""
_NO_SHEAR = 1e6
"""Stiffness in shear, over what it would be."""


def section() -> Any:
    """Return the section of a leg; x is along it, z is the normal of the plane."""
    E, G, rho = case.E_MODULUS, case.G_MODULUS, case.DENSITY
    shear = _NO_SHEAR * G * case.AREA
    made = exudyn.BeamSection()
    made.massPerLength = rho * case.AREA
    made.inertia = rho * np.diag([case.I_Y + case.I_Z, case.I_Y, case.I_Z])
    made.stiffnessMatrix = np.diag(
        [E * case.AREA, shear, shear, G * case.TORSION, E * case.I_Y, E * case.I_Z]
    )
    return made


def build(posture: case.Posture) -> tuple[Any, int]:
    """Return the system at a posture, and where the coordinates of P begin."""
    system = exudyn.SystemContainer().AddSystem()
    tips = [_add_leg(system, posture, leg) for leg in (0, 1)]
    ends = [system.AddMarker(MarkerNodeRigid(nodeNumber=tip)) for tip in tips]
    system.AddObject(GenericJoint(markerNumbers=ends, constrainedAxes=[1, 1, 1, 1, 1, 0]))
    system.AddObject(ObjectRigidBody(physicsMass=case.TOOL_MASS, nodeNumber=tips[0]))
    system.Assemble()
    return system, system.GetNodeODE2Index(tips[0])


def _add_leg(system: Any, posture: case.Posture, leg: int) -> Any:
    """Add a leg with its slide and its drive, and return its last node."""
    places, length = posture.nodes(leg, _ELEMENTS), case.LENGTHS[leg] / _ELEMENTS
    x, y = places[0]
    turn = math.atan2(posture.y - y, posture.x - x)
    nodes = [
        system.AddNode(NodeRigidBodyRotVecLG(referenceCoordinates=[*at, 0.0, 0.0, 0.0, turn]))
        for at in places
    ]
    for i in range(_ELEMENTS):
        system.AddObject(
            ObjectBeamGeometricallyExact(
                nodeNumbers=nodes[i : i + 2], length=length, sectionData=section()
            )
        )
    ground = system.AddObject(ObjectGround(referencePosition=[x, y, 0.0]))
    ends = [
        system.AddMarker(MarkerBodyRigid(bodyNumber=ground)),
        system.AddMarker(MarkerNodeRigid(nodeNumber=nodes[0])),
    ]
    system.AddObject(GenericJoint(markerNumbers=ends, constrainedAxes=[1, 0, 1, 1, 1, 0]))
    drive = [0.0, case.DRIVE, 0.0]
    system.AddObject(CartesianSpringDamper(markerNumbers=ends, stiffness=drive))
    return nodes[-1]


def compliance(posture: case.Posture) -> case.Matrix:
    """Return the compliance of P, of the linearised system."""
    system, first = build(posture)
    _, stiffness, _, _, free = ComputeLinearizedSystem(
        system, projectIntoConstraintNullspace=True, returnConstraintNullspace=True
    )
    motion = free[:, first : first + 3]
    found: case.Matrix = (motion.T @ np.linalg.solve(stiffness, motion)).tolist()
    return found


def frequencies(posture: case.Posture) -> list[float]:
    """Return the lowest frequencies, Hz."""
    system, _ = build(posture)
    found, _ = ComputeODE2Eigenvalues(system, convert2Frequencies=True)
    return sorted(float(f) for f in found)[: case.N_MODES]


def run(n: int) -> case.Answer:
    """Return the answer at n postures."""
    return case.answer("Exudyn", exudyn.__version__, WAY, compliance, frequencies, n)
