"""Inverse kinematics: joint velocities from the tasks and limits of the controller."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wbc.errors import TaskError, short_repr
from wbc.ik.configuration_kinematics import ConfigurationKinematics
from wbc.ik.errors import InverseKinematicsError, NoSolutionFound
from wbc.ik.reach import ReachSearch, ReachSolution
from wbc.ik.velocity_program import (
    Unknown,
    VelocityProblemLayout,
    VelocityProgram,
    non_finite_error,
)
from wbc.limits import AnyLimit, JointJerkLimit, JointPositionLimit, JointVelocityLimit, LimitSet
from wbc.qp import Outcome, Problem, Solver, explain, load_qp_kernels, resolve_solver
from wbc.qp.priorities import PriorityOrder
from wbc.qp.relaxation import relaxed_problem
from wbc.robot import Coupling, FixedBaseRobot, RobotModel
from wbc.tasks import JointTask, Task, TaskCollection

if TYPE_CHECKING:
    from wbc.ik.compiled_program import CompiledVelocityProgram
    from wbc.ik.prioritized_program import PrioritizedVelocityProgram

_COUPLING_KP = 100.0  # 1/s²: a gain of 5 1/s, stable for steps of up to 0.4 s
BASE = "root_joint"  #: name of the floating base among the joints


class InverseKinematics(TaskCollection):
    """Differential inverse kinematics by a quadratic program.

    Each step solves, over the velocities v of the coordinates that move,

        min  ½ Σ_tasks ‖J v − v_ref − (kp/kd) e‖²_w + ½ damping ‖v‖²
        s.t. J v = v_ref + (kp/kd) e for exact tasks (priority 0), limits on v,

    level by level when tasks or limits have different priorities (see `wbc.Task`; the damping
    belongs to the last level), with the same tasks and limits as `wbc.WholeBodyController`: e is
    the task's error and v_ref its reference velocity. A task with kp = 1/dt and kd = 1 asks for
    its target within one step.
    Position limits keep every joint able to stop before its range ends, at the limit's `braking`
    (see `wbc.limits.JointPositionLimit.velocity_bounds`); limits on torques have no meaning here
    and are left aside.

    Args:
        robot: one that walks or one whose base is fixed.
        joints: names of the joints that may move, "root_joint" for a floating base; when left
            out all of them, and the base unless it is fixed.
        limits: inequalities that hold exactly; position and velocity limits of the robot when
            left out.
        solver: QP solver, see `wbc.WholeBodyController`.
        damping: cost of every velocity, which makes the optimum unique.

    Attributes:
        robot: the robot.
        tasks: those added, in order.
        kinematics: kinematics of the last configuration; None before the first step.
        problem: the last step's QP; its arrays are overwritten by the next one.

    Raises:
        JointNotFound: one of the joints is missing.
        InverseKinematicsError: nothing may move, or the damping is not positive.
        LimitError: see `set_limits`.
        SolverNotFound: the solver is unknown or not installed.
    """

    def __init__(
        self,
        robot: RobotModel,
        *,
        joints: Sequence[str] | None = None,
        limits: Sequence[AnyLimit] | None = None,
        solver: str | Solver | None = None,
        damping: float = 1e-6,
    ) -> None:
        if not 0.0 < damping < math.inf:
            raise InverseKinematicsError(f"damping = {damping} must be positive and finite")
        self._columns = _columns(robot, joints)
        super().__init__(robot, _COUPLING_KP)
        self.solver = resolve_solver(solver)
        self.damping = damping
        if limits is None:
            limits = (JointPositionLimit(robot), JointVelocityLimit(robot))
        self.set_limits(limits)
        self.kinematics: ConfigurationKinematics | None = None
        self.problem: Problem | None = None
        self._at_rest = np.zeros(robot.nv)
        self._programs: dict[tuple[object, ...], VelocityProgram | CompiledVelocityProgram] = {}
        self._prioritized: dict[tuple[object, ...], PrioritizedVelocityProgram] = {}
        self._level_solver: Solver | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Return everything but the programs, which refer to memory and are made again."""
        return {**self.__dict__, "_programs": {}, "_prioritized": {}, "problem": None}

    def __repr__(self) -> str:
        tasks = ", ".join(task.name for task in self.tasks) or "none"
        return (
            f"InverseKinematics('{self.robot.name}', {self._columns.size} of {self.robot.nv} "
            f"coordinates move, tasks: {tasks})"
        )

    def _moves(self, coupling: Coupling) -> bool:
        return bool(np.isin((6 + coupling.joint, 6 + coupling.leader), self._columns).any())

    @property
    def limits(self) -> tuple[AnyLimit, ...]:
        """The limits; set them by `set_limits`."""
        return self._limits

    def set_limits(self, limits: Sequence[AnyLimit]) -> None:
        """Replace the limits.

        Raises:
            LimitError: something that is no limit, or two general limits of one name.
        """
        self._limit_set = LimitSet.sort(limits, self.robot, 0.0)
        self._limits = tuple(limits)
        self._positions = tuple(
            bound for bound in self._limit_set.bounds if isinstance(bound, JointPositionLimit)
        )
        self._limits_jerks = any(isinstance(b, JointJerkLimit) for b in self._limit_set.bounds)
        self._reach_limits = LimitSet(None, self._positions, self._limit_set.inequalities)

    def step(self, q: np.ndarray, dt: float, v: np.ndarray | None = None) -> np.ndarray:
        """Return the velocity (nv,) of one step; move on with `pin.integrate(model, q, dt * v)`.

        Args:
            q: (nq,) configuration.
            dt: duration of the step, s.
            v: (nv,) velocity before the step, from which limits on accelerations and jerks count;
                at rest when left out.

        Raises:
            StateError: q has a wrong size, a NaN or a non-unit quaternion.
            InverseKinematicsError: dt is not positive, or v has a wrong size or a NaN.
            NoSolutionFound: no velocity holds all limits and exact tasks, or a target, weight or
                gain is not finite.
        """
        if not 0.0 < dt < math.inf:
            raise InverseKinematicsError(f"dt = {dt} must be positive: the step's duration in s")
        previous = self._at_rest if v is None else self._checked_velocity(v)
        if self.kinematics is None:
            self.kinematics = ConfigurationKinematics(self.robot, q)
        self.kinematics.set_configuration(q, previous)
        before = previous[6:]
        soft = any(limit.priority for limit in self._limit_set.inequalities)
        if soft or any(task.priority > 1 for task in self.tasks):
            problem = self._prioritized_program().build(self.kinematics, before, dt)
        else:
            weighted = tuple([task for task in self.tasks if task.priority != 0])
            exact = tuple([task for task in self.tasks if task.priority == 0])
            program = self._program(Unknown.VELOCITY, weighted, exact, self._limit_set)
            problem = program.build(self.kinematics, before, dt)
        self.problem = problem
        velocity = np.zeros(self.robot.nv)
        velocity[self._columns] = self._solve(problem)
        if self._limits_jerks:
            self.kinematics.previous_acceleration = (velocity - previous) / dt
        return velocity

    def reach(
        self,
        q: np.ndarray,
        *,
        targets: Sequence[Task] | None = None,
        tolerance: float = 1e-5,
        restarts: int = 100,
        seed: int = 0,
    ) -> ReachSolution:
        """Search for a posture at which the errors of tasks vanish.

        Position limits and general limits hold at every posture tried; limits on velocities and
        accelerations have no meaning for a search. What the targets leave open is settled by the
        other weighted tasks, e.g. a posture. Where targets of different priorities cannot all be
        reached, those of the lower levels come as near as those of the higher ones let them.

        Args:
            q: (nq,) posture to start from; what does not move stays as in it.
            targets: tasks to reach beside the exact ones, among those that were added; when left
                out all but postures.
            tolerance: largest error of a row that counts as reached, m and rad.
            restarts: largest number of further attempts, from random postures.
            seed: seed of these.

        Returns:
            The posture that came nearest, whether it reached the targets, and if not, which limits
            were in the way.

        Raises:
            StateError: q has a wrong size, a NaN or a non-unit quaternion.
            TaskError: a target was not added.
            NoSolutionFound: the target or gain of a task, or a limit, is not finite.
            InverseKinematicsError: there is nothing to reach, or a tolerance that is not positive.
        """
        reached = tuple(self._targets() if targets is None else targets)
        for task in reached:
            if task not in self.tasks:
                raise TaskError(f"{short_repr(task)} is none of the tasks that were added")
        reached += tuple([t for t in self.tasks if t.priority == 0 and t not in reached])
        if not reached or not tolerance > 0.0 or restarts < 0:
            raise InverseKinematicsError(
                f"{len(reached)} targets, tolerance {tolerance}, {restarts} restarts: there must "
                "be a target and a positive tolerance"
            )
        if self.kinematics is None:
            self.kinematics = ConfigurationKinematics(self.robot, q)
        self.kinematics.set_configuration(q)
        start = np.array(q, dtype=float)
        search = self._search(reached, tuple([t for t in self.tasks if t not in reached]))
        found = search.search(self.kinematics, start, restarts, seed, tolerance)
        levels = sorted({task.priority for task in reached})
        while not found.reached and len(levels) > 1:
            last = levels.pop()
            upper = tuple([task for task in reached if task.priority < last])
            lower = tuple([task for task in reached if task.priority == last])
            narrower = self._search(upper, lower)
            part = narrower.search(self.kinematics, start, restarts, seed, tolerance)
            if part.reached:
                return search.describe(self.kinematics, part, found, tolerance)
        return found

    def _search(self, targets: tuple[Task, ...], others: tuple[Task, ...]) -> ReachSearch:
        """Return the search for a posture that reaches targets and improves other tasks."""
        limits, displacement = self._reach_limits, Unknown.DISPLACEMENT
        others = tuple([task for task in others if task.priority != 0])
        return ReachSearch(
            self.robot,
            self._program(displacement, targets, (), limits),
            targets,
            self._columns,
            np.max([self.robot.q_min, *(b.lower for b in self._positions)], axis=0),
            np.min([self.robot.q_max, *(b.upper for b in self._positions)], axis=0),
            limits,
            self.solver,
            others,
            self._program(displacement, others, targets, limits) if others else None,
        )

    def _targets(self) -> list[Task]:
        """Return the tasks to reach: all but postures, unless there are no others."""
        return [t for t in self.tasks if not isinstance(t, JointTask)] or self.tasks

    def _program(
        self,
        unknown: Unknown,
        weighted: tuple[Task, ...],
        exact: tuple[Task, ...],
        limits: LimitSet,
    ) -> VelocityProgram | CompiledVelocityProgram:
        """Return the program of this structure, from a cache."""
        key = (unknown, weighted, exact, limits, self.damping)
        found = self._programs.get(key)
        if found is None:
            if len(self._programs) >= 8:
                self._programs.clear()
            layout = VelocityProblemLayout(
                self.robot, weighted, exact, limits, self._columns, unknown, self.damping
            )
            if load_qp_kernels():
                from wbc.ik.compiled_program import CompiledVelocityProgram

                found = CompiledVelocityProgram(layout)
            else:
                found = VelocityProgram(layout)
            self._programs[key] = found
        return found

    def _prioritized_program(self) -> PrioritizedVelocityProgram:
        """Return the program of the present levels, from a cache."""
        if not load_qp_kernels():
            raise InverseKinematicsError("strict priorities need Numba; run  pip install numba")
        from wbc.ik.prioritized_program import PrioritizedVelocityProgram

        priorities = tuple([task.priority for task in self.tasks])
        key = (tuple(self.tasks), priorities, self._limit_set, self.damping)
        found = self._prioritized.get(key)
        if found is None:
            if len(self._prioritized) >= 8:
                self._prioritized.clear()
            order = PriorityOrder.sort(self.tasks, (), self._limit_set)
            last = tuple([task for task in order.last if isinstance(task, Task)])
            layout = VelocityProblemLayout(
                self.robot,
                last,
                order.exact,
                self._limit_set,
                self._columns,
                Unknown.VELOCITY,
                self.damping,
            )
            found = self._prioritized[key] = PrioritizedVelocityProgram(layout, order)
        return found

    def _solver_of(self, problem: Problem) -> Solver:
        """Return the solver of a problem, which for levels is the library's own."""
        if problem.levels is None:
            return self.solver
        if self._level_solver is None:
            from wbc.qp.solvers.hierarchical import HierarchicalSolver

            self._level_solver = HierarchicalSolver()
        return self._level_solver

    def _solve(self, problem: Problem) -> np.ndarray:
        if not problem.finite:
            assert self.kinematics is not None
            raise non_finite_error(self.kinematics, self.tasks, self._limit_set)
        solution = self._solver_of(problem).solve(problem)
        if solution.outcome is Outcome.INFEASIBLE:
            barriers = self._limit_set.barriers
            if barriers and load_qp_kernels():
                relaxed = relaxed_problem(problem, barriers)
                solution = self._solver_of(relaxed).solve(relaxed)
        x = np.asarray(solution.x)
        solved = solution.outcome is Outcome.SOLVED and x.shape == problem.g.shape
        if solved and math.isfinite(x.dot(x)):
            return x
        raise NoSolutionFound(explain(problem) or f"the solver gave up ({solution.detail})")

    def _checked_velocity(self, v: np.ndarray) -> np.ndarray:
        v = np.asarray(v, dtype=float)
        if v.shape != (self.robot.nv,) or not math.isfinite(v.dot(v)):
            raise InverseKinematicsError(
                f"v of shape {v.shape} must be ({self.robot.nv},) finite numbers"
            )
        return v


def _columns(robot: RobotModel, joints: Sequence[str] | None) -> np.ndarray:
    """Return the indices into nv of the coordinates that move: joints from the last, then the base.

    Legs come first in most trees: so the rows of standing feet begin with zeros, which the solver
    skips.
    """
    if joints is None:
        names = list(robot.joint_names)
        base = not isinstance(robot, FixedBaseRobot)
    else:
        names = [name for name in joints if name != BASE]
        base = len(names) < len(joints)
        if base and isinstance(robot, FixedBaseRobot):
            raise InverseKinematicsError(f"the base of '{robot.name}' is fixed; leave '{BASE}' out")
    moving = sorted({6 + robot.joint_index(name) for name in names}, reverse=True)
    if not moving and not base:
        raise InverseKinematicsError("no joint may move: joints is empty")
    return np.array([*moving, *(range(6) if base else ())], dtype=int)
