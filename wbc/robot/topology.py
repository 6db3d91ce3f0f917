"""Queries of the kinematic tree: the joints of a leg, the torso, links and joints."""

from __future__ import annotations

import pinocchio as pin

from wbc.robot.urdf import Urdf


def leg_joints(model: pin.Model, foot_joint: int) -> tuple[int, ...]:
    """Return the velocity indices (into nv) of the joints from the base to a foot, base first."""
    chain = [joint for joint in model.supports[foot_joint] if joint > 1]
    return tuple(int(model.joints[joint].idx_v) for joint in chain)


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
