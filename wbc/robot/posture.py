"""The nominal posture: stated, from an SRDF, or derived from the legs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from wbc.robot.couplings import Coupling
from wbc.robot.data_file import RobotData
from wbc.robot.joint_axes import joint_axes
from wbc.robot.limits import velocity_index
from wbc.robot.soles import Sole
from wbc.robot.srdf import GroupState, find_srdf, group_state, read_group_state
from wbc.robot.standing import (
    feet_below_hips,
    on_points,
    posture_range,
    standing_posture,
    unevenness,
)
from wbc.robot.urdf import Urdf

KNEE_BEND = 0.4
_QUADRUPED_BEND = 1.2
_CENTERED = 0.01  # of the base's height: a quadruped's CoM is this near the middle of its feet
# A knee is looked for its straight position up to this, rad, at so many positions.
_FOLDED = 1.5
_SAMPLES = 61
# By this share of its length a leg is longer where its knee is straight than where it is at zero.
_STRETCH = 2e-3
# Joints of a leg that are nearer to zero than this, rad, leave it straight.
_STRAIGHT = 0.1
# A correction of the soles beyond this is reported, rad and m.
FLAT = 1e-4
# One beyond this is made.
EXACT = 1e-9
# A centre of mass farther out than this part of the sole's half length is brought back.
SUPPORTED = 0.6
# Joints parallel to a knee and nearer to it than this share of the leg bend with it.
_PARALLEL, _TOGETHER = 0.99, 0.2
# Thigh and shank are at least this share of the distance from hip to sole.
SEGMENT = 0.15
# Shares of the knees' bend that are tried, until the posture is sound.
_BENDS = (1.0, 0.5, 0.25, -1.0, -0.5, 0.0)
# Sum of what is wrong with a sound posture, m and rad.
_SOUND = 2e-3
# Share of the soles' half length by which the centre of mass may be off their midpoint.
_CENTRED = 0.25
# Feet farther apart than this share of the height of the centre of mass stand astride.
_ASTRIDE = 0.6
# Least distance of the soles' centres over the sum of their half widths.
_SIDE_BY_SIDE = 1.1
# A sole narrower than this half size is a point, m.
POINT = 0.01


@dataclass(frozen=True, slots=True)
class Posture:
    """A posture and how it was found.

    Attributes:
        q: (nq,) the configuration.
        how: description for reports; empty if no posture is stated anywhere.
        stated: whether the data file or the caller states it.
        source: file or argument that states it.
        stated_joints: velocity indices of the joints that are stated.
    """

    q: np.ndarray
    how: str
    stated: bool
    source: str
    stated_joints: frozenset[int] = frozenset()


def starting_posture(
    model: pin.Model, data: RobotData, urdf: Urdf, legs: Sequence[Sequence[int]] = ()
) -> Posture:
    """Return the posture of data file, SRDF or keyframe, or else the zero posture within limits.

    Keyframes with straight legs, which put a robot down rather than let it stand, tell the
    posture of the other joints.

    Raises:
        RobotDescriptionError: a malformed SRDF, or a stated joint that does not exist.
    """
    if data.nominal_posture:
        # Joints left out stay at zero, or at the limit nearest to it.
        q = pin.neutral(model)
        q[7:] = np.clip(q[7:], model.lowerPositionLimit[7:], model.upperPositionLimit[7:])
        source = data.source_of("nominal_posture")
        where = f"{source}: nominal_posture"
        stated = {velocity_index(model, n, where): x for n, x in data.nominal_posture.items()}
        q[np.array(list(stated)) + 1] = list(stated.values())
        return Posture(q, "stated joints", True, source, frozenset(stated))
    srdf = data.srdf or find_srdf(data.urdf)
    q = pin.neutral(model)
    if srdf is not None:
        reference = read_group_state(srdf, data.group_state)
    else:
        reference = group_state(urdf.path, urdf.element, {}, data.group_state)
    if reference is not None:
        _apply(model, q, reference)
        moved = [abs(q[index + 1]) > _STRAIGHT for leg in legs for index in leg]
        straight = srdf is None and legs and not any(moved)
        return Posture(q, "" if straight else f"'{reference.name}'", False, reference.source)
    return Posture(zero_posture(model), "", False, "")


def bent_quadruped(
    model: pin.Model,
    start: Posture,
    links: Sequence[str],
    legs: Sequence[Sequence[int]],
    couplings: Sequence[Coupling] = (),
) -> Posture:
    """Return a posture on four bent legs, each foot below its hip.

    Args:
        model: the robot.
        start: the joints to begin with.
        links: foot links.
        legs: velocity indices of the joints of each leg, from the hip down.
        couplings: joints that follow others.
    """
    feet = tuple(int(model.getFrameId(link, pin.BODY)) for link in links)
    bends, hips = {}, []
    for foot, leg in zip(feet, legs, strict=True):
        frame = model.frames[foot]
        knee = find_knee(model, start.q, frame.parentJoint, frame.placement.translation, leg)
        hips.append(next(j for j in range(2, model.njoints) if model.joints[j].idx_v == leg[0]))
        if knee is not None:
            bends[knee] = knee_bend(model, start.q, knee, leg, _QUADRUPED_BEND)
    move = {index for leg in legs for index in leg}
    q = feet_below_hips(model, start.q, feet, hips, move, bends, couplings)
    return Posture(q, "knees bent", False, "inverse kinematics")


def centered_quadruped(
    model: pin.Model,
    start: Posture,
    links: Sequence[str],
    legs: Sequence[Sequence[int]],
    couplings: Sequence[Coupling] = (),
) -> Posture:
    """Return the posture with level feet whose middle is below the centre of mass.

    The feet touch the ground where this posture puts them, so that it comes before their soles.

    Args:
        model: the robot.
        start: the posture to begin with.
        links: foot links.
        legs: velocity indices of the joints of each leg, from the hip down.
        couplings: joints that follow others.
    """
    feet = tuple(int(model.getFrameId(link, pin.BODY)) for link in links)
    move = {index for leg in legs for index in leg}
    q = standing_posture(model, start.q, feet, move, couplings, over_soles=True)
    return replace(start, q=q, how=f"{start.how}, centre of mass over the middle of the feet")


def zero_posture(model: pin.Model) -> np.ndarray:
    """Return every joint at zero, or as near to it as its range with a margin allows; (nq,)."""
    lower, upper = posture_range(model)
    q = pin.neutral(model)
    q[7:] = np.clip(q[7:], lower, upper)
    return np.asarray(q)


def stand_base_up(model: pin.Model, q: np.ndarray, feet: Sequence[int]) -> None:
    """Turn the base of `q` (nq,) so that its axis that points from the feet to the mass is up.

    Most robots have the base's z axis up; models from biomechanics have y.

    Args:
        model: the robot.
        q: (nq,) a posture, changed in place.
        feet: ids of the joints that move the feet.
    """
    data = model.createData()
    q[:7] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    com = pin.centerOfMass(model, data, q)
    rise = com - np.mean([data.oMi[foot].translation for foot in feet], axis=0)
    # z is the usual choice: a quadruped's two feet that are stated alone are not below its mass.
    axis = int(np.argmax(np.abs(rise) * [1.0, 1.0, 2.0]))
    up = np.sign(rise[axis]) * np.eye(3)[axis]
    turn = pin.Quaternion.FromTwoVectors(up, np.array([0.0, 0.0, 1.0]))
    q[3:7] = turn.coeffs()


def _apply(model: pin.Model, q: np.ndarray, reference: GroupState) -> None:
    # An SRDF serves several variants of a robot: joints that this one lacks are no mistake.
    for name, value in reference.joints.items():
        if model.existJointName(name) and model.getJointId(name) > 1:
            q[model.joints[model.getJointId(name)].idx_q] = value


def nominal_posture(
    model: pin.Model,
    start: Posture,
    soles: tuple[Sole, ...],
    legs: tuple[tuple[int, ...], ...],
    couplings: tuple[Coupling, ...] = (),
) -> Posture:
    """Return the nominal posture: soles flat on z = 0, their midpoint at the origin, facing x."""
    ids = tuple(sole.frame_id for sole in soles)
    move = {index for leg in legs for index in leg}
    if not start.how:
        q, bent = _bent(model, start.q, soles, legs, couplings)
        how = f"{bent}, other joints as stated" if start.source else bent
        return Posture(placed(model, q, ids), how, False, start.source or "inverse kinematics")
    if start.stated and not move & start.stated_joints:
        q, bent = _bent(model, start.q, soles, legs, couplings)
        return Posture(placed(model, q, ids), f"{start.how}, {bent}", True, start.source)
    q = placed(model, start.q, ids)
    completed = (
        _completed(model, q, ids, move - start.stated_joints, couplings) if start.stated else None
    )
    if completed is not None:
        how = f"{start.how}, the other leg joints such that the soles are flat"
        return Posture(completed, how, True, start.source)
    why = []
    tilt, height = unevenness(model, q, ids)
    if max(tilt, height) > FLAT:
        why.append(f"soles {np.rad2deg(tilt):.1f}° and {1e3 * height:.1f} mm off")
    if max(tilt, height) > EXACT:
        q = placed(model, standing_posture(model, q, ids, move, couplings), ids)
    ahead = abs(float(com_offset(model, q)[0]))
    # Four feet swing in pairs, about whose middle the robot would topple.
    allowed = SUPPORTED * min(sole.half_length for sole in soles)
    if on_points(soles):
        ahead, allowed = float(np.linalg.norm(com_offset(model, q))), _CENTERED * float(q[2])
    if ahead > allowed and (on_points(soles) or has_soles(soles)):
        why.append(f"centre of mass {1e3 * ahead:.0f} mm off")
        q = placed(model, standing_posture(model, q, ids, move, couplings, over_soles=True), ids)
    how = f"{start.how}, legs corrected ({', '.join(why)})" if why else start.how
    return Posture(q, how, start.stated, start.source)


def _completed(
    model: pin.Model,
    q: np.ndarray,
    soles: tuple[int, ...],
    free: set[int],
    couplings: tuple[Coupling, ...],
) -> np.ndarray | None:
    """Return `q` with the joints `free` (velocity indices) moved such that the soles are flat.

    None if the soles are flat already, or cannot be made flat without the other joints.
    """
    if max(unevenness(model, q, soles)) <= FLAT:
        return None
    for over_soles in (True, False):
        moved = standing_posture(
            model, q, soles, free, couplings, align=True, over_soles=over_soles
        )
        if max(unevenness(model, moved, soles)) <= EXACT:
            return placed(model, moved, soles)
    return None


def has_soles(soles: Sequence[Sole]) -> bool:
    """Return whether the feet have enough area to stand on, rather than points."""
    return all(min(sole.half_length, sole.half_width) > POINT for sole in soles)


def placed(model: pin.Model, q: np.ndarray, soles: Sequence[int]) -> np.ndarray:
    """Return `q` (nq,) moved and turned about z: soles' midpoint at the origin, heading x."""
    data = model.createData()
    q = np.array(q)
    pin.framesForwardKinematics(model, data, q)
    ahead = np.sum([data.oMf[sole].rotation[:, 0] for sole in soles], axis=0)
    turn = pin.rpy.rpyToMatrix(0.0, 0.0, -float(np.arctan2(ahead[1], ahead[0])))
    middle = np.mean([data.oMf[sole].translation for sole in soles], axis=0)
    q[:7] = pin.SE3ToXYZQUAT(pin.SE3(turn, -turn @ middle) * pin.XYZQUATToSE3(q[:7]))
    return q


def _bent(
    model: pin.Model,
    q: np.ndarray,
    soles: tuple[Sole, ...],
    legs: tuple[tuple[int, ...], ...],
    couplings: tuple[Coupling, ...],
) -> tuple[np.ndarray, str]:
    """Return a posture with bent knees, the feet side by side and the CoM over their midpoint.

    Returns:
        The posture (nq,) and a description.
    """
    ids = (soles[0].frame_id, soles[1].frame_id)
    q = placed(model, q, ids)
    move = {index for leg in legs for index in leg}
    knees = [
        find_knee(model, q, sole.joint_id, sole.placement.translation, leg)
        for sole, leg in zip(soles, legs, strict=True)
    ]
    bends = {
        joint: knee_bend(model, q, joint, leg)
        for knee, leg in zip(knees, legs, strict=True)
        if knee is not None
        for joint in (knee, *knee_companions(model, q, knee, leg))
    }
    most = max(len(bends) // len(legs), 1)  # joints that share the bend of a knee
    apart = _distance_apart(model, q, soles)
    best, least = q, np.inf
    # The likely bend first; the others for knees whose axis or range misleads.
    shares = _BENDS if bends else (1.0,)
    # Where the legs cannot do both, level soles come before a centred mass.
    for share, over_soles in (*((s, True) for s in shares), *((s, False) for s in shares)):
        found = standing_posture(
            model,
            q,
            ids,
            move,
            couplings,
            joints={knee: share / most * angle for knee, angle in bends.items()},
            align=True,
            over_soles=over_soles,
            apart=apart,
        )
        defect = _defect(model, found, soles)
        if defect < least:
            best, least = found, defect
        if least <= _SOUND:
            break
    return best, "knees bent" if bends else "legs without knees"


def _distance_apart(model: pin.Model, q: np.ndarray, soles: Sequence[Sole]) -> float | None:
    """Return how far apart the soles have to be if they are too near each other in q, m."""
    apart = float(abs(_between(model, q, soles)[1]))
    least = _SIDE_BY_SIDE * (soles[0].half_width + soles[1].half_width)
    return least if apart < least else None


def _defect(model: pin.Model, q: np.ndarray, soles: Sequence[Sole]) -> float:
    """Return how far a posture is from standing soundly: tilt, steps, spread and imbalance, m."""
    ids = (soles[0].frame_id, soles[1].frame_id)
    tilt, height = unevenness(model, q, ids)
    middle = placed(model, q, ids)
    com, apart = com_offset(model, middle), np.abs(_between(model, middle, soles)[:2])
    reach = float(pin.centerOfMass(model, model.createData(), middle)[2])
    astride = max(apart[1] - _ASTRIDE * abs(reach), 0.0)
    toppling = max(float(np.abs(com).max()) - _CENTRED * min(s.half_length for s in soles), 0.0)
    return float(tilt + height + apart[0] + astride + toppling)


def _between(model: pin.Model, q: np.ndarray, soles: Sequence[Sole]) -> np.ndarray:
    """Return the vector from the right to the left sole, (3,) m."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    left, right = (data.oMf[sole.frame_id].translation for sole in soles)
    return np.asarray(left - right)


def find_knee(
    model: pin.Model, q: np.ndarray, joint_id: int, foot: np.ndarray, leg: Sequence[int]
) -> int | None:
    """Return the velocity index of the knee: the lateral joint between two long segments.

    Args:
        model: the robot.
        q: (nq,) a posture.
        joint_id: id of the joint that moves the foot.
        foot: (3,) centre of the foot in that joint's coordinates, m.
        leg: velocity indices of the leg's joints, from the hip down.
    """
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    end = data.oMi[joint_id].act(foot)
    joints = [joint for joint in range(2, model.njoints) if model.joints[joint].idx_v in leg]
    hip = data.oMi[joints[0]].translation
    best, best_span = None, SEGMENT * float(np.linalg.norm(end - hip))
    for joint in joints:
        here = data.oMi[joint].translation
        span = min(float(np.linalg.norm(here - hip)), float(np.linalg.norm(here - end)))
        lateral = abs(float(data.J[4, model.joints[joint].idx_v]))  # the axis's y in the world
        if lateral > 0.7 and span > best_span:
            best, best_span = int(model.joints[joint].idx_v), span
    return best


def knee_companions(
    model: pin.Model, q: np.ndarray, knee: int, leg: Sequence[int]
) -> tuple[int, ...]:
    """Return the velocity indices of the joints that bend a leg together with its knee.

    The two axes of a rolling contact are such joints: parallel, and near each other.
    """
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    place = {model.joints[j].idx_v: data.oMi[j].translation for j in range(2, model.njoints)}
    length = float(np.linalg.norm(place[leg[0]] - place[leg[-1]]))
    return tuple(
        index
        for index in leg
        if index != knee
        and abs(float(data.J[3:, index] @ data.J[3:, knee])) > _PARALLEL
        and np.linalg.norm(place[index] - place[knee]) < _TOGETHER * length
    )


def knee_bend(
    model: pin.Model, q: np.ndarray, knee: int, leg: Sequence[int], bend: float = KNEE_BEND
) -> float:
    """Return the position of the knee bent from straight, rad.

    Args:
        model: the robot.
        q: (nq,) a posture.
        knee: velocity index of the knee.
        leg: velocity indices of its leg's joints, from the hip down.
        bend: rad from straight.
    """
    lower, upper = posture_range(model)
    low, high = float(lower[knee - 6]), float(upper[knee - 6])
    straight = straight_knee(model, q, knee, leg)
    if np.isfinite(low + high) and abs(low + high - 2.0 * straight) > 0.2 * (high - low):
        sign = float(np.sign(low + high - 2.0 * straight))
    else:
        data = model.createData()
        pin.computeJointJacobians(model, data, q)
        # A knee flexes by turning the shank backwards, about the lateral axis.
        sign = float(np.sign(data.J[4, knee]))
    return float(np.clip(straight + sign * bend, low, high))


def straight_knee(model: pin.Model, q: np.ndarray, knee: int, leg: Sequence[int]) -> float:
    """Return the position within its range at which a knee brings the ankle farthest, rad.

    Zero if that is nearly as far: most descriptions have their legs straight there.
    """
    joints = [joint for joint in range(2, model.njoints) if model.joints[joint].idx_v in leg]
    hip, ankle = joints[0], joints[-1]
    low = max(float(model.lowerPositionLimit[knee + 1]), -_FOLDED)
    high = min(float(model.upperPositionLimit[knee + 1]), _FOLDED)
    if model.joints[ankle].idx_v == knee or not low < high:
        return 0.0
    data, trial, center = model.createData(), q.copy(), ankle_center(model, ankle)

    def length(angle: float) -> float:
        trial[knee + 1] = angle
        pin.forwardKinematics(model, data, trial)
        return float(np.linalg.norm(data.oMi[hip].translation - data.oMi[ankle].act(center)))

    angles = np.linspace(low, high, _SAMPLES)
    straight = float(angles[int(np.argmax([length(angle) for angle in angles]))])
    zero = min(max(0.0, low), high)
    return straight if length(straight) - length(zero) > _STRETCH * length(straight) else zero


def ankle_center(model: pin.Model, joint: int) -> np.ndarray:
    """Return the point on an ankle's last axis that is nearest to the axis before it.

    The origins of joints may be anywhere along their axes.

    Args:
        model: the robot.
        joint: id of the last joint of a leg.

    Returns:
        (3,) in the joint's coordinates, m.
    """
    before = model.jointPlacements[joint].inverse().translation
    axis = joint_axes(model)[joint][3:]
    return np.asarray((axis @ before) * axis)


def com_offset(model: pin.Model, q: np.ndarray) -> np.ndarray:
    """Return the CoM from the soles' midpoint in a placed posture `q` (nq,); (2,) m."""
    return np.array(pin.centerOfMass(model, model.createData(), q)[:2])
