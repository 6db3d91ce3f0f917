"""Checks of the links: mass and inertia of a rigid body."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from wbc.errors import RobotDescriptionError
from wbc.robot.finding import Finding
from wbc.robot.inertia import is_physical
from wbc.robot.urdf import Urdf

# A radius of gyration above this means a wrong unit, m.
GYRATION = 1.0
# Lines printed with few digits break the triangle inequality by this much, relative.
PRINTED_PRECISION = 1e-3
# A radius of gyration below this means a point mass, m.
MIN_GYRATION = 1e-5
# Exporters give massless frames a tiny mass with some inertia; it has no effect, kg.
NEGLIGIBLE_MASS = 1e-3
ADD_INERTIAL = "add <inertial> with mass, centre and inertia (from CAD, or of its shape as a solid)"


def check_links(urdf: Urdf) -> list[Finding]:
    """Return findings on links without inertia and on non-physical inertias."""
    driven = {joint.child for joint in urdf.joints if joint.type != "fixed"}
    findings: list[Finding] = []
    for name, link in urdf.links.items():
        inertial = link.find("inertial")
        try:
            if inertial is not None:
                findings += _inertial(urdf, name, inertial, name in driven)
            elif name in driven:
                findings.append(_massless_axis(name, urdf.line(link)))
            elif link.find("visual") is not None or link.find("collision") is not None:
                findings.append(_massless_shape(name, urdf.line(link)))
        except RobotDescriptionError as error:
            findings.append(Finding.from_error(error, name, "unreadable-number"))
    return findings


def _massless_axis(name: str, line: int) -> Finding:
    return Finding(
        "note",
        name,
        f"moves by a joint of its own and has no <inertial> (line {line})",
        "the links beyond it must have inertia; it gets a milligram for the physics engine",
        f"{ADD_INERTIAL}, unless it only connects two axes",
        "no-inertia",
    )


def _massless_shape(name: str, line: int) -> Finding:
    return Finding(
        "note",
        name,
        f"has a shape but no <inertial> (line {line})",
        "it weighs nothing, so the robot is lighter than its parts",
        f"{ADD_INERTIAL}, unless the link that it is fixed to has its mass",
        "no-inertia",
    )


def _inertial(urdf: Urdf, name: str, inertial: ET.Element, driven: bool) -> list[Finding]:
    mass = urdf.numbers(inertial.find("mass"), "value", (0.0,))[0]
    element = inertial.find("inertia")
    xx, xy, xz, yy, yz, zz = (
        urdf.numbers(element, key, (0.0,))[0] for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    )
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    place = f"(line {urdf.line(inertial)})"
    if mass < 0.0:
        return [
            Finding(
                "error",
                name,
                f"has the mass {mass:g} kg {place}",
                "no rigid body can have this; the file is refused",
                "state a positive mass",
                "negative-mass",
            )
        ]
    if mass == 0.0:
        if inertia.any():
            return [_not_physical(name, f"has inertia but no mass {place}", driven)]
        # On a fixed joint a frame without mass and inertia is a fixture, not a mistake.
        return [_massless_axis(name, urdf.line(inertial))] if driven else []
    moments = np.linalg.eigvalsh(inertia)
    if np.abs(moments).max() < MIN_GYRATION**2 * mass:
        what = f"has mass but no inertia, as if it were a point {place}"
        return [_not_physical(name, what, driven)]
    listed = ", ".join(f"{moment:.3g}" for moment in moments)
    if moments[0] <= 0.0:
        what = f"has principal moments {listed} kg·m², not all positive {place}"
        return [_not_physical(name, what, driven)]
    if not is_physical(mass, inertia, PRINTED_PRECISION):
        what = f"has principal moments {listed} kg·m², the last above the sum of the others {place}"
        return [_not_physical(name, what, driven)]
    gyration = float(np.sqrt(moments[2] / mass))
    if gyration < GYRATION or mass < NEGLIGIBLE_MASS:
        return []
    return [
        Finding(
            "warning",
            name,
            f"has an inertia of {moments[2]:.3g} kg·m² on {mass:g} kg {place}: "
            f"its mass would lie {gyration:.2g} m from its centre",
            "the joints near it accelerate far too slowly",
            "check the unit: URDF has kg·m², CAD programs often kg·mm² or g·mm²",
            "implausible-inertia",
        )
    ]


def _not_physical(name: str, what: str, driven: bool) -> Finding:
    return Finding(
        "warning" if driven else "note",
        name,
        what,
        "no rigid body can have this"
        + ("" if driven else "; the body that it is fixed to is repaired if it needs to be"),
        "correct the <inertia>: positive principal moments, none above the sum of the others",
        "non-physical-inertia",
    )


def check_masses(urdf: Urdf, massless: list[tuple[str, float]]) -> list[Finding]:
    """Return a finding for each joint that moves no inertia, on the link that lacks it."""
    child = {joint.name: joint.child for joint in urdf.joints}
    return [
        Finding(
            "error",
            child[joint],
            f"its joint '{joint}' moves nothing that has inertia "
            f"(line {urdf.line(urdf.links[child[joint]])})",
            "the mass matrix is singular and accelerations are undefined; the file is refused",
            f"give '{child[joint]}' an <inertial>, or weld the joint: fixed_joints = ['{joint}']",
            "singular-mass-matrix",
        )
        for joint, _ in massless
    ]
