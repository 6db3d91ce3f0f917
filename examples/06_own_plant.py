"""Write your own plant for `wbc.run`: here Pinocchio's dynamics on a spring-damper floor.

A plant has `robot`, `dt`, `time`, `measure()` and `step(command)`; on a real robot these read
sensors and send torques.
"""

import numpy as np
import pinocchio as pin

import wbc

STIFFNESS, DAMPING, FRICTION = 4e4, 400.0, 0.8  # N/m, N·s/m per corner of a sole
SUBSTEPS = 10


class SpringFloor:
    """Springs and dampers at the corners of the soles, integrated with small steps."""

    def __init__(self, robot, dt=0.002):
        self.robot, self.dt, self.time = robot, dt, 0.0
        self.model, self.data = robot.model, robot.model.createData()
        self.state = robot.standing()
        self.forces = pin.StdVec_Force([pin.Force.Zero() for _ in range(self.model.njoints)])
        self.wrenches = {sole.name: np.zeros(6) for sole in robot.soles}

    def measure(self):
        """Return ideal sensor values and the true state, which `GroundTruthEstimator` uses."""
        q, v = self.state.q, self.state.v
        still = np.zeros(3)  # the accelerometer, unused here
        return wbc.Measurement(self.time, q[7:], v[6:], v[3:6], still, self.wrenches, self.state)

    def step(self, command):
        """Apply constant torques for one control period."""
        tau, h = np.concatenate([np.zeros(6), command.tau]), self.dt / SUBSTEPS
        for _ in range(SUBSTEPS):
            q, v = self.state.q, self.state.v
            pin.forwardKinematics(self.model, self.data, q, v)
            for sole in self.robot.soles:
                wrench = self.spring(sole)
                self.wrenches[sole.name] = wrench.vector
                self.forces[sole.joint_id] = sole.placement.act(wrench)
            v = v + h * pin.aba(self.model, self.data, q, v, tau, self.forces)
            self.state = wbc.State(pin.integrate(self.model, q, h * v), v)
        self.time += self.dt

    def spring(self, sole):
        """Return the wrench of the floor on a sole, sole axes, N and N·m."""
        T = self.data.oMi[sole.joint_id] * sole.placement
        twist = pin.getFrameVelocity(self.model, self.data, sole.frame_id, pin.LOCAL)
        x, y = sole.half_length, sole.half_width
        corners = np.array([(x, y, 0.0), (x, -y, 0.0), (-x, -y, 0.0), (-x, y, 0.0)])
        speed = (twist.linear + corners @ pin.skew(twist.angular).T) @ T.rotation.T
        depth = -(T.translation + corners @ T.rotation.T)[:, 2]
        up = (depth > 0.0) * np.maximum(STIFFNESS * depth - DAMPING * speed[:, 2], 0.0)
        slide = -FRICTION * up[:, None] * np.clip(speed[:, :2] / 0.1, -1.0, 1.0)
        force = np.column_stack([slide, up]) @ T.rotation
        return pin.Force(force.sum(axis=0), np.cross(corners, force).sum(axis=0))


robot = wbc.load("simple_humanoid")
walker = wbc.Walker(robot)
walker.velocity = (0.2, 0.0, 0.0)
report = wbc.run(walker, SpringFloor(robot), 1.5, estimator=wbc.GroundTruthEstimator(robot))
print(report.table())
