"""Whether a robot can walk, and what holds it back: findings for the model doctor."""

from __future__ import annotations

import math

import numpy as np

from wbc.errors import GaitError
from wbc.gait.footsteps import Velocity
from wbc.gait.leg_workspace import LegWorkspace
from wbc.gait.parameters import GaitParameters
from wbc.gait.quadruped_gait import QuadrupedGait
from wbc.gait.step_motion import StepMotion
from wbc.gait.strength import support_effort
from wbc.robot import Finding, Robot

# Share of a torque limit above which stepping on the spot leaves too little to balance.
_STRAINED = 0.85
# A velocity limit below this times √(g h), or √(g / h) for turning, is worth a finding.
_SLOW = 0.02


def check_walking(robot: Robot) -> list[Finding]:
    """Return why a robot cannot walk, or what makes its walk slow or weak; none if all is well.

    Args:
        robot: the robot.
    """
    try:
        if robot.is_quadruped:
            QuadrupedGait.for_robot(robot)
            return []
        workspace = LegWorkspace(robot)
        gait = GaitParameters.for_robot(robot)
    except GaitError as error:
        what, _, cure = str(error).partition("; ")
        what = what.removeprefix(f"'{robot.name}' ")
        consequence = "a walker refuses the robot"
        return [Finding("warning", robot.name, what, consequence, cure, "cannot-walk")]
    motion = StepMotion(robot, workspace)
    return [*_strained(robot, motion, gait), *_slow(robot, motion, gait)]


def _strained(robot: Robot, motion: StepMotion, gait: GaitParameters) -> list[Finding]:
    effort = support_effort(robot, motion, gait)
    if effort.share <= _STRAINED:
        return []
    return [
        Finding(
            "warning",
            effort.joint,
            f"needs {effort.torque:.3g} N·m to carry the robot on one leg, "
            f"{100.0 * effort.share:.0f} % of its limit",
            "little is left to balance: slow walks and light pushes only",
            "check the effort limit and the masses",
            "weak-leg",
        )
    ]


def _slow(robot: Robot, motion: StepMotion, gait: GaitParameters) -> list[Finding]:
    limits = gait.max_velocity
    speed = math.sqrt(robot.gravity * robot.com_height)
    rate = math.sqrt(robot.gravity / robot.com_height)
    directions = (
        ("forward", limits.forward / speed, Velocity(forward=limits.forward), "m/s"),
        ("to the side", limits.left / speed, Velocity(left=limits.left), "m/s"),
        ("turning", limits.turn / rate, Velocity(turn=limits.turn), "rad/s"),
    )
    findings = []
    if not limits.turn:
        findings.append(
            Finding(
                "note",
                robot.name,
                "cannot turn: its feet are points, or its legs have no joint about the vertical",
                "turning is clamped to 0 rad/s, and the heading drifts",
                "none: it walks forward, backward and sideways",
                "cannot-turn",
            )
        )
    for name, share, velocity, unit in directions:
        if share < _SLOW and any((velocity.forward, velocity.left, velocity.turn)):
            # Twice as fast, something is beyond its limit.
            faster = Velocity(2.0 * velocity.forward, 2.0 * velocity.left, 2.0 * velocity.turn)
            most = velocity.forward + velocity.left + velocity.turn
            subject, why = _bottleneck(robot, motion, gait, faster)
            findings.append(
                Finding(
                    "warning",
                    subject,
                    f"{why}, so that the robot walks at most {most:.3f} {unit} {name}",
                    "greater velocities are clamped to that",
                    "check the limit, or state a posture farther from it",
                    "slow-walk",
                )
            )
    return findings


def _bottleneck(
    robot: Robot, motion: StepMotion, gait: GaitParameters, velocity: Velocity
) -> tuple[str, str]:
    """Return the joint that keeps the robot from a velocity, and why."""
    excess = motion.excess(gait, velocity)
    # What is beyond its limit already in place counts as within.
    excess = excess - np.maximum(motion.excess(gait, Velocity()), 0.0)
    joints = [robot.joint_names[index - 6] for leg in robot.legs for index in leg]
    worst = int(np.argmax(excess))
    if not np.isfinite(excess[worst]):
        return robot.soles[0].link, "its leg does not reach the footholds"
    if worst < len(joints):
        return joints[worst], "reaches its position limit"
    if worst < 2 * len(joints):
        return joints[worst - len(joints)], "reaches its velocity limit"
    return robot.soles[0].link, "its sole would turn on the ground under the swing leg's momentum"
