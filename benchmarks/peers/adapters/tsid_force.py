"""Adapter of TSID's `InverseDynamicsFormulationAccForce` with eiquadprog-fast."""

from __future__ import annotations

import tempfile
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pinocchio as pin
import tsid.tsid_pywrap as tsid

from peers.case import LEFT, RIGHT, SOLES, STANCES, TORSO, Case
from peers.measuring import Outcome

ORIENTATION = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
NORMAL = np.array([0.0, 0.0, 1.0])
LEAST_FORCE, LARGEST_FORCE = 0.0, 1e6
SOLVER_REGULARISATION = 1e-8


class Tsid:
    """Uses one formulation and one solver for each set of standing feet."""

    def __init__(self, case: Case) -> None:
        self.versions = {name: version(name) for name in ("tsid", "pin", "eiquadprog")}
        ticks = case.ticks
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "robot.urdf"
            path.write_text(case.urdf)
            model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer())
        model.armature = np.concatenate([np.zeros(6), case.armature])
        self._robot = tsid.RobotWrapper(model, False)
        data = self._robot.data()
        self._robot.computeAllTerms(data, ticks.q[0], ticks.v[0])
        case.check_model(
            self._robot.mass(data), self._robot.nonLinearEffect(data), list(model.names)[2:]
        )
        self._kept: list[object] = []  # the formulation holds references to its tasks
        self._stances = {s: self._formulate(case, s) for s in np.unique(ticks.stance)}
        self._per_tick = [self._stances[s] for s in ticks.stance]
        self._q, self._v = list(ticks.q), list(ticks.v)
        # References in the type that the tasks take.
        self._com = [
            sample(*values)
            for values in zip(ticks.com, ticks.com_velocity, ticks.com_acceleration, strict=True)
        ]
        zero = np.zeros(6)
        self._torso = [
            sample(pose(np.zeros(3), R), np.concatenate([np.zeros(3), w]), zero)
            for R, w in zip(ticks.torso, ticks.torso_velocity, strict=True)
        ]
        self._swing = [
            sample(pose(T[:3, 3], T[:3, :3]), v, a)
            for T, v, a in zip(
                ticks.swing, ticks.swing_velocity, ticks.swing_acceleration, strict=True
            )
        ]

    def _formulate(self, case: Case, stance: int) -> tuple[object, ...]:
        robot, gains, limits, ticks = self._robot, case.gains, case.limits, case.ticks
        na = len(case.joints)
        k = int(np.flatnonzero(ticks.stance == stance)[0])
        formulation = tsid.InverseDynamicsFormulationAccForce("tsid", robot, False)
        formulation.computeProblemData(0.0, ticks.q[k], ticks.v[k])
        contacts = {}
        x, y = case.half_length, case.half_width
        corners = np.array([[x, x, -x, -x], [y, -y, y, -y], [0.0, 0.0, 0.0, 0.0]])
        for side in STANCES[stance]:
            contact = tsid.Contact6d(
                side, robot, SOLES[side], corners, NORMAL, case.friction, LEAST_FORCE, LARGEST_FORCE
            )
            contact.setKp(np.zeros(6))
            contact.setKd(np.full(6, gains.contact_damping))
            contact.setRegularizationTaskWeightVector(_force_weights(x, y, gains.force_weight))
            contact.setReference(
                robot.framePosition(formulation.data(), robot.model().getFrameId(SOLES[side]))
            )
            formulation.addRigidContact(contact, gains.force_weight, 1.0, 0)
            contacts[side] = contact
        com = tsid.TaskComEquality("com", robot)
        com.setKp(np.full(3, gains.com_kp))
        com.setKd(np.full(3, 2.0 * np.sqrt(gains.com_kp)))
        formulation.addMotionTask(com, gains.com_weight, 1, 0.0)
        torso = self._se3_task("torso", TORSO, gains.torso_kp)
        torso.setMask(ORIENTATION)
        formulation.addMotionTask(torso, gains.torso_weight, 1, 0.0)
        swing = None
        if stance in (LEFT, RIGHT):
            free = SOLES["right" if stance == LEFT else "left"]
            swing = self._se3_task("swing", free, gains.swing_kp)
            formulation.addMotionTask(swing, gains.swing_weight, 1, 0.0)
        posture = tsid.TaskJointPosture("posture", robot)
        posture.setKp(np.full(na, gains.posture_kp))
        posture.setKd(np.full(na, 2.0 * np.sqrt(gains.posture_kp)))
        posture.setReference(sample(ticks.posture, np.zeros(na), np.zeros(na)))
        formulation.addMotionTask(posture, gains.posture_weight, 1, 0.0)
        momentum = tsid.TaskAMEquality("momentum", robot)
        momentum.setKp(np.full(3, gains.momentum_kp))
        momentum.setKd(np.zeros(3))
        momentum.setReference(sample(np.zeros(3), np.zeros(3), np.zeros(3)))
        formulation.addMotionTask(momentum, gains.momentum_weight, 1, 0.0)
        torque = tsid.TaskActuationBounds("torque", robot)
        torque.setBounds(-limits.torque, limits.torque)
        formulation.addActuationTask(torque, 1.0, 0, 0.0)
        # The task works with twice the time step that it is given.
        bounds = tsid.TaskJointPosVelAccBounds("bounds", robot, 0.5 * limits.horizon, False)
        bounds.setPositionBounds(limits.lower, limits.upper)
        bounds.setVelocityBounds(limits.velocity)
        bounds.setAccelerationBounds(limits.braking)
        bounds.setImposeBounds(True, True, True, False)
        formulation.addMotionTask(bounds, 1.0, 0, 0.0)
        solver = tsid.SolverHQuadProgFast("eiquadprog-fast")
        solver.resize(formulation.nVar, formulation.nEq, formulation.nIn)
        self._kept += [contacts, com, torso, swing, posture, momentum, torque, bounds]
        return formulation, solver, com, torso, swing, contacts

    def _se3_task(self, name: str, frame: str, kp: float) -> object:
        task = tsid.TaskSE3Equality(name, self._robot, frame)
        task.setKp(np.full(6, kp))
        task.setKd(np.full(6, 2.0 * np.sqrt(kp)))
        return task

    def tick(self, k: int) -> np.ndarray:
        """See `Adapter`."""
        formulation, solver, com, torso, swing, _ = self._per_tick[k]
        com.setReference(self._com[k])
        torso.setReference(self._torso[k])
        if swing is not None:
            swing.setReference(self._swing[k])
        problem = formulation.computeProblemData(0.0, self._q[k], self._v[k])
        self._solution = solution = solver.solve(problem)
        self._last = k
        self._tau = formulation.getActuatorForces(solution)
        return self._tau

    def outcome(self) -> Outcome:
        """See `Adapter`."""
        formulation, _, _, _, _, contacts = self._per_tick[self._last]
        solution = self._solution
        wrenches = np.zeros((2, 6))
        for index, side in enumerate(("left", "right")):
            if side in contacts:
                points = formulation.getContactForce(side, solution)
                wrenches[index] = contacts[side].getForceGeneratorMatrix @ points
        acceleration = formulation.getAccelerations(solution)
        return Outcome(solution.status == 0, self._tau, acceleration, wrenches)


def _force_weights(x: float, y: float, wanted: float) -> np.ndarray:
    """Return factors (6,) on a wrench's rows such that its whole cost is `wanted` per N², (N·m)².

    The solver adds 1e-8 on every corner force. Of the forces at (±x, ±y) that make a wrench
    the least ones cost `1e-8 / [4, 4, 4, 4 y², 4 x², 4 (x² + y²)]` per square of its entries.
    """
    corners = SOLVER_REGULARISATION / (4.0 * np.array([1, 1, 1, y * y, x * x, x * x + y * y]))
    return np.sqrt(np.maximum(1.0 - corners / wanted, 0.0))


def sample(value: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray) -> object:
    sample = tsid.TrajectorySample(len(value), len(velocity))
    sample.value(value)
    sample.derivative(velocity)
    sample.second_derivative(acceleration)
    return sample


def pose(position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Return (12,): position, then the rotation column by column."""
    return np.concatenate([position, rotation.T.ravel()])
