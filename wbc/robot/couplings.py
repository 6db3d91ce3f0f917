"""Joints that one motor moves together: the `<mimic>` elements of a URDF."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from wbc.errors import RobotDescriptionError, did_you_mean
from wbc.robot.urdf import Urdf, UrdfJoint


@dataclass(frozen=True, slots=True)
class Coupling:
    """A joint that follows another one: `q = ratio · q_leader + offset`.

    Attributes:
        joint: index of the joint into (na,) vectors.
        leader: index of the joint that it follows, which follows none itself.
        ratio: its velocity over that of the leader.
        offset: its position where the leader is at zero, rad or m.
    """

    joint: int
    leader: int
    ratio: float
    offset: float


def read_couplings(urdf: Urdf, model: pin.Model) -> tuple[Coupling, ...]:
    """Return the couplings of a description's joints, as far as the model has these.

    Args:
        urdf: the description.
        model: its model, in which joints may be welded.

    Raises:
        RobotDescriptionError: a joint mimics one that the file does not have, or itself.
    """
    joints = {joint.name: joint for joint in urdf.joints}
    couplings = []
    for joint in urdf.joints:
        if joint.element.find("mimic") is None or not model.existJointName(joint.name):
            continue
        leader, ratio, offset = _leader(urdf, joints, joint)
        # The leader may be welded at zero: then the joint is left to itself.
        if model.existJointName(leader):
            joint_id, leader_id = model.getJointId(joint.name), model.getJointId(leader)
            index, leader_index = (int(model.joints[i].idx_v) - 6 for i in (joint_id, leader_id))
            couplings.append(Coupling(index, leader_index, ratio, offset))
    return tuple(couplings)


def _leader(urdf: Urdf, joints: dict[str, UrdfJoint], joint: UrdfJoint) -> tuple[str, float, float]:
    """Return the joint at the end of a chain of mimics, and the ratio and offset to it."""
    ratio, offset, seen = 1.0, 0.0, [joint.name]
    now = joint
    while (mimic := now.element.find("mimic")) is not None:
        name = mimic.get("joint", "")
        where = f"{urdf.path}, line {urdf.line(mimic)}: joint '{now.name}' mimics"
        if name not in joints:
            raise RobotDescriptionError(
                f"{where} '{name}', which the file does not have{did_you_mean(name, joints)}"
            )
        if name in seen:
            raise RobotDescriptionError(
                f"{where} '{name}', which follows it in turn; a leader follows nothing: remove "
                "one <mimic>"
            )
        offset += ratio * urdf.numbers(mimic, "offset", (0.0,))[0]
        ratio *= urdf.numbers(mimic, "multiplier", (1.0,))[0]
        seen.append(name)
        now = joints[name]
    return now.name, ratio, offset


def couple(q: np.ndarray, couplings: Sequence[Coupling]) -> None:
    """Put the joints of a configuration (nq,) where their leaders want them, in place."""
    for coupling in couplings:
        q[7 + coupling.joint] = coupling.ratio * q[7 + coupling.leader] + coupling.offset


def share_efforts(model: pin.Model, couplings: Sequence[Coupling]) -> None:
    """Divide the effort limit of each leader between it and the joints that follow it.

    The motor exerts `τ_leader + Σ ratio τ`, which stays within its limit if each term does within
    its share.
    """
    effort = np.array(model.effortLimit)
    for leader in {coupling.leader for coupling in couplings}:
        followers = [coupling for coupling in couplings if coupling.leader == leader]
        effort[6 + leader] /= 1 + len(followers)
        for coupling in followers:
            effort[6 + coupling.joint] = effort[6 + leader] / max(abs(coupling.ratio), 1e-3)
    model.effortLimit = effort
