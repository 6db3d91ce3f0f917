"""Exact readings of the simulated sensors, before noise."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from wbc.robot import Robot
from wbc.sim.coordinates import CoordinateMap

#: A sole whose corners are all within this of the floor is taken to stand on it, m.
_STANDING_HEIGHT = 0.005
#: Lever that makes moments comparable to forces in the standing wrenches, m.
_MOMENT_SCALE = 0.1


class Sensors:
    """Reads encoders, IMU and foot sensors of a MuJoCo simulation.

    Encoders and gyro are those of the instant. The accelerometer and the foot sensors
    deliver their mean since the last control tick, as real ones do behind their
    anti-aliasing filters: a touchdown is neither missed nor blown up by sampling.

    Args:
        robot: the robot.
        mujoco: the module.
        model: model with sites "imu" and one of each sole's name.
        data: data of the running simulation.
        coordinates: order of the robot's joints.
        torques: how many joint torques are measured.

    Attributes:
        reading: `[q, v, gyro, accelerometer, wrenches, joint torques]` of the last update.
    """

    def __init__(
        self,
        robot: Robot,
        mujoco: Any,
        model: Any,
        data: Any,
        coordinates: CoordinateMap,
        torques: int,
    ) -> None:
        self._robot = robot
        self._model = model
        self._data = data
        self._joints = 7 + coordinates.order
        self._rates = 6 + coordinates.order
        self._imu = model.site("imu").id
        self._feet = np.array([model.site(s.name).id for s in robot.soles])
        bodies = model.site_bodyid[self._feet]
        # Views of MuJoCo's own memory, taken once: each access to `data` makes a new one.
        self._qpos, self._qvel = data.qpos, data.qvel
        self._exact_gyro = data.sensor("gyro").data
        self._exact_accelerometer = data.sensor("accelerometer").data
        self._com = data.subtree_com[model.body_rootid[bodies[0]]]
        self._sums = np.zeros(3 + 6 * len(robot.soles))
        self._acceleration = self._sums[:3]
        self._foot_views = [
            (total, data.cfrc_ext[body], data.site_xpos[site], data.site_xmat[site])
            for total, body, site in zip(
                self._sums[3:].reshape(-1, 6), bodies, self._feet, strict=True
            )
        ]
        self._spatial = np.empty(6)
        self._transform = mujoco.mju_transformSpatial
        self._samples = 0
        na = robot.na
        self.reading = np.zeros(2 * na + 6 + 6 * len(robot.soles) + torques)
        self._q = self.reading[:na]
        self._v = self.reading[na : 2 * na]
        self._gyro = self.reading[2 * na : 2 * na + 3]
        self._averaged = self.reading[2 * na + 3 : self.reading.size - torques]
        self._torques = self.reading[self.reading.size - torques :]
        self._exact_torques = data.ctrl[:torques]
        self._wrenches = self._averaged[3:].reshape(-1, 6)

    def joints(self) -> tuple[np.ndarray, np.ndarray]:
        """Return exact joint positions and velocities now, (na,) each; rad, rad/s."""
        return self._qpos.take(self._joints), self._qvel.take(self._rates)

    def accumulate(self) -> None:
        """Add the readings of one physics step, between its forces and the next kinematics."""
        self._acceleration += self._exact_accelerometer
        spatial, com = self._spatial, self._com
        for total, external, place, axes in self._foot_views:
            # cfrc_ext is moment then force about the robot's CoM, in world axes.
            self._transform(spatial, external, 1, place, com, axes)
            total += spatial
        self._samples += 1

    def update(self) -> None:
        """Fill `reading` with what is measured at this instant."""
        self._instant()
        self._torques[:] = self._exact_torques
        if self._samples:
            self._sums *= 1.0 / self._samples
            self._averaged[:3] = self._acceleration
            for wrench, (total, *_) in zip(self._wrenches, self._foot_views, strict=True):
                wrench[:3], wrench[3:] = total[3:], total[:3]
            self._sums[:] = 0.0
            self._samples = 0

    def reset(self) -> None:
        """Fill `reading` at a reset, when no physics step has been taken yet.

        A standing robot reads as if it were held still, its weight on its soles; one in the
        air as in free fall.
        """
        self._instant()
        self._sums[:] = 0.0
        self._samples = 0
        self._averaged[:] = self._torques[:] = 0.0
        standing = [i for i in range(len(self._feet)) if self._stands(i)]
        if not standing:
            return
        data, gravity = self._data, self._model.opt.gravity
        self._averaged[:3] = -gravity @ data.site_xmat[self._imu].reshape(3, 3)
        self._wrenches[standing] = self._standing_wrenches(standing)
        if self._torques.size:
            self._torques[:] = self._holding_torques()

    def _instant(self) -> None:
        self._qpos.take(self._joints, out=self._q, mode="clip")
        self._qvel.take(self._rates, out=self._v, mode="clip")
        self._gyro[:] = self._exact_gyro

    def _stands(self, i: int) -> bool:
        sole, site = self._robot.soles[i], self._feet[i]
        axes = self._data.site_xmat[site].reshape(3, 3)
        reach = abs(axes[2, 0]) * sole.half_length + abs(axes[2, 1]) * sole.half_width
        return bool(abs(self._data.site_xpos[site, 2]) + reach < _STANDING_HEIGHT)

    def _standing_wrenches(self, feet: list[int]) -> np.ndarray:
        """Return the smallest wrenches that carry the weight at rest, (k, 6), in sole axes."""
        data = self._data
        com = self._com
        scale = np.diag([1.0, 1.0, 1.0, _MOMENT_SCALE, _MOMENT_SCALE, _MOMENT_SCALE])
        columns = []
        for i in feet:
            site = self._feet[i]
            placement = pin.SE3(data.site_xmat[site].reshape(3, 3), data.site_xpos[site] - com)
            columns.append(placement.toDualActionMatrix() @ scale)
        weight = np.concatenate([-self._robot.mass * self._model.opt.gravity, np.zeros(3)])
        solution = np.linalg.lstsq(np.hstack(columns), weight, rcond=None)[0]
        wrenches: np.ndarray = solution.reshape(-1, 6) @ scale
        return wrenches

    def _holding_torques(self) -> np.ndarray:
        """Return the torques of a robot at rest on its soles, (na,) N·m: τ = h − Jᵀ F."""
        robot, data = self._robot, self._data
        model = robot.model
        q = np.concatenate((data.qpos[:3], data.qpos[4:7], data.qpos[3:4], self._q))
        workspace = model.createData()
        tau = pin.computeGeneralizedGravity(model, workspace, q)
        pin.computeJointJacobians(model, workspace, q)
        for sole, wrench in zip(robot.soles, self._wrenches, strict=True):
            frame = robot.frame_id(sole.name)
            J = pin.getFrameJacobian(model, workspace, frame, pin.ReferenceFrame.LOCAL)
            tau = tau - J.T @ wrench
        torques: np.ndarray = tau[6:]
        return torques
