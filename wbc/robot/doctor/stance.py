"""Checks of the loaded robot in its nominal posture: soles, balance, legs and strength."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from wbc.robot.finding import Finding
from wbc.robot.posture import find_knee, has_soles
from wbc.robot.soles import WIDE
from wbc.robot.standing import unevenness
from wbc.robot.statics import holding_torques

if TYPE_CHECKING:
    from wbc.robot.robot import Robot

# A sole may be this far from level and from the other one, rad and m.
TILT, HEIGHT = 1e-3, 1e-4
# Below this singular value of its Jacobian a leg cannot move the foot in some direction.
SINGULAR = 1e-2
# Two soles whose sizes differ by more are not a pair, relative.
UNLIKE = 0.1
# Mass over the cube of the leg's length, kg/m³: humans and humanoids have 20 to 300.
DENSITY = (0.5, 5000.0)
# Condition number of the mass matrix above which its inverse has lost half its digits.
ILL_CONDITIONED = 1e8


def check_stance(robot: Robot) -> list[Finding]:
    """Return findings on soles, centre of mass, joint range, legs, mass matrix and torques."""
    return [
        *_soles(robot),
        *_heading(robot),
        *_balance(robot),
        *_range(robot),
        *_legs(robot),
        *_mass(robot),
        *_mass_matrix(robot),
        *_strength(robot),
    ]


def _soles(robot: Robot) -> list[Finding]:
    ids = tuple(sole.frame_id for sole in robot.soles)
    tilt, height = unevenness(robot.model, robot.q_nominal, ids)
    findings = []
    tilt = 0.0 if all(robot.point_feet) else tilt
    if tilt > TILT or height > HEIGHT:
        findings.append(
            Finding(
                "error",
                robot.soles[0].link,
                f"the soles are {np.rad2deg(tilt):.1f}° from level and {1e3 * height:.1f} mm "
                "apart in height in the nominal posture, and the legs cannot level them",
                "the robot cannot stand in it",
                "state a nominal posture with the feet flat, or legs with more joints",
                "sole-not-flat",
            )
        )
    if robot.is_quadruped:  # which stands on points
        return findings
    for sole in robot.soles:
        if not has_soles((sole, sole)):
            findings.append(
                Finding(
                    "warning",
                    sole.link,
                    f"its sole is {sole.size_text}, almost a point",
                    "it carries no moment, so that the robot steps in place instead of standing",
                    "give the foot a flat collision shape, if it has one",
                    "point-foot",
                )
            )
        if sole.half_width > WIDE * sole.half_length and has_soles((sole, sole)):
            findings.append(
                Finding(
                    "warning",
                    sole.link,
                    f"its sole is {sole.size_text} (length × width), wider than long",
                    "forward may be the wrong way, or the meshes are turned",
                    "check left_foot and right_foot; if the Collada meshes mean their <up_axis>, "
                    "state respect_up_axis = true",
                    "wide-sole",
                )
            )
    findings += _overlap(robot)
    left, right = ((s.half_length, s.half_width) for s in robot.soles)
    if not np.allclose(left, right, rtol=UNLIKE, atol=1e-3):
        findings.append(
            Finding(
                "warning",
                robot.soles[1].link,
                f"its sole ({robot.soles[1].size_text}) differs from the left one "
                f"({robot.soles[0].size_text})",
                "the robot balances worse on the smaller sole",
                "compare the feet's collision shapes",
                "unlike-soles",
            )
        )
    return findings


def _overlap(robot: Robot) -> list[Finding]:
    """Soles side by side whose rectangles overlap."""
    ahead, apart = np.abs(_sole_distance(robot)[:2])
    left, right = robot.soles
    width, length = left.half_width + right.half_width, left.half_length + right.half_length
    if apart >= width or ahead >= length:
        return []
    return [
        Finding(
            "warning",
            right.link,
            f"its sole overlaps the left one by {1e3 * (width - apart):.0f} mm in the nominal "
            "posture",
            "the feet collide; the gait keeps them farther apart",
            "check the feet's collision shapes, or state a posture with the feet farther apart",
            "overlapping-soles",
        )
    ]


def _heading(robot: Robot) -> list[Finding]:
    """A base whose x axis points against the heading of the soles."""
    rotation = pin.XYZQUATToSE3(robot.q_nominal[:7]).rotation
    if rotation[0, 0] > 0.0 or abs(rotation[2, 2]) < 0.5:
        return []
    return [
        Finding(
            "warning",
            robot.base,
            "its x axis points backwards when the left foot is on the left",
            "if the feet are exchanged, the robot walks backwards; if they are not, nothing "
            "(iCub is built so)",
            "check left_foot and right_foot",
            "backward-base",
        )
    ]


def _balance(robot: Robot) -> list[Finding]:
    com = pin.centerOfMass(robot.model, robot.model.createData(), robot.q_nominal)
    reach = max(min(sole.half_length for sole in robot.soles), 0.01)
    width = 0.5 * np.linalg.norm(_sole_distance(robot))
    if robot.is_quadruped:
        reach = 0.5 * abs(float(_sole_distance(robot, 2)[0]))
    if abs(com[0]) < reach and abs(com[1]) < width:
        return []
    return [
        Finding(
            "error" if has_soles(robot.soles) else "warning",
            robot.name,
            f"the centre of mass is ({1e3 * com[0]:+.0f}, {1e3 * com[1]:+.0f}) mm from the soles' "
            "midpoint in the nominal posture, beyond the soles",
            "it falls over when it stands still",
            "state a nominal posture with the mass over the feet, or check the links' masses",
            "unbalanced-posture",
        )
    ]


def _sole_distance(robot: Robot, other: int = 1) -> np.ndarray:
    """Return the way to the first sole from another one, (3,) m."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.q_nominal)
    first, second = (data.oMf[robot.soles[k].frame_id].translation for k in (0, other))
    return np.asarray(first - second)


def _range(robot: Robot) -> list[Finding]:
    joints = robot.q_nominal[7:]
    over = np.maximum(robot.q_min - joints, joints - robot.q_max)
    return [
        Finding(
            "error",
            robot.joint_names[i],
            f"stands at {joints[i]:.3f} in the nominal posture, {over[i]:.3g} beyond its limit",
            "the controller's limits are violated from the start",
            "correct the posture or the limit",
            "posture-beyond-limit",
        )
        for i in np.flatnonzero(over > 1e-6)
    ]


def _legs(robot: Robot) -> list[Finding]:
    model, data = robot.model, robot.model.createData()
    pin.computeJointJacobians(model, data, robot.q_nominal)
    findings = []
    for sole, leg in zip(robot.soles, robot.legs, strict=True):
        J = pin.getFrameJacobian(model, data, sole.frame_id, pin.LOCAL_WORLD_ALIGNED)[:, list(leg)]
        # A point foot need not turn, so only the position counts.
        flat = not robot.is_quadruped and has_soles((sole,))
        J = J if flat else J[:3]
        rank = int((np.linalg.svd(J, compute_uv=False) > SINGULAR).sum())
        if (
            find_knee(model, robot.q_nominal, sole.joint_id, sole.placement.translation, leg)
            is None
        ):
            findings.append(
                Finding(
                    "warning",
                    sole.link,
                    f"no joint of its leg is a knee ({_joints(leg)} from base to foot)",
                    "the robot can stand but not walk or squat: the leg cannot get shorter",
                    "name the feet below the knees, left_foot=… and right_foot=…, or fix "
                    "fewer joints",
                    "no-knee",
                )
            )
        if rank < len(J):
            few = len(leg) < len(J)
            state = "is stretched or has parallel axes in the nominal posture"
            findings.append(
                Finding(
                    "warning",
                    sole.link,
                    f"its leg {f'has {_joints(leg)}' if few else state} and moves the foot in "
                    f"{rank} of {len(J)} directions",
                    "the foot cannot be placed freely; tasks on it conflict",
                    "give the leg the joints that it lacks"
                    if few
                    else "bend the knees in the nominal posture",
                    "rank-deficient-leg",
                )
            )
    if len({len(leg) for leg in robot.legs}) > 1:
        findings.append(
            Finding(
                "warning",
                robot.soles[1].link,
                f"its leg has {_joints(robot.legs[1])}, the other {len(robot.legs[0])}",
                "the legs are no pair; a foot may be the wrong link",
                "check left_foot and right_foot",
                "unlike-legs",
            )
        )
    return findings


def _joints(leg: Sequence[int]) -> str:
    return f"{len(leg)} joint{'s' if len(leg) > 1 else ''}"


def _mass(robot: Robot) -> list[Finding]:
    """A mass that does not fit the size of the robot."""
    density = robot.mass / robot.leg_length**3
    if DENSITY[0] < density < DENSITY[1]:
        return []
    much = density >= DENSITY[1]
    return [
        Finding(
            "warning",
            robot.name,
            f"weighs {robot.mass:.3g} kg on legs of {robot.leg_length:.3g} m, too "
            f"{'much' if much else 'little'} for its size",
            "torques, contact forces and effort limits do not fit it",
            "check the units: URDF has kg and m, CAD programs often g and mm",
            "implausible-mass",
        )
    ]


def _mass_matrix(robot: Robot) -> list[Finding]:
    M = pin.crba(robot.model, robot.model.createData(), robot.q_nominal)
    values = np.linalg.eigvalsh(M)
    if values[0] > 0.0 and values[-1] < ILL_CONDITIONED * values[0]:
        return []
    worst = int(np.argmin(np.diag(M)[6:]))
    return [
        Finding(
            "warning",
            robot.joint_names[worst],
            f"moves so little inertia that the mass matrix's eigenvalues range from "
            f"{values[0]:.2g} to {values[-1]:.2g}",
            "accelerations of such joints are inaccurate and physics needs small steps",
            "state armature (the motor's rotor inertia), or weld the joint with fixed_joints",
            "ill-conditioned-mass-matrix",
        )
    ]


def _strength(robot: Robot) -> list[Finding]:
    """Torques that hold the nominal posture, from the least contact wrenches that balance it."""
    tau = holding_torques(robot.model, robot.q_nominal, [s.frame_id for s in robot.soles])
    return [
        Finding(
            "warning",
            robot.joint_names[i],
            f"needs {abs(tau[i]):.3g} N·m to hold the nominal posture and has {robot.tau_max[i]:g}",
            "the robot cannot hold the posture",
            "check the effort limit, the masses and the posture",
            "too-weak",
        )
        for i in np.flatnonzero(np.abs(tau) > robot.tau_max)
    ]
