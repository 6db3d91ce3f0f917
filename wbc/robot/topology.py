"""Queries of the kinematic tree: the joints of a leg, the torso, links and joints."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pinocchio as pin

from wbc.robot.urdf import Urdf

_LEG_JOINTS = 3  # a leg has at least so many
# Shares of the height: of what is mirrored, and of what is clearly lower.
_MIRRORED, _APART = 0.02, 0.1


def leg_joints(model: pin.Model, foot_joints: tuple[int, ...]) -> tuple[tuple[int, ...], ...]:
    """Return the velocity indices (into nv) of the joints of each leg, from the hip down.

    A joint that moves several feet, such as a waist below the base, belongs to no leg.

    Args:
        model: the robot.
        foot_joints: ids of the joints that move the feet.
    """
    chains = [
        [int(model.joints[joint].idx_v) for joint in model.supports[foot] if joint > 1]
        for foot in foot_joints
    ]
    counts = Counter(index for chain in chains for index in chain)
    return tuple(tuple(index for index in chain if counts[index] == 1) for chain in chains)


def front_to_hind(model: pin.Model, pairs: list[tuple[str, str]]) -> tuple[str, ...]:
    """Return the feet of a quadruped: front left, front right, hind left, hind right.

    The hips tell in the zero posture which pair is ahead, along the base's x axis.

    Args:
        model: the robot.
        pairs: links of the left and the right foot of two pairs.
    """
    data = model.createData()
    pin.forwardKinematics(model, data, pin.neutral(model))

    def ahead(pair: tuple[str, str]) -> float:
        hips = [list(model.supports[parent_joint(model, link)])[2:3] for link in pair]
        return sum(float(data.oMi[joint].translation[0]) for hip in hips for joint in hip)

    front, hind = sorted(pairs, key=ahead, reverse=True)
    return (*front, *hind)


def find_torso(model: pin.Model, urdf: Urdf, legs: tuple[tuple[int, ...], ...]) -> str:
    """Return the link from which arms and head branch; the base link if there is none.

    This finds the upper trunk whatever its name and whatever the number of waist joints.
    """
    in_leg = {index for leg in legs for index in leg}
    joint = 1
    while True:
        onward = [j for j in model.children[joint] if model.joints[j].idx_v not in in_leg]
        if len(onward) != 1 or not model.children[onward[0]]:
            break
        joint = int(onward[0])
    return link_of(model, urdf, joint)


def link_of(model: pin.Model, urdf: Urdf, joint: int) -> str:
    """Return the name of the link that a joint of the model moves directly."""
    if joint > 1:
        name = model.names[joint]
        return next(j.child for j in urdf.joints if j.name == name)
    # The root link's frame is the first body frame on the free-flyer.
    return next(str(f.name) for f in model.frames if f.parentJoint == 1 and f.type == pin.BODY)


def parent_joint(model: pin.Model, link: str) -> int:
    """Return the id of the joint of the model that moves a link."""
    return int(model.frames[model.getFrameId(link, pin.BODY)].parentJoint)


def lowest_pair(model: pin.Model) -> tuple[int, int] | None:
    """Return the joints at the ends of the two legs, left and right, or None.

    In the zero posture these are the two lowest ends of the tree, mirror images of each other,
    below the base, and what they do not move has its mass above their first joints: the hands of
    a trunk without legs hang from their shoulders.
    """
    data = model.createData()
    q = pin.neutral(model)
    pin.centerOfMass(model, data, q)
    ends = [j for j in range(2, model.njoints) if not model.children[j]]
    ends.sort(key=lambda j: float(data.oMi[j].translation[2]))
    if len(ends) < 2:
        return None
    pair = ends[:2]
    places = [data.oMi[j].translation for j in pair]
    height = max(float(data.oMi[j].translation[2]) for j in range(1, model.njoints))
    height -= float(places[0][2])
    difference = np.abs(places[0] - places[1] * [1.0, -1.0, 1.0])
    alone = len(ends) == 2 or data.oMi[ends[2]].translation[2] > places[1][2] + _APART * height
    if difference.max() > _MIRRORED * height or not alone or places[1][2] > -_APART * height:
        return None
    chains = [[int(j) for j in model.supports[end] if j > 1] for end in pair]
    if min(map(len, chains)) < _LEG_JOINTS or set(chains[0]) & set(chains[1]):
        return None
    rest = [j for j in range(1, model.njoints) if j not in (*chains[0], *chains[1])]
    mass = sum(model.inertias[j].mass for j in rest)
    moment = sum(model.inertias[j].mass * data.oMi[j].act(model.inertias[j].lever) for j in rest)
    if mass <= 0.0 or moment[2] / mass < data.oMi[chains[0][0]].translation[2] - _APART * height:
        return None
    left, right = sorted(pair, key=lambda j: -float(data.oMi[j].translation[1]))
    return left, right


def reduced_model(model: pin.Model, locked: list[int], q: np.ndarray) -> pin.Model:
    """Return a model without some joints.

    Pinocchio refuses to lock a joint that has the name of a link, so that links lose their names.

    Args:
        model: the model; it is not changed.
        locked: ids of the joints to lock.
        q: (nq,) the posture to lock them in.
    """
    anonymous = model.copy()
    for k, frame in enumerate(anonymous.frames):
        if frame.type == pin.BODY:
            frame.name = f"link {k}"
    return pin.buildReducedModel(anonymous, locked, q)
