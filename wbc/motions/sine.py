"""Sine: fifteen joints on sines of time, the first pattern of many tutorials."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pinocchio as pin

from wbc.command import Command
from wbc.errors import MotionError
from wbc.estimation import Estimate
from wbc.gait.leg_workspace import LegWorkspace
from wbc.motions.engine import (
    Motion,
    MotionContext,
    Path,
    Script,
    SmoothReference,
    check_positive,
    once_per_robot,
    parameter,
)
from wbc.robot import Robot
from wbc.robot.upper_body import UpperBody
from wbc.telemetry import ContactPlan, Telemetry

_LEAD_IN = 1.0  # s from standing to the pattern; likewise back, and at rest there
_STIFFNESS = 20.0  # torque limits per rad
_DAMPING = 0.6  # torque limits per rad/s
_ACCELERATION = 10.0  # rad/s², on the way back
_FADE = 0.3  # s in which the torques of standing decay
_ROUNDING = 0.05
_ALONG = 0.6  # cosine from which on a joint turns about an axis
_X, _Y, _Z = 0, 1, 2

#: Name in the pattern -> index into (na,) and sign.
Joints = dict[str, tuple[int, float]]


def pattern(time: float, rounding: float = 0.0) -> dict[str, float]:
    """Return the joint positions of the pattern at a time, rad.

    The legs swing in opposite phase at 1 rad/s, the knees bend only forward, the trunk turns
    at twice the rate, the arms swing against the legs.

    Args:
        time: s.
        rounding: ε of max(0, x) ≈ (x + √(x² + ε²)) / 2, which makes the knees' accelerations
            finite.
    """

    def bend(phase: float) -> float:
        return 0.25 * (phase + math.hypot(phase, rounding))

    right, left = math.sin(time), math.sin(time + math.pi)
    return {
        "torso_yaw": 0.1 * math.sin(2.0 * time),
        "right_hip_pitch": 0.3 * right,
        "right_hip_roll": 0.1 * right,
        "right_knee": bend(right),
        "right_ankle_pitch": -0.3 * right,
        "right_ankle_roll": 0.0,
        "left_hip_pitch": 0.3 * left,
        "left_hip_roll": 0.1 * left,
        "left_knee": bend(left),
        "left_ankle_pitch": -0.3 * left,
        "left_ankle_roll": 0.0,
        "right_shoulder_pitch": -0.2 * right,
        "right_elbow": 0.1,
        "left_shoulder_pitch": -0.2 * left,
        "left_elbow": 0.1,
    }


@dataclass(frozen=True)
class Sine(Motion):
    """Track the pattern as joint positions: as a posture with balance, or open loop.

    The walker's controller keeps CoM, trunk and feet, and the joints follow as far as that allows.
    Open loop, a PD controller at the joints tracks the pattern, and nothing balances: most robots
    fall, and the report says when.
    """

    name: ClassVar[str] = "sine"
    summary: ClassVar[str] = "move fifteen joints along sines of time, balanced or open loop"

    open_loop: bool = parameter(False, "whether nothing keeps the balance: most robots fall")
    seconds: float = parameter(4.0 * math.pi, "duration of the pattern, s; its period is 6.28 s")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "seconds")
        self._joints(robot)

    @once_per_robot
    def _joints(self, robot: Robot) -> tuple[Joints, tuple[str, ...]]:
        return match_joints(robot)

    @classmethod
    def for_demo(cls) -> Motion:
        """See `Motion.for_demo`."""
        return cls(seconds=2.0 * math.pi)

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        joints, missing = self._joints(context.robot)
        if missing:
            context.note(f"{context.robot.name} has no joint for {', '.join(missing)}: left out")
        home = context.posture.home

        def posture(time: float) -> np.ndarray:
            q = home.copy()
            for name, value in pattern(time, 0.0 if self.open_loop else _ROUNDING).items():
                if name in joints:
                    index, sign = joints[name]
                    q[index] = sign * value
            return q

        if self.open_loop:
            yield from self._track(context, posture)
        else:
            yield from self._balance(context, posture)

    def _balance(self, context: MotionContext, posture: Path) -> Script:
        context.posture.move_to(posture(0.0), _LEAD_IN)
        yield from context.until_arrived(context.posture)
        context.posture.follow(posture)
        yield from context.wait(self.seconds)
        yield from context.go_home(1.0)

    def _track(self, context: MotionContext, posture: Path) -> Script:
        context.start_override(JointPdController(context, posture))
        yield from context.wait(_LEAD_IN + self.seconds)
        yield from context.release_override()
        yield from context.go_home(1.5)


class JointPdController:
    """PD control of the joints, without balance; a `ControllerOverride`.

    Args:
        context: context of the robot, whose joints start from where they are.
        posture: time, s -> (na,) rad; after a lead-in of 1 s it is followed exactly.
    """

    dcm_error = math.nan  #: no DCM is planned

    def __init__(self, context: MotionContext, posture: Path) -> None:
        robot = self._robot = context.robot
        self._dt = context.dt
        self._home = context.posture.home
        self._reference = SmoothReference(
            context.posture.value, speed=robot.v_max, acceleration=_ACCELERATION
        )
        self._reference.follow(lambda time: posture(time - _LEAD_IN), blend=_LEAD_IN)
        self._rest: float | None = None
        self._kp = _STIFFNESS * robot.tau_max
        self._kd = _DAMPING * robot.tau_max
        self._before = context.last_torque
        self._fading: np.ndarray | None = None  # what the torques of standing had more

    def step(self, estimate: Estimate) -> Command:
        """Compute the command of one tick."""
        reference, state = self._reference, estimate.state
        reference.advance(self._dt)
        q, v = reference.value, reference.velocity
        tau = self._kp * (q - state.q[7:]) + self._kd * (v - state.v[6:])
        if self._fading is None:
            self._fading = np.zeros(tau.size) if self._before is None else self._before - tau
        tau = tau + self._fading
        self._fading = self._fading * (1.0 - self._dt / _FADE)
        if self._rest is not None and reference.arrived:
            self._rest += self._dt
        tau = np.clip(tau, -self._robot.tau_max, self._robot.tau_max)
        return Command(tau, np.zeros(self._robot.nv), {}, q, v)

    def abandon(self) -> None:
        """Return to the posture of standing."""
        if self._rest is None:
            self._rest = 0.0
            self._reference.move_to(self._home, _LEAD_IN)

    @property
    def done(self) -> bool:
        """Whether the joints are back, and at rest."""
        return self._rest is not None and self._rest >= _LEAD_IN

    @property
    def telemetry(self) -> Telemetry:
        """Unknown: this controller does not balance."""
        return Telemetry()

    @property
    def contact_plan(self) -> ContactPlan:
        """Empty: nothing is planned."""
        return ContactPlan()


def match_joints(robot: Robot) -> tuple[Joints, tuple[str, ...]]:
    """Return the robot's joints for the pattern: name -> (index into (na,), sign); missing names.

    A joint of that very name counts; else the one that does the same: the waist's that turns
    about the vertical, a leg's before, at and after the knee, an arm's before and at the elbow.
    Positive is then a turn about the forward, left or upward axis, for an elbow towards flexion.

    Raises:
        MotionError: not even the legs are like that.
    """
    found: dict[str, tuple[int, float]] = {}
    data = robot.model.createData()
    pin.computeJointJacobians(robot.model, data, robot.q_nominal)
    axes = np.array(data.J[3:, 6:])
    upper_body = UpperBody.of(robot)

    def about(axis: int, joints: tuple[int, ...]) -> tuple[int, float] | None:
        best = max(joints, key=lambda j: abs(axes[axis, j]), default=-1)
        if best < 0 or abs(axes[axis, best]) < _ALONG:
            return None
        return best, float(np.sign(axes[axis, best]))

    roles: dict[str, tuple[int, float] | None] = {"torso_yaw": about(_Z, upper_body.waist)}
    for side, leg, knee in zip(
        ("left", "right"), robot.legs, LegWorkspace(robot).knees, strict=True
    ):
        joints = tuple(j - 6 for j in leg)
        hip, ankle = joints[: joints.index(knee)], joints[joints.index(knee) + 1 :]
        roles |= {
            f"{side}_hip_pitch": about(_Y, hip),
            f"{side}_hip_roll": about(_X, hip),
            f"{side}_knee": about(_Y, (knee,)),
            f"{side}_ankle_pitch": about(_Y, ankle),
            f"{side}_ankle_roll": about(_X, ankle),
        }
    for arm in upper_body.arms:
        elbow = upper_body.elbow(arm)
        before = arm.joints[: arm.joints.index(elbow)]
        roles[f"{arm.side}_shoulder_pitch"] = about(_Y, before)
        middle = robot.q_min[elbow] + robot.q_max[elbow]
        roles[f"{arm.side}_elbow"] = (elbow, float(np.sign(middle)) or 1.0)
    for name in pattern(0.0):
        if name in robot.joint_names:
            found[name] = (robot.joint_names.index(name), 1.0)
        elif (role := roles.get(name)) is not None:
            found[name] = role
    missing = tuple(name for name in pattern(0.0) if name not in found)
    legs = [name for name in missing if "hip" in name or "knee" in name or "ankle" in name]
    if legs:
        raise MotionError(
            f"sine: {robot.name} has no joint that could be {', '.join(legs)}; its joints: "
            f"{', '.join(robot.joint_names)}"
        )
    return found, missing
