"""Armature and joint limits, and the substitutes for those a file leaves out."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from wbc.errors import RobotDescriptionError, did_you_mean
from wbc.robot.data_file import RobotData
from wbc.robot.finding import Finding

# A substitute limit lets a joint carry this multiple of the weight that it moves.
STRENGTH = 2.0
# ... but at least this, N·m or N, so that massless fingers can move.
MIN_EFFORT = 1.0


def set_armature(model: pin.Model, data: RobotData) -> None:
    """Write the stated rotor inertia into `model.armature` (nv,); the base has none."""
    armature, source = np.zeros(model.nv), f"{data.source_of('armature')}: armature"
    if isinstance(data.armature, Mapping):
        by_name = dict(data.armature)
        armature[6:] = by_name.pop("default", 0.0)
        for name, value in by_name.items():
            armature[velocity_index(model, name, source)] = value
    else:
        armature[6:] = data.armature
    model.armature = armature


def set_limits(
    model: pin.Model, data: RobotData, legs: tuple[tuple[int, ...], ...]
) -> list[Finding]:
    """Write stated limits into the model, and substitutes for the absent ones.

    A zero effort or velocity in a URDF means that it is unknown. An effort is then estimated
    from the mass that the joint carries, because controller and plant need a finite one; a
    velocity becomes infinite, that is unlimited.
    """
    effort, velocity = np.array(model.effortLimit), np.array(model.velocityLimit)
    for name, value in data.effort_limits.items():
        where = f"{data.source_of('effort_limits')}: effort_limits"
        effort[velocity_index(model, name, where)] = value
    for name, value in data.velocity_limits.items():
        where = f"{data.source_of('velocity_limits')}: velocity_limits"
        velocity[velocity_index(model, name, where)] = value
    findings = []
    for joint in range(2, model.njoints):
        name, index = model.names[joint], model.joints[joint].idx_v
        if not (np.isfinite(effort[index]) and effort[index] > 0.0):
            effort[index] = default_effort(model, joint, any(index in leg for leg in legs))
            findings.append(
                Finding(
                    "warning",
                    name,
                    "its effort limit is zero or absent",
                    f"{effort[index]:.3g} N·m is assumed, from the mass that it carries",
                    "state the motor's peak in <limit effort=…> or under effort_limits",
                    "no-effort-limit",
                )
            )
        if not (np.isfinite(velocity[index]) and velocity[index] > 0.0):
            velocity[index] = np.inf
            findings.append(
                Finding(
                    "warning",
                    name,
                    "its velocity limit is zero or absent",
                    "it is taken as unlimited",
                    "state the motor's top speed in <limit velocity=…> or under velocity_limits",
                    "no-velocity-limit",
                )
            )
    model.effortLimit, model.velocityLimit = effort, velocity
    return findings


def default_effort(model: pin.Model, joint: int, in_leg: bool) -> float:
    """Return an effort limit for a joint that states none, N·m or N.

    A leg joint must lift the whole robot with the distance to the next joint as its lever; any
    other joint must lift the bodies beyond it.
    """
    subtree = model.subtrees[joint]
    reach = sum(float(np.linalg.norm(model.jointPlacements[j].translation)) for j in subtree[1:2])
    mass = sum(model.inertias[j].mass for j in subtree)
    if in_leg:
        mass = sum(body.mass for body in model.inertias)
    lever = max(reach, 0.25)
    gravity = float(np.linalg.norm(model.gravity.linear))
    return float(max(STRENGTH * gravity * mass * lever, MIN_EFFORT))


def velocity_index(model: pin.Model, name: str, where: str) -> int:
    """Index into nv of a joint that a table of a data file names; `where` is for the message.

    Raises:
        RobotDescriptionError: the model has no such actuated joint.
    """
    joint = model.getJointId(name) if model.existJointName(name) else 0
    if joint < 2:
        raise RobotDescriptionError(
            f"{where}: the model has no joint '{name}'{did_you_mean(name, list(model.names)[2:])}"
        )
    return int(model.joints[joint].idx_v)
