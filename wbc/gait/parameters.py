"""Gait parameters: timing, geometry and feedback gain."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pinocchio as pin

from wbc.errors import GaitError
from wbc.gait.leg_workspace import TRAIL, LegWorkspace
from wbc.gait.step_motion import StepMotion
from wbc.gait.strength import check_knees, check_support, foot_acceleration
from wbc.gait.velocity_limits import VelocityLimits
from wbc.gait.velocity_search import find_velocity_limits
from wbc.geometry.quintic import PEAK_ACCELERATION
from wbc.kinematics import Kinematics
from wbc.robot import Robot
from wbc.robot.computed_once import computed_once
from wbc.robot.posture import has_soles

_GRAVITY = float(-pin.Model.gravity981[2])  # m/s², that of every Pinocchio model
_NO_LIMITS = VelocityLimits()
_DCM_GAIN = 4.0  # 1/s
_LARGE = 0.45  # m: with the centre of mass below this, the feedback is as much quicker as the robot
# Share of the widest step and of the largest turn that steady walking uses. What is left is for
# step adjustment: at the very limit it only takes way off, and the robot is slower than told.
_STEADY = 0.92
_CHANGE = 1.85  # largest change of the velocity in a step over the speed of the longest usual one
_CLEARANCE = 0.02  # m between the soles at the narrowest step
# Durations of swing, transfer and first transfer times ω. Points have no area on which the weight
# could be moved slowly, so that their steps are quick.
_DURATIONS = 2.0, 0.8, 2.0
_POINT_DURATIONS = 1.15, 0.17, 0.17
_UPRIGHT = 0.3  # least vertical part of the axis of a joint that turns the foot
# Durations of the recovery gait times ω.
_RECOVERY_SWING = 0.77
_RECOVERY_TRANSFER = 0.025
_RECOVERY_FIRST_TRANSFER = 0.155
_RECOVERY_WAY = 0.45  # share of the CoM's height that a foot gets to in it, from rest to rest
_RECOVERY_STEP = 0.85  # longest step over the height of the CoM
_RECOVERY_WIDENING = 0.65  # largest, over the length of the legs


@dataclass(frozen=True)
class GaitParameters:
    """Timing, geometry and feedback of the gait. SI units.

    Attributes:
        single_support: duration of a swing, s.
        double_support: duration of the weight transfer between steps, s.
        first_transfer: duration of the weight transfer out of standing, s.
        swing_height: apex of the swing sole above the higher of its ends, m.
        touchdown_speed: downward speed at and after the planned touchdown, m/s.
        step_width: lateral distance of the soles' centres, m.
        least_width: the same, the smallest that is safe for the feet, m.
        max_step: longest forward step, m.
        max_side_step: widest change of the lateral distance, m.
        max_turn: largest heading change of a step, rad.
        com_height: height of the CoM above the soles while walking, m.
        dcm_gain: k of the DCM feedback, 1/s.
        gravity: gravitational acceleration, m/s².
        trail: share of a step that the rear foot is behind the hip when it leaves the ground.
        velocity_change: by how much the forward velocity may change within a step, m/s.
        velocity_limits: velocities that the leg joints allow, whatever the steps' reach.
    """

    single_support: float
    double_support: float
    first_transfer: float
    swing_height: float
    touchdown_speed: float
    step_width: float
    least_width: float
    max_step: float
    max_side_step: float
    max_turn: float
    com_height: float
    dcm_gain: float = _DCM_GAIN
    gravity: float = _GRAVITY
    trail: float = TRAIL
    velocity_change: float = math.inf
    velocity_limits: VelocityLimits = _NO_LIMITS

    def __post_init__(self) -> None:
        for field in self.__dataclass_fields__:
            value = getattr(self, field)
            if isinstance(value, VelocityLimits):
                continue
            if not (value > 0.0 and (math.isfinite(value) or field == "velocity_change")):
                raise GaitError(f"gait parameter {field} = {value} must be a positive number")
        if self.least_width > self.step_width:
            raise GaitError(f"least_width {self.least_width} exceeds step_width {self.step_width}")

    @cached_property
    def omega(self) -> float:
        """Natural frequency √(g / com_height), 1/s."""
        return math.sqrt(self.gravity / self.com_height)

    @cached_property
    def greatest_width(self) -> float:
        """Lateral distance of the soles' centres in the widest step, m."""
        return self.step_width + self.max_side_step

    @cached_property
    def step_duration(self) -> float:
        """Single plus double support, s."""
        return self.single_support + self.double_support

    @cached_property
    def max_velocity(self) -> VelocityLimits:
        """The velocities that the reach of the steps and the leg joints allow."""
        T = self.step_duration
        # Sideways and turning, only every other step makes way.
        steps = VelocityLimits(
            self.max_step / T,
            self.max_step / T,
            _STEADY * self.max_side_step / (2.0 * T),
            _STEADY * self.max_turn / (2.0 * T),
        )
        found = self.velocity_limits
        limits = steps.within(found)
        # Forward, quicker steps than those of the usual speeds count too.
        return replace(limits, forward=found.forward) if math.isfinite(found.forward) else limits

    @staticmethod
    @computed_once
    def for_robot(robot: Robot) -> GaitParameters:
        """Parameters scaled to a robot by its leg length and natural frequency.

        Durations scale with √(height / g), lengths with the leg (dynamic similarity,
        Alexander, Principles of Animal Locomotion, 2003). Computed once per robot.

        Args:
            robot: the robot.

        Raises:
            GaitError: the robot cannot walk: a leg has no knee, or a joint is too weak to carry the
                robot on one leg. The text names the joint and the bound.
        """
        left, right = robot.soles
        kin = Kinematics(robot, robot.standing())
        T_left_right = kin.frame(left.name).inverse() * kin.frame(right.name)
        width = float(abs(T_left_right.translation[1]))
        foot_width = left.half_width + right.half_width
        height = robot.com_height
        natural = math.sqrt(height / robot.gravity)
        leg = robot.leg_length
        reach = LegWorkspace(robot)
        check_knees(robot, reach)
        durations = _DURATIONS if has_soles(robot.soles) else _POINT_DURATIONS
        swing, transfer, first = (natural * duration for duration in durations)
        gait = GaitParameters(
            single_support=swing,
            double_support=transfer,
            first_transfer=first,
            swing_height=0.07 * leg,
            touchdown_speed=0.05,
            step_width=max(width, foot_width + _CLEARANCE),
            least_width=max(foot_width + _CLEARANCE, 0.75 * width),
            max_step=min(0.51 * height, reach.max_step),
            max_side_step=min(0.35 * leg, reach.max_spread),
            max_turn=0.55,
            com_height=height,
            dcm_gain=_DCM_GAIN * max(math.sqrt(_LARGE / height), 1.0),
            gravity=robot.gravity,
        )
        motion = StepMotion(robot, reach)
        check_support(robot, motion, gait)
        limits = find_velocity_limits(motion, gait, reach)
        if not can_turn(robot):
            limits = replace(limits, turn=0.0)
        share = _joints_share(robot)
        return replace(
            gait,
            velocity_limits=limits.scaled(share),
            velocity_change=share * (_CHANGE * (gait.max_step / gait.step_duration)),
        )

    @classmethod
    def for_recovery(cls, robot: Robot, gait: GaitParameters) -> GaitParameters:
        """Parameters of the steps that catch a push: quick ones, as long and wide as the legs can.

        A DCM error grows by `e^(ωT)` until touchdown, so that time is worth more than place: a
        swing of 0.77/ω doubles it, one of the usual 2/ω multiplies it by seven (N-step
        capturability, Koolen et al., IJRR 2012). Hips that are too weak to move a foot over 0.45 of
        the height of the centre of mass in that time have longer swings. The weight is transferred
        at once: it belongs at the next foot's edge. The feet may come as near to each other as they
        do without touching, as far apart as 0.65 of the legs' length more than usual, and as far
        ahead as 0.85 of the height of the centre of mass: a step that is not to be repeated may be
        longer than the knees could carry the robot on.

        Args:
            robot: the robot.
            gait: its gait when nobody pushes.
        """
        left, right = robot.soles
        foot_width = left.half_width + right.half_width
        way = _RECOVERY_WAY * robot.com_height
        swing = max(
            _RECOVERY_SWING / gait.omega,
            math.sqrt(PEAK_ACCELERATION * way / foot_acceleration(robot)),
        )
        return replace(
            gait,
            single_support=min(swing, gait.single_support),
            double_support=min(_RECOVERY_TRANSFER / gait.omega, gait.double_support),
            first_transfer=min(_RECOVERY_FIRST_TRANSFER / gait.omega, gait.first_transfer),
            least_width=min(foot_width + _CLEARANCE, gait.least_width),
            max_step=max(_RECOVERY_STEP * robot.com_height, gait.max_step),
            max_side_step=max(_RECOVERY_WIDENING * robot.leg_length, gait.max_side_step),
        )


def can_turn(robot: Robot) -> bool:
    """Return whether both legs can turn the robot about the vertical on the foot that stands.

    A point pivots on the ground instead, and a sole needs a leg with a joint that turns it.
    """
    if not has_soles(robot.soles):
        return False
    data = robot.model.createData()
    pin.computeJointJacobians(robot.model, data, robot.q_nominal)
    return all(np.abs(data.J[5, list(leg)]).max() > _UPRIGHT for leg in robot.legs)


def _joints_share(robot: Robot) -> float:
    """Return the share of the velocities that a robot keeps whose legs lack joints.

    Without an ankle's roll the whole trunk leans to move the centre of mass sideways, and without
    a hip's yaw the trunk turns with the swing leg: each joint that a leg lacks halves the
    velocities. A point foot need not be turned, so that three joints are enough for it.
    """
    needed = 6 if has_soles(robot.soles) else 3
    lacking = max(needed - min(len(leg) for leg in robot.legs), 0)
    return 0.5**lacking
