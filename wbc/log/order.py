"""What the log's process is told."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from wbc.log.describe import Facts, versions
from wbc.log.layout import Layout
from wbc.log.sheet import RobotSheet

if TYPE_CHECKING:
    import pinocchio as pin

    from wbc.robot import Robot


@dataclass(frozen=True, eq=False)
class Order:
    """The first message.

    Attributes:
        layout: of the ring's records.
        model: of the robot.
        joints: names of the joints.
        base: name of the root link.
        imu: name of the inertial unit's frame.
        soles: name and index of each sole's frame.
        description: the URDF.
        facts: of the robot and the software.
        path: of the file.
        descriptor: of the ring's shared memory.
        capacity: of the ring.
        parent: process whose end is the log's end.
    """

    layout: Layout
    model: pin.Model
    joints: tuple[str, ...]
    base: str
    imu: str
    soles: tuple[tuple[str, int], ...]
    description: str
    facts: Facts
    path: Path
    descriptor: int
    capacity: int
    parent: int

    @staticmethod
    def of(robot: Robot, path: Path, descriptor: int, capacity: int, parent: int) -> Order:
        """The order to log a robot."""
        return Order(
            layout=Layout.of(robot),
            model=robot.model,
            joints=robot.joint_names,
            base=robot.base,
            imu=robot.imu,
            soles=tuple((sole.name, int(sole.frame_id)) for sole in robot.soles),
            description=robot.urdf_path.read_text("utf-8", "replace"),
            facts=Facts({"versions": versions()}, {"robot.json": RobotSheet.of(robot).to_json()}),
            path=path,
            descriptor=descriptor,
            capacity=capacity,
            parent=parent,
        )
