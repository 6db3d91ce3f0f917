"""Search for a posture that reaches targets: Levenberg-Marquardt steps within limits, restarts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from wbc.ik.configuration_kinematics import ConfigurationKinematics
from wbc.ik.velocity_program import non_finite_error, postures_last, weighted_squares
from wbc.limits import LimitSet
from wbc.qp import Outcome, Problem, Solver
from wbc.robot import RobotModel
from wbc.tasks import Task

if TYPE_CHECKING:
    from wbc.ik.compiled_program import CompiledVelocityProgram
    from wbc.ik.velocity_program import VelocityProgram

_MIN_DAMPING, _MAX_DAMPING = 1e-12, 1e3
_FIRST_DAMPING = 1e-2  # of the largest diagonal entry of H
_ITERATIONS = 60  # of one attempt
_PATIENCE, _PROGRESS = 6, 0.7  # an attempt ends unless the error falls by that factor in as many
_TURN = np.pi  # rad: range of a joint without limits, for random starts
_ACTIVE = 1e-9  # m, rad: a bound this near is met
_MAX_NAMES = 3
_PENALTY = 10.0  # of a squared violation of a general limit, against the largest weight
_EXPLANATION_DAMPING = 1e-6
_IMPROVEMENTS = 30
_LARGEST_STEP, _SMALLEST_STEP, _SMALLEST_SHARE = 0.3, 1e-4, 0.05  # rad, rad, of a step


@dataclass(frozen=True)
class ReachSolution:
    """The posture that came nearest to the targets.

    Attributes:
        q: (nq,) configuration.
        reached: whether every row of every target is within the tolerance.
        errors: task name -> (m,) target minus what was reached, in the units of the task's
            position: m, rad.
        attempts: number of starts.
        iterations: number of steps, of all attempts.
        explanation: what was missed, by how much, and which limits are in the way; empty when
            all targets were reached.
    """

    q: np.ndarray
    reached: bool
    errors: Mapping[str, np.ndarray]
    attempts: int
    iterations: int
    explanation: str

    def __repr__(self) -> str:
        return f"ReachSolution({'reached' if self.reached else self.explanation})"


@dataclass
class _Best:
    """The best posture of an attempt."""

    q: np.ndarray
    cost: float
    errors: np.ndarray
    violation: float  # of a general limit, m or rad


class ReachSearch:
    """Searches for a posture at which the errors of tasks vanish.

    Each step solves `min ½ Σ w |e − J δ|² + ½ λ |δ|²` within the limits' displacements δ
    (Levenberg-Marquardt; λ falls after a step that lowers the error and rises after one that does
    not). An attempt that gets stuck in a local minimum is followed by one from a random posture
    (as in Beeson and Ames, TRAC-IK, Humanoids 2015).

    Args:
        robot: the robot.
        program: displacements with the targets as weighted tasks.
        targets: the tasks.
        columns: (n,) coordinates that move.
        lower, upper: (na,) range of the joints, rad or m.
        limits: those that hold at every posture.
        solver: QP solver.
        others: tasks that improve what the targets leave open.
        secondary: displacements with the others as weighted tasks and the targets as exact ones;
            None without others.
    """

    def __init__(
        self,
        robot: RobotModel,
        program: VelocityProgram | CompiledVelocityProgram,
        targets: Sequence[Task],
        columns: np.ndarray,
        lower: np.ndarray,
        upper: np.ndarray,
        limits: LimitSet,
        solver: Solver,
        others: Sequence[Task] = (),
        secondary: VelocityProgram | CompiledVelocityProgram | None = None,
    ) -> None:
        self._robot, self._program = robot, program
        self._targets = postures_last(targets)
        self._others, self._secondary = others, secondary
        self._columns, self._limits, self._solver = columns, limits, solver
        self._joints = columns[columns >= 6] - 6
        self._lower, self._upper = lower[self._joints], upper[self._joints]
        self._weights = np.concatenate([task.weight for task in self._targets])
        self._rest = np.zeros(robot.na)
        self.iterations, self._tolerance = 0, 0.0

    def search(
        self,
        kin: ConfigurationKinematics,
        q: np.ndarray,
        restarts: int,
        seed: int,
        tolerance: float,
    ) -> ReachSolution:
        """Return the posture that comes nearest to the targets.

        Args:
            kin: kinematics to work with.
            q: (nq,) posture to start from; what does not move stays as in it.
            restarts: largest number of further attempts.
            seed: seed of their random postures.
            tolerance: largest error of a row that counts as reached, m and rad.

        Raises:
            NoSolutionFound: a task or limit is not finite.
        """
        self._tolerance = tolerance
        best = self._attempt(kin, q)
        attempts = 1
        random = np.random.default_rng(seed)
        while attempts <= restarts and not self._reached(best):
            other = self._attempt(kin, self._random_start(q, random))
            attempts += 1
            if other.cost < best.cost:
                best = other
        if self._secondary is not None and self._reached(best):
            best = self._improved(kin, best, self._secondary)
        return self._solution(kin, best, attempts)

    def describe(
        self,
        kin: ConfigurationKinematics,
        posture: ReachSolution,
        before: ReachSolution,
        tolerance: float,
    ) -> ReachSolution:
        """Return what a posture that was found for other targets means for these.

        Args:
            kin: kinematics to work with.
            posture: the posture.
            before: a search whose attempts and iterations count too.
            tolerance: see `search`.
        """
        self._tolerance = tolerance
        kin.set_configuration(posture.q)
        problem = self._build(self._program, kin)
        errors, violation = self._program.errors.copy(), self._violation(problem)
        best = _Best(posture.q, self._cost(errors, violation), errors, violation)
        self.iterations = before.iterations + posture.iterations
        return self._solution(kin, best, before.attempts + posture.attempts)

    def _build(
        self, program: VelocityProgram | CompiledVelocityProgram, kin: ConfigurationKinematics
    ) -> Problem:
        problem = program.build(kin, self._rest, 1.0)
        if not problem.finite:
            raise non_finite_error(kin, (*self._targets, *self._others), self._limits)
        return problem

    def _reached(self, best: _Best) -> bool:
        largest = float(np.abs(best.errors).max(initial=0.0))
        return max(largest, best.violation) <= self._tolerance

    def _random_start(self, q: np.ndarray, random: np.random.Generator) -> np.ndarray:
        start = q.copy()
        at = start[7 + self._joints]
        low = np.where(np.isfinite(self._lower), self._lower, at - _TURN)
        high = np.where(np.isfinite(self._upper), self._upper, at + _TURN)
        start[7 + self._joints] = random.uniform(low, high)
        return start

    def _attempt(self, kin: ConfigurationKinematics, start: np.ndarray) -> _Best:
        model, joints = self._robot.model, self._joints
        q = start.copy()
        q[7 + joints] = np.clip(q[7 + joints], self._lower, self._upper)
        kin.set_configuration(q)
        problem = self._build(self._program, kin)
        errors = self._program.errors.copy()
        violation = self._violation(problem)
        cost = self._cost(errors, violation)
        damping = _FIRST_DAMPING
        history = [cost]
        displacement = np.zeros(self._robot.nv)
        for _ in range(_ITERATIONS):
            if max(float(np.abs(errors).max(initial=0.0)), violation) <= self._tolerance:
                break
            self.iterations += 1
            x = self._step(problem, damping * max(cost, _MIN_DAMPING))
            if x is None:
                break
            displacement[self._columns] = x
            trial = pin.integrate(model, q, displacement)
            trial[7 + joints] = np.clip(trial[7 + joints], self._lower, self._upper)
            kin.set_configuration(trial)
            trial_problem = self._build(self._program, kin)
            trial_errors = self._program.errors
            trial_violation = self._violation(trial_problem)
            trial_cost = self._cost(trial_errors, trial_violation)
            if trial_cost < cost:
                violation = trial_violation
                q, cost, errors, problem = trial, trial_cost, trial_errors.copy(), trial_problem
                damping = max(0.2 * damping, _MIN_DAMPING)
            else:
                damping *= 8.0
                if damping > _MAX_DAMPING:
                    break
                kin.set_configuration(q)
                problem = self._build(self._program, kin)
            history.append(cost)
            stuck = len(history) > _PATIENCE
            if stuck and history[-1] > _PROGRESS * history[-1 - _PATIENCE]:
                break
        return _Best(q, cost, errors, violation)

    def _cost(self, errors: np.ndarray, violation: float) -> float:
        penalty = _PENALTY * self._weights.max() * violation * violation
        return float(errors.dot(self._weights * errors) + penalty)

    @staticmethod
    def _violation(problem: Problem) -> float:
        """Return by how much a posture violates a general limit: what a step must make good."""
        lower, upper = problem.lb[problem.bounded :], problem.ub[problem.bounded :]
        if not lower.size:
            return 0.0
        return max(float(lower.max()), float(-upper.min()), 0.0)

    def _step(self, problem: Problem, damping: float) -> np.ndarray | None:
        problem.H.flat[:: problem.g.size + 1] += damping
        solution = self._solver.solve(problem)
        return solution.x if solution.outcome is Outcome.SOLVED else None

    def _improved(
        self,
        kin: ConfigurationKinematics,
        best: _Best,
        secondary: VelocityProgram | CompiledVelocityProgram,
    ) -> _Best:
        """Return a posture that reaches the targets too and lowers the secondary tasks' cost.

        Steps along the targets' null space, each corrected and halved if it makes things worse.
        """
        displacement = np.zeros(self._robot.nv)
        share = 1.0
        for _ in range(_IMPROVEMENTS):
            kin.set_configuration(best.q)
            problem = self._build(secondary, kin)
            solution = self._solver.solve(problem)
            if solution.outcome is not Outcome.SOLVED:
                return best
            x, H, g = solution.x, problem.H, problem.g
            predicted = -float(g @ x + 0.5 * x @ H @ x)
            if float(np.abs(x).max()) < _SMALLEST_STEP or predicted <= 0.0:
                return best
            before = secondary.errors.copy()
            scale = min(share, _LARGEST_STEP / float(np.abs(x).max()))
            displacement[self._columns] = scale * x
            other = self._attempt(kin, pin.integrate(self._robot.model, best.q, displacement))
            kin.set_configuration(other.q)
            self._build(secondary, kin)
            cost = weighted_squares(self._others, secondary.errors)
            if self._reached(other) and cost < weighted_squares(self._others, before):
                best, share = other, min(1.0, 2.0 * share)
            else:
                share *= 0.5
                if share < _SMALLEST_SHARE:
                    return best
        return best

    def _solution(self, kin: ConfigurationKinematics, best: _Best, attempts: int) -> ReachSolution:
        errors, start = {}, 0
        for task in self._targets:
            errors[task.name] = best.errors[start : start + task.size].copy()
            start += task.size
        reached = self._reached(best)
        text = "" if reached else self._explanation(kin, best, errors)
        return ReachSolution(best.q, reached, errors, attempts, self.iterations, text)

    def _explanation(
        self, kin: ConfigurationKinematics, best: _Best, errors: Mapping[str, np.ndarray]
    ) -> str:
        missed = [
            format_miss(task, errors[task.name])
            for task in self._targets
            if float(np.abs(errors[task.name]).max()) > self._tolerance
        ]
        kin.set_configuration(best.q)
        problem = self._build(self._program, kin)
        held = self._limits_in_the_way(problem)
        why = f"held back by {', '.join(held)}" if held else "no limit is in the way: out of reach"
        return f"{'; '.join(missed)}; {why}"

    def _limits_in_the_way(self, problem: Problem) -> list[str]:
        """Return the names of the rows that a step towards the targets presses on, worst first.

        At the step's optimum `H x + g = Aᵀ λ` with multipliers λ of the rows A that it meets.
        """
        problem.H.flat[:: problem.g.size + 1] += _EXPLANATION_DAMPING
        solution = self._solver.solve(problem)
        if solution.outcome is not Outcome.SOLVED:
            return []
        x = solution.x
        values = problem.values(x)
        near = _ACTIVE * (1.0 + np.abs(values))
        active = np.flatnonzero((values <= problem.lb + near) | (values >= problem.ub - near))
        rows = np.vstack((np.eye(problem.bounded, x.size), problem.C))[active]
        force = problem.H @ x + problem.g
        if not active.size:
            return []
        multipliers = np.abs(np.linalg.lstsq(rows.T, force, rcond=None)[0])
        order = [k for k in np.argsort(-multipliers) if multipliers[k] > 1e-3 * multipliers.max()]
        names = []
        for k in order[:_MAX_NAMES]:
            row = int(active[k])
            block = next(b for b in problem.blocks if row < b.stop)
            names.append(block.label(row))
        return names


def format_miss(task: Task, error: np.ndarray) -> str:
    """Return by how much a target is missed, in mm, degrees or the task's own unit."""
    texts = []
    rest = error
    for unit in task.unit.split(", "):
        size = 3 if "," in task.unit else rest.size
        part, rest = rest[:size], rest[size:]
        length = float(np.linalg.norm(part))
        if unit.startswith("m/s"):
            texts.append(f"{1e3 * length:.3g} mm")
        elif unit.startswith("rad"):
            texts.append(f"{np.degrees(length):.3g}°")
        else:
            texts.append(f"{length:.3g}")
    return f"'{task.name}' misses its target by {' and '.join(texts)}"
