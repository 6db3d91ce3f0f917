"""Random arms with six joints, as in https://github.com/stephane-caron/pink/issues/59."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin

import wbc
from wbc.robot import RobotModel

JOINTS = 6
HAND = "link_6"
SHORTEST, LONGEST = 0.1, 0.4  # m, of a link, along one of the axes
TURNS = 0.5 * np.pi * np.arange(4)  # rad, between the axes of joints that follow each other
RANGE = np.pi  # rad, to either side
SINGULAR = 1e-3  # least singular value of the Jacobian, m and rad


def random_arm(random: np.random.Generator) -> RobotModel:
    """Return an arm of six joints that turn about z, and can move its hand in all directions.

    The axes of joints that follow each other are parallel or at right angles, as those of most
    arms are.
    """
    while True:
        robot = _any_arm(random)
        q = robot.q_nominal.copy()
        q[7:] = random.uniform(robot.q_min, robot.q_max)
        hand = robot.frame_id(HAND)
        J = pin.computeFrameJacobian(robot.model, robot.model.createData(), q, hand)[:, 6:]
        if np.linalg.svd(J)[1].min() > SINGULAR:
            return robot


def _any_arm(random: np.random.Generator) -> RobotModel:
    links = [f'<link name="link_{k}"><inertial><mass value="1"/>{_INERTIA}</inertial></link>'
             for k in range(JOINTS + 1)]  # fmt: skip
    joints = []
    for k in range(JOINTS):
        way = random.uniform(SHORTEST, LONGEST) * np.eye(3)[random.integers(3)]
        place = " ".join(f"{x:.4f}" for x in way)
        turn = f"{random.choice(TURNS):.6f} 0 0"
        joints.append(
            f'<joint name="joint_{k}" type="revolute"><origin xyz="{place}" rpy="{turn}"/>'
            f'<parent link="link_{k}"/><child link="link_{k + 1}"/><axis xyz="0 0 1"/>'
            f'<limit lower="{-RANGE}" upper="{RANGE}" effort="100" velocity="3"/></joint>'
        )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "arm.urdf"
        path.write_text(f'<robot name="arm">{"".join(links + joints)}</robot>', encoding="utf-8")
        return wbc.load_fixed_base(path)


_INERTIA = '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>'
