"""The whole-body controller: one QP per tick from tasks, contacts and limits to torques."""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from dataclasses import astuple, replace
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from wbc.command import Command, Status
from wbc.contacts import Contact
from wbc.errors import ContactError, WbcError, short_repr
from wbc.kinematics import Kinematics
from wbc.limits import (
    AnyLimit,
    JointPositionLimit,
    JointVelocityLimit,
    LimitSet,
    TorqueLimit,
)
from wbc.qp import (
    Assembly,
    Formulation,
    Outcome,
    Problem,
    Regularisation,
    Solution,
    Solver,
    TickExplanation,
    explain,
    explain_solution,
    find_conflict,
    load_qp_kernels,
    non_finite_rows,
    resolve_solver,
)
from wbc.qp.inputs import ProgramInputs, pack_inputs
from wbc.qp.relaxation import relaxation_text, relaxed_problem
from wbc.robot import Robot, checked_robot
from wbc.state import State
from wbc.tasks import Task, TaskCollection

if TYPE_CHECKING:
    from wbc.qp.compiled import CompiledAssembly

TaskT = TypeVar("TaskT", bound=Task)

_priority = operator.attrgetter("priority")
_FADE_TIME = 0.1  # s, how fast the torque of the last good tick fades after a failure
_SAFE_DAMPING = 0.05  # share of the torque limit per rad/s
_EXPLANATION_PERIOD = 0.1  # s
_MAX_ASSEMBLIES = 32
_COUPLING_KP = 2500.0  # 1/s²


class _LastTick(NamedTuple):
    """What is left of a tick until the next one."""

    command: Command
    assembly: Assembly | CompiledAssembly
    kinematics: Kinematics
    x: np.ndarray | None  # the solution


class WholeBodyController(TaskCollection):
    """Inverse-dynamics control by a quadratic program.

    Each tick solves, over the acceleration v̇, contact forces f and torques τ,

        min  ½ Σ_tasks ‖A v̇ − b‖²_w + small costs
        s.t. M v̇ + h = Sᵀ τ + Jᵀ f,   contacts' motion,   f in the contacts' cones,
             limits on τ and q̈,   exact tasks A v̇ = b,

    level by level when tasks or limits have different priorities (see `wbc.Task`); the small
    costs then belong to the last level, and soft contacts to the first. It does so in fewer
    unknowns (see `wbc.qp.elimination`). When there is no solution, the command holds the last
    good torques, fading within 0.1 s, plus joint damping of 5 % of the torque limit per rad/s,
    clipped to the limits; `status` tells it and `explanation`
    names the rows in conflict.

    Args:
        robot: the robot.
        dt: control period, s.
        solver: "wbc", "daqp", "osqp" or any solver of `qpsolvers` by its name, or an
            object of your own (see `wbc.qp.Solver`); the fastest that this machine can run when
            left out. Problems with several levels are always solved by the library's own
            solver, `wbc.qp.solvers.hierarchical`.
        limits: inequalities that hold exactly; torque, position and velocity limits of the
            robot when left out. See `set_limits`.
        formulation: which unknowns, and who assembles; the same optimum. The fastest that
            this machine can run when left out.
        regularisation: small costs that make the optimum unique.

    Attributes:
        tasks: those added, in order; first the couplings of the robot's joints, if it has any.
        kinematics: kinematics of the last state; None before the first tick.
        problem: the last tick's QP; its arrays are overwritten by the next one.

    Raises:
        WbcError: dt is not positive, the base of the robot is fixed, or the solver has no
            method `solve`.
        LimitError: see `set_limits`.
        SolverNotFound: the solver is unknown or not installed.
    """

    robot: Robot

    def __init__(
        self,
        robot: Robot,
        dt: float = 0.002,
        *,
        solver: str | Solver | None = None,
        limits: Sequence[AnyLimit] | None = None,
        formulation: Formulation | None = None,
        regularisation: Regularisation | None = None,
    ) -> None:
        if not 0.0 < dt < math.inf:
            raise WbcError(f"dt = {dt} must be positive: it is the control period in seconds")
        super().__init__(checked_robot(robot, "WholeBodyController"), _COUPLING_KP)
        self.dt = dt
        self.solver = resolve_solver(solver)
        if limits is None:
            limits = (TorqueLimit(robot), JointPositionLimit(robot), JointVelocityLimit(robot))
        self.set_limits(limits)
        if formulation is None:
            formulation = Formulation.COMPILED if load_qp_kernels() else Formulation.REDUCED
        elif formulation is Formulation.COMPILED and not load_qp_kernels():
            raise WbcError("Formulation.COMPILED needs Numba; run  pip install numba")
        self.formulation = formulation
        self.regularisation = regularisation or Regularisation()
        self.kinematics: Kinematics | None = None
        self.problem: Problem | None = None
        self._contacts: tuple[Contact, ...] = ()
        self._assemblies: dict[tuple[object, ...], Assembly | CompiledAssembly] = {}
        self._inputs: dict[Assembly | CompiledAssembly, ProgramInputs] = {}
        self._last_tau = np.zeros(robot.na)
        self._tick = 0
        self._level_solver: Solver | None = None
        self._relaxed = False
        self._last: _LastTick | None = None
        self._explanation: tuple[Outcome, int, Status, str] | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Return everything but the assemblies, which refer to memory and are made again."""
        return {**self.__dict__, "_assemblies": {}, "_inputs": {}, "_last": None}

    def __repr__(self) -> str:
        tasks = ", ".join(task.name for task in self.tasks) or "none"
        contacts = ", ".join(contact.name for contact in self._contacts) or "none"
        return (
            f"WholeBodyController('{self.robot.name}', dt {self.dt:g} s, tasks: {tasks}; "
            f"contacts: {contacts})"
        )

    def add(self, task: TaskT) -> TaskT:
        """Add a task and return it; see `wbc.tasks.TaskCollection.add`."""
        added = super().add(task)
        if task.priority > 1:
            self._priority_solver()  # compiles now, not in a tick
        return added

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """The contacts; set them here or by `set_contacts`."""
        return self._contacts

    @contacts.setter
    def contacts(self, contacts: Sequence[Contact]) -> None:
        self.set_contacts(contacts)

    def set_contacts(self, contacts: Sequence[Contact]) -> None:
        """Replace the contacts; no contact at all is free fall.

        The first exact surface contact carries the elimination: list the most loaded
        foot first.

        Raises:
            FrameNotFound: a contact's frame is missing.
            ContactError: something that is no contact, two contacts of one name, or a cone of
                the wrong shape.
        """
        if isinstance(contacts, Contact):
            raise ContactError(
                f"set_contacts takes a list of all contacts; write set_contacts([{contacts.name}])"
            )
        if not isinstance(contacts, Sequence):
            raise ContactError(f"{short_repr(contacts)} is no list of contacts")
        for contact in contacts:
            if not isinstance(contact, Contact):
                raise ContactError(
                    f"{short_repr(contact)} is no contact: give objects such as "
                    "wbc.SurfaceContact or ones derived from wbc.Contact"
                )
        contacts = tuple(contacts)
        if len({c.name for c in contacts}) < len(contacts):
            names = ", ".join(f"'{c.name}'" for c in contacts)
            raise ContactError(
                f"two contacts have the same name: {names}; give one another by name=…"
            )
        for contact in contacts:
            contact.bind(self.robot)
        self._contacts = contacts

    @property
    def limits(self) -> tuple[AnyLimit, ...]:
        """The limits; set them by `set_limits`."""
        return self._limits

    def set_limits(self, limits: Sequence[AnyLimit]) -> None:
        """Replace the limits, e.g. by `(*controller.limits, MyLimit())`.

        Raises:
            LimitError: something that is no limit, two torque limits, two general limits of one
                name, or a limit whose horizon is shorter than the control period.
        """
        self._limit_set = LimitSet.sort(limits, self.robot, self.dt)
        self._limits = tuple(limits)

    def step(self, state: State) -> Command:
        """Return the command of one tick.

        Raises:
            StateError: it is no `State`, or has a wrong size, a NaN or a non-unit quaternion.
        """
        if self.kinematics is None:
            self.kinematics = Kinematics(self.robot, state)
        else:
            self.kinematics.update(state)
        return self.solve(self.kinematics)

    def solve(self, kin: Kinematics) -> Command:
        """Return the command of one tick, from kinematics that were computed already."""
        self._tick += 1
        assembly = self._assembly()
        problem = self.problem = assembly.build(kin)
        command, x = self._solve(problem, assembly, kin)
        self._last = _LastTick(command, assembly, kin, x)
        return command

    def _solve(
        self, problem: Problem, assembly: Assembly | CompiledAssembly, kin: Kinematics
    ) -> tuple[Command, np.ndarray | None]:
        """Return the command, and the solution where there is one."""
        if not problem.finite:
            reason = non_finite_rows(kin, self.tasks, self._contacts, self._limit_set)
            return self._safe_command(kin, Status.FAILED, reason or "the QP is not finite"), None
        solution, text = self._solution(problem)
        if solution.outcome is Outcome.SOLVED:
            x = np.asarray(solution.x)
            command = None
            if x.shape == problem.g.shape:
                command = assembly.recover(x, kin, self.dt, self)
            if command is not None:
                if text:
                    command = replace(command, explanation=text)
                self._last_tau = command.tau
                kin.previous_acceleration = command.acceleration
                self._explanation = None
                return command, x
            detail = f"x of shape {x.shape}, {x.size - np.isfinite(x).sum()} entries not finite"
            solution = Solution(x, Outcome.FAILED, detail=detail)
        return self._safe_command(kin, *self._explain(problem, solution)), None

    def _solution(self, problem: Problem) -> tuple[Solution, str]:
        """Return the solution, and which barriers give way in it.

        Once they had to, they may in the next tick, too: an infeasible solve takes long.
        """
        limits = self._limit_set
        if not (self._relaxed and limits.barriers):
            solver = self.solver if problem.levels is None else self._priority_solver()
            solution = solver.solve(problem)
            if solution.outcome is not Outcome.INFEASIBLE:
                return solution, ""
            if not limits.barriers or not load_qp_kernels():
                return solution, ""
        names = limits.barriers
        self._relaxed = False
        relaxed = relaxed_problem(problem, names)
        solution, text = self._priority_solver().solve(relaxed), ""
        if solution.outcome is Outcome.SOLVED:
            self.problem = relaxed
            text = relaxation_text(relaxed, solution.x, names)
            self._relaxed = bool(text)
        return solution, text

    def explain(self, command: Command) -> TickExplanation:
        """Explain the last command; see `Command.explain`, which calls this.

        Raises:
            WbcError: it is not the last command of this controller.
        """
        last, problem = self._last_tick(command)
        if last.x is None:
            conflict = find_conflict(problem) if problem.finite else ()
            return TickExplanation(command.explanation, conflict, (), ())
        assembly, kin = last.assembly, last.kinematics

        def acceleration_of(x: np.ndarray) -> np.ndarray:
            found = assembly.recover(x, kin, self.dt)
            return np.full(self.robot.nv, np.nan) if found is None else found.acceleration

        return explain_solution(problem, last.x, self.tasks, kin, acceleration_of)

    def packed_inputs(self, command: Command, words: int) -> np.ndarray:
        """Return what the QP of the last command was made of beside the state.

        `wbc.recorded_tick` makes of it a controller that solves the tick again.

        Args:
            command: the last command.
            words: size of the result.

        Returns:
            (words,) see `wbc.qp.inputs.ProgramInputs`; overwritten by the next call.

        Raises:
            WbcError: it is not the last command of this controller.
        """
        last, problem = self._last_tick(command)
        if self.formulation is not Formulation.COMPILED:
            missing = f"only Formulation.COMPILED is recorded, not {self.formulation}"
            return pack_inputs({"missing": missing}, np.empty(0), words)
        inputs = self._inputs.get(last.assembly)
        if inputs is None:
            inputs = self._inputs[last.assembly] = self._new_inputs(last.assembly)
        return inputs.pack(words, self._working_set(problem))

    def _working_set(self, problem: Problem) -> np.ndarray:
        """Return from where the solver solves the tick again to the same bits."""
        solver = self.solver if problem.levels is None else self._priority_solver()
        working_set = getattr(solver, "working_set", None)
        if working_set is None:
            return np.empty(0)
        return np.asarray(working_set(problem))

    def start_from(self, working_set: np.ndarray) -> None:
        """Start the first solve from the working set of a recorded tick."""
        for solver in (self.solver, self._level_solver):
            start = getattr(solver, "start_from", None)
            if start is not None:
                start(working_set)

    def _new_inputs(self, assembly: Any) -> ProgramInputs:
        settings = {
            "dt": self.dt,
            "solver": getattr(self.solver, "name", type(self.solver).__name__),
            "regularisation": astuple(self.regularisation),
        }
        parts = (self.robot, self.tasks, self._contacts, self._limits)
        return ProgramInputs(*parts, assembly.written, assembly.memory, settings)

    def _last_tick(self, command: Command) -> tuple[_LastTick, Problem]:
        last = self._last
        if last is None or last.command is not command or self.problem is None:
            raise WbcError(
                "this command cannot be explained any more: its controller has gone on to the "
                "next tick; explain a command before the next step, or look it up in a log"
            )
        return last, self.problem

    def _priority_solver(self) -> Solver:
        """Return the solver of strict priorities, made when it is first needed."""
        if self._level_solver is None:
            if not load_qp_kernels():
                raise WbcError("strict priorities need Numba; run  pip install numba")
            from wbc.qp.solvers.hierarchical import HierarchicalSolver

            self._level_solver = HierarchicalSolver()
        return self._level_solver

    def _explain(self, problem: Problem, solution: Solution) -> tuple[Status, str]:
        """Return status and reason of a failure; a search takes long, so at most one per 0.1 s."""
        cached = self._explanation
        if cached is None or cached[0] != solution.outcome or self._tick >= cached[1]:
            reason = explain(problem)
            status = Status.INFEASIBLE
            if not reason and solution.outcome is Outcome.INFEASIBLE:
                reason = f"the solver finds no point that holds all rows ({solution.detail})"
            elif not reason:
                status = Status.FAILED
                reason = f"the solver gave up ({solution.detail}); the rows can hold together"
            until = self._tick + round(_EXPLANATION_PERIOD / self.dt)
            cached = self._explanation = (solution.outcome, until, status, reason)
        return cached[2], cached[3]

    def _assembly(self) -> Assembly | CompiledAssembly:
        """Return the assembly of this structure; a gait comes back to each, so they are cached."""
        key = (
            tuple(self.tasks),
            tuple(map(_priority, self.tasks)),
            self._contacts,
            tuple([contact.motion_weight is None for contact in self._contacts]),
            self._limit_set,
            id(self.formulation),  # hashing these two takes longer than all the rest;
            id(self.regularisation),  # the assembly keeps them alive
        )
        found = self._assemblies.get(key)
        if found is None:
            if (
                len(self._assemblies) >= _MAX_ASSEMBLIES
            ):  # new contact objects in each tick must not fill the memory
                self._assemblies.clear()
                self._inputs.clear()
            found = self._assemblies[key] = self._new_assembly()
        return found

    def _new_assembly(self) -> Assembly | CompiledAssembly:
        parts = (self.robot, self.tasks, self._contacts, self._limit_set)
        if self.formulation is Formulation.COMPILED:
            from wbc.qp.compiled import CompiledAssembly

            return CompiledAssembly(*parts, self.regularisation)
        return Assembly(*parts, self.formulation, self.regularisation)

    def _safe_command(self, kin: Kinematics, status: Status, reason: str) -> Command:
        self._last_tau = self._last_tau * (1.0 - min(self.dt / _FADE_TIME, 1.0))
        limit = self.robot.tau_max
        tau = self._last_tau - _SAFE_DAMPING * limit * kin.state.v[6:]
        if self._limit_set.torque is not None:
            limit = np.minimum(limit, self._limit_set.torque.maximum)
        tau = np.clip(tau, -limit, limit)
        wrenches = {c.name: np.zeros(6) for c in self._contacts}
        q, v = kin.state.q[7:], kin.state.v[6:]
        still = np.zeros(self.robot.nv)
        return Command(tau, still, wrenches, q + self.dt * v, v.copy(), status, reason, self)
