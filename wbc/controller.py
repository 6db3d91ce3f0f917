"""The whole-body controller: one QP per tick from tasks, contacts and limits to torques."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from wbc.command import Command, Status
from wbc.contacts import Contact
from wbc.errors import ContactError, TaskError, WbcError
from wbc.kinematics import Kinematics
from wbc.limits import AccelerationBound, JointPositionLimit, JointVelocityLimit, TorqueLimit
from wbc.qp import Assembly, Formulation, Outcome, Problem, Regularisation, explain, make_solver
from wbc.robot import Robot
from wbc.state import State
from wbc.tasks import Task

TaskT = TypeVar("TaskT", bound=Task)

_HOLD_TIME = 0.1  # s, how fast the torque of the last good tick fades after a failure
_SAFE_DAMPING = 0.05  # share of the torque limit per rad/s


class WholeBodyController:
    """Inverse-dynamics control by a quadratic program.

    Each tick solves, over the acceleration v̇, contact forces f and torques τ,

        min  ½ Σ_tasks ‖A v̇ − b‖²_w + small costs
        s.t. M v̇ + h = Sᵀ τ + Jᵀ f,   contacts' motion,   f in the contacts' cones,
             limits on τ and q̈,   exact tasks A v̇ = b,

    in fewer unknowns (see `wbc.qp.elimination`). When there is no solution, the command
    holds the last good torques, fading within 0.1 s, plus joint damping of 5 % of the
    torque limit per rad/s, clipped to the limits; `status` says so and `explanation`
    names the rows in conflict.

    Args:
        robot: the robot.
        dt: control period, s.
        solver: "daqp", "osqp" or any dense solver of `qpsolvers` by its name.
        limits: joint limits; torque, position and velocity limits of the robot when left out.
        formulation: reduced (fast) or full (readable); the same optimum.
        regularisation: small costs that make the optimum unique.

    Raises:
        SolverNotFound: the solver is unknown or not installed.
    """

    def __init__(
        self,
        robot: Robot,
        dt: float = 0.002,
        *,
        solver: str = "daqp",
        limits: Sequence[TorqueLimit | AccelerationBound] | None = None,
        formulation: Formulation = Formulation.REDUCED,
        regularisation: Regularisation | None = None,
    ) -> None:
        if not dt > 0.0:
            raise WbcError(f"dt = {dt} must be positive: it is the control period in seconds")
        self.robot = robot
        self.dt = dt
        self.solver = make_solver(solver)
        if limits is None:
            limits = (TorqueLimit(robot), JointPositionLimit(robot), JointVelocityLimit(robot))
        torque = [limit for limit in limits if isinstance(limit, TorqueLimit)]
        if len(torque) > 1:
            raise WbcError("more than one TorqueLimit given; keep the tighter one")
        self.torque_limit = torque[0] if torque else None
        self.bounds = [limit for limit in limits if isinstance(limit, AccelerationBound)]
        self.formulation = formulation
        self.regularisation = regularisation or Regularisation()
        self.tasks: list[Task] = []
        self.contacts: tuple[Contact, ...] = ()
        self.kinematics: Kinematics | None = None
        self.problem: Problem | None = None  #: the last tick's QP, for the curious
        self._assemblies: dict[tuple[object, ...], Assembly] = {}
        self._last_tau = np.zeros(robot.na)

    def add(self, task: TaskT) -> TaskT:
        """Add a task and return it.

        Raises:
            TaskError: there is a task of that name already.
            FrameNotFound: the task's frame is missing; the text lists near names.
        """
        if any(task.name == other.name for other in self.tasks):
            raise TaskError(f"there is a task named '{task.name}' already; give this one another name")
        task.bind(self.robot)
        self.tasks.append(task)
        return task

    def remove(self, task: Task) -> None:
        """Remove a task.

        Raises:
            TaskError: it was never added.
        """
        if task not in self.tasks:
            names = ", ".join(f"'{t.name}'" for t in self.tasks) or "none"
            raise TaskError(f"no task '{task.name}' to remove; there are: {names}")
        self.tasks.remove(task)

    def set_contacts(self, contacts: Sequence[Contact]) -> None:
        """Replace the contacts; no contact at all is free fall.

        The first exact surface contact carries the elimination: list the most loaded
        foot first.

        Raises:
            FrameNotFound: a contact's frame is missing.
            ContactError: two contacts of one name.
        """
        names = [c.name for c in contacts]
        if len(set(names)) < len(names):
            raise ContactError(f"two contacts have the same name: {names}")
        for contact in contacts:
            contact.bind(self.robot)
        self.contacts = tuple(contacts)

    def step(self, state: State) -> Command:
        """One tick.

        Raises:
            StateError: the state has a wrong size, a NaN or a non-unit quaternion.
        """
        if self.kinematics is None:
            self.kinematics = Kinematics(self.robot, state)
        else:
            self.kinematics.update(state)
        return self.solve(self.kinematics)

    def solve(self, kin: Kinematics) -> Command:
        """One tick from kinematics that are there already."""
        assembly = self._assembly()
        problem = self.problem = assembly.build(kin)
        solution = self.solver.solve(problem)
        if solution.outcome is not Outcome.SOLVED:
            return self._safe_command(kin, problem, solution.outcome, solution.detail)
        acceleration, tau, wrenches = assembly.recover(solution.x)
        if not np.isfinite(tau.sum()) or not np.isfinite(acceleration.sum()):
            return self._safe_command(kin, problem, Outcome.FAILED, "the solution is not finite")
        tau = self._clip(tau)  # what the solver's tolerance leaves
        self._last_tau = tau
        return self._command(kin, tau, acceleration, wrenches, Status.OK, "")

    def _assembly(self) -> Assembly:
        key = (
            tuple((id(t), t.priority) for t in self.tasks),
            tuple((id(c), c.motion_weight is None) for c in self.contacts),
        )
        found = self._assemblies.get(key)
        if found is None:
            if len(self._assemblies) >= 32:  # contacts made anew each tick must not pile up
                self._assemblies.clear()
            found = self._assemblies[key] = Assembly(
                self.robot,
                self.tasks,
                self.contacts,
                self.bounds,
                self.torque_limit,
                self.formulation,
                self.regularisation,
            )
        return found

    def _clip(self, tau: np.ndarray) -> np.ndarray:
        if self.torque_limit is None:
            return tau
        limit = self.torque_limit.maximum
        return np.minimum(np.maximum(tau, -limit), limit)

    def _safe_command(
        self, kin: Kinematics, problem: Problem, outcome: Outcome, detail: str
    ) -> Command:
        self._last_tau = self._last_tau * (1.0 - min(self.dt / _HOLD_TIME, 1.0))
        limit = np.where(np.isfinite(self.robot.tau_max), self.robot.tau_max, 0.0)
        tau = self._clip(self._last_tau - _SAFE_DAMPING * limit * kin.state.v[6:])
        reason = explain(problem)
        infeasible = outcome is Outcome.INFEASIBLE or bool(reason)
        status = Status.INFEASIBLE if infeasible else Status.FAILED
        text = reason or f"the solver gave up ({detail}); the rows can hold together"
        wrenches = {c.name: np.zeros(6) for c in self.contacts}
        return self._command(kin, tau, np.zeros(self.robot.nv), wrenches, status, text)

    def _command(
        self,
        kin: Kinematics,
        tau: np.ndarray,
        acceleration: np.ndarray,
        wrenches: dict[str, np.ndarray],
        status: Status,
        explanation: str,
    ) -> Command:
        q, v, a = kin.state.q[7:], kin.state.v[6:], acceleration[6:]
        dt = self.dt
        q_target = q + dt * v + (0.5 * dt * dt) * a
        return Command(tau, acceleration, wrenches, q_target, v + dt * a, status, explanation)
