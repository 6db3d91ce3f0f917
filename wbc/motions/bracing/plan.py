"""The plan of a hand that presses against a wall: posture, touching point and largest force."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np
import pinocchio as pin

from wbc.errors import MotionError
from wbc.ik.objective import PostureObjective, PostureSolution
from wbc.ik.posture_ik import PostureIK
from wbc.motions.reaching.arm_paths import ArmPaths
from wbc.robot import Robot
from wbc.robot.collision_shapes import collision_shapes, shape_points
from wbc.robot.upper_body import Arm, UpperBody
from wbc.walking.hand_contacts import axes_about

_APPROACH = 0.05  # m before the surface, from where on the hand feels its way
_SPARE = 0.08  # m beyond the surface that the hand must be able to reach
_CLEAR = 0.35  # of the length of the other arm, by which its hand goes back
_HEIGHTS = (-0.3, -0.2, -0.1, 0.0)  # of the touching point above the shoulder, in arm lengths
_ASIDE = (0.0, 0.25)  # outward of the shoulder, in arm lengths
_TOLERANCE = 0.02  # m
_ROUNDS = 4  # of placing the touching point, which moves with the hand's orientation
_TORQUE_SHARE = 0.8  # of the limits that pressing may use
_FRICTION = 0.3  # coefficient up to which the force may be off the normal


@dataclass(frozen=True)
class BracePlan:
    """How a hand comes to press against a surface.

    Attributes:
        path: postures to go through, the last with the hand close to the surface.
        return_path: postures to go through on the way back.
        normal: (3,) of the surface, towards the robot, standing frame.
        point: (3,) of the hand that touches first, in the axes of the hand's frame, m.
        max_force: normal force that the arm's torques allow, N.
    """

    path: tuple[PostureSolution, ...]
    return_path: tuple[PostureSolution, ...]
    normal: np.ndarray
    point: np.ndarray
    max_force: float

    def __repr__(self) -> str:
        return f"BracePlan({len(self.path)} postures, at most {self.max_force:.0f} N)"


def plan_brace(robot: Robot, side: str, towards: float, distance: float) -> BracePlan:
    """Plan to press a hand against an upright wall where the arm is strongest.

    Args:
        robot: the robot.
        side: "left" or "right".
        towards: direction of the wall, rad: 0 forward, π/2 left.
        distance: of the wall from the middle of the soles, m.

    Raises:
        MotionError: the hand does not reach the wall, or the robot has no such arm.
    """
    ik, arm = PostureIK(robot), UpperBody.of(robot).arm(side)
    normal = -np.array([math.cos(towards), math.sin(towards), 0.0])
    shoulder = ik.frame_position(arm.shoulder)
    outward = np.array([0.0, 1.0 if side == "left" else -1.0, 0.0])
    outward -= (outward @ normal) * normal
    found: list[tuple[float, PostureSolution, np.ndarray]] = []
    nearest = math.inf
    for up, aside in product(_HEIGHTS, _ASIDE):
        place = shoulder + arm.length * (aside * outward + np.array([0.0, 0.0, up]))
        place += (-distance - place @ normal) * normal
        posture, point, error = _touching(ik, arm, place, normal)
        beyond = _shifted(ik, arm, posture, -_SPARE * normal)
        error += max(beyond.hand_error - _TOLERANCE, 0.0)
        nearest = min(nearest, error)
        if error <= _TOLERANCE:
            found.append((_max_force(robot, arm, posture.q, point, normal), posture, point))
    if not found:
        raise MotionError(
            f"the {side} hand of {robot.name} does not reach a wall {distance:g} m away "
            f"({100.0 * nearest:.0f} cm short)"
        )
    force, posture, point = max(found, key=lambda one: one[0])
    posture = _shifted(ik, arm, posture, _APPROACH * normal, keep_clear=True)
    paths = ArmPaths(ik)
    return BracePlan(
        paths.between(ik.standing, posture),
        paths.between(posture, ik.standing),
        normal,
        point,
        force,
    )


def _shifted(
    ik: PostureIK,
    arm: Arm,
    posture: PostureSolution,
    shift: np.ndarray,
    *,
    keep_clear: bool = False,
) -> PostureSolution:
    """Return the posture near another one whose hand is shifted, m.

    To keep clear of the wall, the other hand goes back from where it hangs.
    """
    hands = {arm.hand: ik.frame_position(arm.hand, posture.q) + shift}
    if keep_clear:
        away = _CLEAR * shift / np.linalg.norm(shift)
        for other in ik.upper_body.arms:
            if other.side != arm.side:
                hands[other.hand] = ik.frame_position(other.hand) + other.length * away
    objective = PostureObjective(hands=hands, strict_trunk=True, strict_com=True)
    return ik.solve(objective, posture.q, restarts=0)


def _touching(
    ik: PostureIK, arm: Arm, place: np.ndarray, normal: np.ndarray
) -> tuple[PostureSolution, np.ndarray, float]:
    """Return the posture with the hand's foremost point at a place, the point, and the error, m."""
    point, start = np.zeros(3), None
    frame_id = ik.robot.frame_id(arm.hand)
    model, data = ik.robot.model, ik.robot.model.createData()
    rotation = np.eye(3)
    for _ in range(_ROUNDS):
        objective = PostureObjective(
            hands={arm.hand: place - rotation @ point}, strict_trunk=True, strict_com=True
        )
        posture = ik.solve(objective, start, restarts=2 if start is None else 0)
        start = posture.q
        pin.framesForwardKinematics(model, data, posture.q)
        frame = data.oMf[frame_id]
        rotation = frame.rotation.copy()
        foremost = _foremost_point(ik.robot, data, frame_id, normal)
        point = frame.actInv(foremost)
    return posture, point, float(np.linalg.norm(foremost - place))


def _foremost_point(robot: Robot, data: pin.Data, frame_id: int, normal: np.ndarray) -> np.ndarray:
    """Return the point of hand and fingers that is farthest against a normal, world axes, m."""
    hand = robot.model.frames[frame_id].parentJoint
    best: np.ndarray = data.oMf[frame_id].translation.copy()
    for shape in collision_shapes(robot):
        if hand in robot.model.supports[shape.joint_id]:
            placed = data.oMi[shape.joint_id] * shape.placement
            points = shape_points(shape) @ placed.rotation.T + placed.translation
            foremost = points[np.argmin(points @ normal)]
            if foremost @ normal < best @ normal:
                best = foremost
    return best


def _max_force(
    robot: Robot, arm: Arm, q: np.ndarray, point: np.ndarray, normal: np.ndarray
) -> float:
    """Return the largest normal force that the arm bears, friction in any direction, N."""
    model, data = robot.model, robot.model.createData()
    pin.computeGeneralizedGravity(model, data, q)
    pin.computeJointJacobians(model, data, q)
    frame_id, joints = robot.frame_id(arm.hand), np.array(arm.joints)
    frame = pin.updateFramePlacement(model, data, frame_id)
    axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    J = pin.getFrameJacobian(model, data, frame_id, axes)
    J = J[:3] - pin.skew(frame.rotation @ point) @ J[3:]
    across = axes_about(normal)
    least = math.inf
    for a, b in product((-_FRICTION, _FRICTION), (-_FRICTION, _FRICTION)):
        torque = -(across @ [a, b, 1.0]) @ J[:, 6 + joints]
        gravity = data.g[6 + joints]
        room = _TORQUE_SHARE * robot.tau_max[joints] - np.sign(torque) * gravity
        least = min(least, float((np.maximum(room, 0.0) / np.maximum(np.abs(torque), 1e-6)).min()))
    return least
