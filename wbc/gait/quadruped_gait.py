"""Gait of a quadruped: which feet swing together, for how long and how high."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from wbc.errors import GaitError
from wbc.gait.velocity_limits import VelocityLimits
from wbc.robot import Robot
from wbc.robot.statics import holding_torques

#: Feet that swing together, in their order: diagonal ones, those of a side, one at a time.
TROT = (("front_left", "hind_right"), ("front_right", "hind_left"))
PACE = (("front_left", "hind_left"), ("front_right", "hind_right"))
WALK = (("hind_left",), ("front_left",), ("hind_right",), ("front_right",))

# Durations of swing and transfer times ω. Two points have no area on which the weight could be
# moved, so that the steps are quick.
_SWING, _TRANSFER = 1.15, 0.17
_SWING_HEIGHT = 0.15  # over the height of the centre of mass
_STRETCH = 0.97  # share of a leg's length that a step uses
_STEADY = 0.6  # share of the reach that steady walking uses; the rest catches pushes
_FOOT_SPEED = 1.6  # a swing foot's largest speed over the ground over that of the robot
# Largest speed over √(g h): beyond it the momentum of the swinging legs tips the trunk about the
# line between the two feet that stand. Six of seven public quadrupeds trot at it for 5 s.
_FROUDE = 0.2
_DCM_GAIN = 6.0  # 1/s
_LEG_JOINTS = 3


@dataclass(frozen=True)
class QuadrupedGait:
    """Timing and geometry of a quadruped's gait. SI units.

    Attributes:
        groups: sides of the feet that swing together; the groups swing one after the other.
        swing_duration: duration of a swing, s.
        transfer_duration: time on all feet between two swings, s.
        swing_height: apex of the swing foot above the higher of its ends, m.
        touchdown_speed: downward speed at and after the planned touchdown, m/s.
        max_step: largest distance of a foothold from the point below its hip, m.
        com_height: height of the centre of mass above the feet, m.
        dcm_gain: k of the DCM feedback, 1/s.
        gravity: gravitational acceleration, m/s².
        max_velocity: velocities that reach, joints and momentum of the legs allow.

    Raises:
        GaitError: a number that is not positive, or a group without a foot or with all feet.
    """

    swing_duration: float
    transfer_duration: float
    swing_height: float
    touchdown_speed: float
    max_step: float
    com_height: float
    max_velocity: VelocityLimits
    groups: tuple[tuple[str, ...], ...] = TROT
    dcm_gain: float = _DCM_GAIN
    gravity: float = 9.81

    def __post_init__(self) -> None:
        for name in (
            "swing_duration",
            "transfer_duration",
            "swing_height",
            "touchdown_speed",
            "max_step",
            "com_height",
            "dcm_gain",
            "gravity",
        ):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise GaitError(f"gait parameter {name} = {value} must be a positive number")
        feet = [foot for group in self.groups for foot in group]
        if len(set(feet)) < len(feet) or len(self.groups) < 2 or not all(self.groups):
            raise GaitError(
                f"groups = {self.groups}: a gait needs two groups of feet or more, and each foot "
                "once"
            )

    @cached_property
    def omega(self) -> float:
        """Natural frequency √(g / com_height), 1/s."""
        return math.sqrt(self.gravity / self.com_height)

    @cached_property
    def step_duration(self) -> float:
        """Swing plus transfer, s."""
        return self.swing_duration + self.transfer_duration

    @cached_property
    def cycle(self) -> float:
        """Duration until the same feet swing again, s."""
        return len(self.groups) * self.step_duration

    @classmethod
    def for_robot(cls, robot: Robot, groups: tuple[tuple[str, ...], ...] = TROT) -> QuadrupedGait:
        """Return a gait scaled to a robot by its legs and its natural frequency.

        Durations scale with √(height / g), lengths with the legs (dynamic similarity,
        Alexander, Principles of Animal Locomotion, 2003).

        Args:
            robot: the robot.
            groups: sides of the feet that swing together.

        Raises:
            GaitError: the robot does not have the feet of the groups, a leg cannot place its foot,
                is stretched, or is too weak to carry the robot; the text names the bound.
        """
        sides = sorted(sole.side for sole in robot.soles)
        if sorted(foot for group in groups for foot in group) != sides:
            raise GaitError(
                f"the groups {groups} are not those of '{robot.name}', whose feet are "
                f"{', '.join(sides)}; a robot on two legs walks with wbc.Walker"
            )
        _check_legs(robot, groups)
        height = robot.com_height
        natural = math.sqrt(height / robot.gravity)
        reach = _reach(robot)
        swing, transfer = _SWING * natural, _TRANSFER * natural
        sweep = (len(groups) - 1) * (swing + transfer) + transfer  # a foot is on the ground
        speed = min(
            2.0 * _STEADY * reach / sweep,
            _joint_speed(robot, swing, sweep),
            _FROUDE * height / natural,
        )
        radius = max(abs(foot) for foot in foot_places(robot).values())
        return cls(
            swing_duration=swing,
            transfer_duration=transfer,
            swing_height=_SWING_HEIGHT * height,
            touchdown_speed=_SWING_HEIGHT * height / swing * 0.3,
            max_step=reach,
            com_height=height,
            max_velocity=VelocityLimits(speed, speed, 0.5 * speed, 0.7 * speed / radius),
            groups=groups,
            gravity=robot.gravity,
        )


def foot_places(robot: Robot) -> dict[str, complex]:
    """Return side -> ground point of the foot in the nominal posture, from the feet's mean, m."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.q_nominal)
    places: dict[str, complex] = {}
    for sole in robot.soles:
        x, y, _ = data.oMf[sole.frame_id].translation.tolist()
        places[sole.side] = complex(x, y)
    return places


def _check_legs(robot: Robot, groups: tuple[tuple[str, ...], ...]) -> None:
    """Check that each leg places its foot in all directions, and that the legs bear the weight.

    Raises:
        GaitError: they do not.
    """
    for sole, leg in zip(robot.soles, robot.legs, strict=True):
        if len(leg) < _LEG_JOINTS:
            raise GaitError(
                f"'{robot.name}' cannot walk: its leg to the foot '{sole.link}' has {len(leg)} "
                f"joints, and to place a foot in all directions takes {_LEG_JOINTS}; weld fewer "
                "joints (fixed_joints), or name a link farther down (feet)"
            )
    for group in groups:
        standing = [sole.frame_id for sole in robot.soles if sole.side not in group]
        torques = np.abs(holding_torques(robot.model, robot.q_nominal, standing))
        worst = int(np.argmax(torques / robot.tau_max))
        if torques[worst] > robot.tau_max[worst]:
            raise GaitError(
                f"'{robot.name}' cannot walk: its joint '{robot.joint_names[worst]}' has "
                f"{robot.tau_max[worst]:.3g} N·m, and to carry {robot.mass:.3g} kg while "
                f"{' and '.join(group).replace('_', ' ')} swing takes {torques[worst]:.3g} N·m; "
                "correct the effort limit or the masses, or state a posture with straighter knees"
            )


def _reach(robot: Robot) -> float:
    """Return how far from below the hip every foot reaches in the nominal height, m.

    Raises:
        GaitError: a leg is stretched already.
    """
    model, data = robot.model, robot.model.createData()
    pin.framesForwardKinematics(model, data, robot.q_nominal)
    reach = math.inf
    for sole, leg in zip(robot.soles, robot.legs, strict=True):
        joints = [j for j in range(1, model.njoints) if model.joints[j].idx_v in leg]
        length = sum(
            float(np.linalg.norm(model.jointPlacements[j].translation[[0, 2]])) for j in joints[2:]
        )
        length += float(np.linalg.norm(sole.placement.translation))
        # The second joint of the hip swings the leg; the first one moves it sideways.
        hip = data.oMi[joints[min(1, len(joints) - 1)]].translation
        height = float(hip[2])
        reach = min(reach, math.sqrt(max((_STRETCH * length) ** 2 - height**2, 0.0)))
    if reach <= 0.0:
        raise GaitError(
            f"'{robot.name}' cannot walk: its legs are stretched in the nominal posture; state one "
            "with bent knees (nominal_posture)"
        )
    return reach


def _joint_speed(robot: Robot, swing: float, sweep: float) -> float:
    """Return the speed over the ground at which a swing foot needs all of a joint's velocity, m/s.

    A foot that is on the ground for a time catches up with the robot during its swing.
    """
    model, data = robot.model, robot.model.createData()
    pin.computeJointJacobians(model, data, robot.q_nominal)
    slowest = math.inf
    for sole, leg in zip(robot.soles, robot.legs, strict=True):
        J = pin.getFrameJacobian(model, data, sole.frame_id, pin.LOCAL_WORLD_ALIGNED)
        rates = np.linalg.pinv(J[:3, list(leg)])[:, 0]
        limits = robot.v_max[np.array(leg) - 6]
        with np.errstate(divide="ignore"):
            slowest = min(slowest, float(np.min(limits / np.abs(rates))))
    return slowest / (_FOOT_SPEED * (1.0 + sweep / swing))
