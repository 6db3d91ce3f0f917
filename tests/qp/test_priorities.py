"""Strict priorities: every level is optimal among the optima of the levels before it."""

import copy
import pickle

import numpy as np
import pytest
from coretools import CONTACT_SETS, contact_set, few, hand, random_state, robot, standing_state
from hypothesis import given
from hypothesis import strategies as st
from level_problems import Shape, cost_of, random_problem, rows_of_level, stationarity

import wbc
from wbc.command import Status
from wbc.errors import LimitError, TaskError, WbcError
from wbc.limits import Limit
from wbc.qp import Outcome
from wbc.qp.solvers.hierarchical import HierarchicalSolver

SHAPES = (
    Shape(),
    Shape(levels=(3,), soft=0),
    Shape(levels=(6, 6), rows=20),
    Shape(levels=(2, 3, 3, 2)),
    Shape(levels=(9, 9), soft=6),
    Shape(unknowns=30, rows=60, levels=(6, 9, 6), bounded=10, soft=8),
)


@pytest.mark.parametrize("degenerate", [False, True])
@pytest.mark.parametrize("shape", SHAPES)
def test_each_level_fulfils_the_optimality_conditions(shape, degenerate):
    for seed in range(8):
        problem = random_problem(seed, shape, degenerate=degenerate)
        solution = HierarchicalSolver().solve(problem)
        assert solution.outcome is Outcome.SOLVED, solution.detail
        exact = problem.levels.level == 0
        assert problem.violation(solution.x)[exact].max() < 1e-8
        assert max(stationarity(problem, solution.x)) < 1e-8, seed


@pytest.mark.parametrize("shape", SHAPES)
def test_a_lower_level_never_worsens_a_higher_one(shape):
    for seed in range(8):
        problem = random_problem(seed, shape, degenerate=seed % 2 == 1)
        solver = HierarchicalSolver()
        before = solver.solve(problem).x
        other = random_problem(1000 + seed, shape)
        last = len(shape.levels)
        for k in range(last, 0, -1):  # the levels from k on ask for something else
            if k < last:
                rows_of_level(problem, k + 1)[:] = rows_of_level(other, k + 1)
            problem.H[:], problem.g[:] = other.H, 10.0 * other.g
            after = solver.solve(problem)
            assert after.outcome is Outcome.SOLVED
            for j in range(1, k + 1):
                kept, now = cost_of(problem, j, before), cost_of(problem, j, after.x)
                assert now == pytest.approx(kept, rel=1e-8, abs=1e-8)


def test_a_warm_start_changes_nothing():
    warm = HierarchicalSolver()
    problem, target = random_problem(3, SHAPES[-1]), random_problem(4, SHAPES[-1])
    for _ in range(30):
        problem.levels.G[:, -1] += 0.05 * target.levels.G[:, -1]
        problem.g += 0.05 * target.g
        cold = HierarchicalSolver().solve(problem)
        np.testing.assert_allclose(warm.solve(problem).x, cold.x, atol=1e-7)


def test_exact_rows_that_exclude_each_other_are_infeasible_and_others_are_not():
    problem = random_problem(0, Shape())
    solver = HierarchicalSolver()
    row = problem.bounded
    problem.C[row + 1] = problem.C[row]
    problem.equality[row + problem.bounded] = False
    problem.lb[problem.bounded + row + 1] = problem.ub[problem.bounded + row] + 1.0
    problem.ub[problem.bounded + row + 1] = np.inf
    assert solver.solve(problem).outcome is Outcome.INFEASIBLE
    problem.levels.level[problem.bounded + row + 1] = 2
    assert solver.solve(problem).outcome is Outcome.SOLVED


def stack(
    bot: wbc.Robot,
    contacts: str = "both",
    priorities: tuple[int, ...] = (1, 2, 3),
    formulation: wbc.Formulation | None = None,
) -> wbc.WholeBodyController:
    """CoM, then trunk and hand, then angular momentum and posture."""
    control = wbc.WholeBodyController(bot, formulation=formulation)
    control.add(wbc.ComTask(weight=1000.0, priority=priorities[0]))
    control.add(wbc.OrientationTask(bot.torso, weight=20.0, priority=priorities[1]))
    control.add(wbc.PositionTask(hand(bot), priority=priorities[1], name="hand"))
    control.add(wbc.AngularMomentumTask(weight=0.01, priority=priorities[2]))
    control.add(wbc.PostureTask(bot, weight=0.3, priority=priorities[2]))
    control.set_contacts(contact_set(bot, contacts))
    return control


@few
@given(st.sampled_from(("talos", "g1")), st.sampled_from(CONTACT_SETS[1:]), st.integers(0, 99))
def test_formulations_agree_and_every_level_is_optimal(name, contacts, seed):
    bot = robot(name)
    state = standing_state(bot, seed)
    commands = []
    for formulation in (wbc.Formulation.COMPILED, wbc.Formulation.REDUCED):
        control = stack(bot, contacts, formulation=formulation)
        commands.append(control.step(state))
        assert commands[-1].status is Status.OK, commands[-1].explanation
    np.testing.assert_allclose(commands[0].tau, commands[1].tau, atol=1e-6)
    x = control._level_solver.solve(control.problem).x
    assert max(stationarity(control.problem, x)) < 1e-7


@pytest.mark.parametrize("contacts", CONTACT_SETS[1:])
@pytest.mark.parametrize("name", ["talos", "g1"])
@pytest.mark.parametrize("one_level_each", [False, True])
def test_a_humanoid_has_the_same_optimum_whatever_the_start(name, contacts, one_level_each):
    bot = robot(name)
    warm = HierarchicalSolver()
    for seed in range(3):
        control = stack(bot, contacts, (1, 2, 3))
        if one_level_each:
            for k, task in enumerate(control.tasks):
                task.priority = k + 1
        control.step(standing_state(bot, seed))
        problem, solver = control.problem, HierarchicalSolver()
        cold = solver.solve(problem).x
        assert max(stationarity(problem, cold)) < 1e-8
        for x in (solver.solve(problem).x, warm.solve(problem).x):
            np.testing.assert_allclose(x, cold, atol=1e-6 * (1.0 + np.abs(cold).max()))


def test_the_formulation_with_all_unknowns_has_the_same_solution():
    bot = robot("talos")
    state = standing_state(bot, 1)
    taus = [
        stack(bot, "left", formulation=f).step(state).tau
        for f in (wbc.Formulation.COMPILED, wbc.Formulation.FULL)
    ]
    np.testing.assert_allclose(taus[0], taus[1], atol=1e-5)


def test_one_level_of_any_number_is_the_weighted_problem():
    bot = robot("talos")
    state = standing_state(bot, 2)
    commands = [stack(bot, priorities=p).step(state) for p in ((1, 1, 1), (7, 7, 7))]
    np.testing.assert_array_equal(commands[0].tau, commands[1].tau)


def residual_of(control: wbc.WholeBodyController, command: wbc.Command, k: int) -> np.ndarray:
    task = control.tasks[k]
    A, b = np.zeros((task.size, control.robot.nv)), np.zeros(task.size)
    task.write(control.kinematics, A, b)
    return np.asarray(A @ command.acceleration - b)


def test_an_excessive_lower_task_leaves_the_higher_ones_as_they_are():
    bot = robot("talos")
    state = standing_state(bot, 5)
    control = stack(bot)
    calm = residual_of(control, control.step(state), 0)
    control.tasks[2].acceleration[:] = (500.0, -300.0, 200.0)
    wild = control.step(state)
    assert wild.status is Status.OK
    np.testing.assert_allclose(residual_of(control, wild, 0), calm, atol=1e-8)
    assert np.abs(residual_of(control, wild, 2)).max() > 10.0  # which the limits do not allow
    weighted = stack(bot, priorities=(1, 1, 1))
    weighted.step(state)
    weighted.tasks[2].acceleration[:] = (500.0, -300.0, 200.0)
    gone = residual_of(weighted, weighted.step(state), 0)
    assert np.abs(gone - calm).max() > 0.1


def test_far_from_standing_no_level_fails():
    bot = robot("talos")
    for seed in range(10):
        command = stack(bot, "both soft").step(random_state(bot, seed))
        assert command.status is not Status.FAILED, command.explanation


class ComHeightLimit(Limit):
    """The centre of mass accelerates upwards at least so much."""

    def __init__(self, least: float, priority: int) -> None:
        super().__init__("com rises", 1, unit="m/s²", priority=priority, weight=2.0)
        self.least = least

    def write(self, kin, rows):
        rows.A[0] = kin.J_com[2]
        rows.lower[0] = self.least - kin.bias_com[2]


@pytest.mark.parametrize("formulation", [wbc.Formulation.COMPILED, wbc.Formulation.REDUCED])
def test_a_limit_of_a_level_yields_to_higher_and_overrules_lower_ones(formulation):
    bot = robot("talos")
    state = standing_state(bot, 1)

    def rise(*priorities: int) -> float:
        control = stack(bot, priorities=(2, 2, 2), formulation=formulation)
        limits = [ComHeightLimit(1.0, priority) for priority in priorities]
        control.set_limits((*control.limits, *limits))
        command = control.step(state)
        assert command.status is Status.OK, command.explanation
        kin = control.kinematics
        return float(kin.J_com[2] @ command.acceleration + kin.bias_com[2])

    free = rise()
    # The tasks leave several directions to lower levels, but not the height.
    assert rise(3) == pytest.approx(free, abs=1e-4)
    assert rise(0) == pytest.approx(1.0, abs=1e-7)
    assert rise(1) == pytest.approx(1.0, abs=1e-7)
    assert free < rise(2) < 1.0


def test_conflicting_exact_tasks_are_named_and_the_levels_are_not_blamed():
    bot = robot("talos")
    control = stack(bot)
    for k, name in enumerate(("here", "there")):
        task = control.add(wbc.ComTask(priority=0, name=name))
        task.acceleration[:] = (0.1 * k, 0.0, 0.0)
    command = control.step(standing_state(bot, 1))
    assert command.status is Status.INFEASIBLE
    assert "here" in command.explanation
    assert "there" in command.explanation
    assert "hand" not in command.explanation


def test_a_nan_on_an_upper_level_gives_a_safe_command_that_names_it():
    bot = robot("talos")
    control = stack(bot)
    control.step(bot.standing())
    control.tasks[0].velocity[0] = np.nan
    command = control.step(bot.standing())
    assert command.status is Status.FAILED
    assert np.isfinite(command.tau).all()
    assert "task 'com'" in command.explanation


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda c: pickle.loads(pickle.dumps(c))])
def test_a_copied_controller_goes_on_alike(copied):
    bot = robot("talos")
    control = stack(bot)
    for seed in range(3):
        control.step(standing_state(bot, seed))
    twin = copied(control)
    for seed in range(3, 6):
        state = standing_state(bot, seed)
        np.testing.assert_array_equal(control.step(state).tau, twin.step(state).tau)


@pytest.mark.parametrize("priority", [-1, 1.5, True, "high", None])
def test_a_priority_that_is_no_level_is_refused(priority):
    with pytest.raises(TaskError, match=r"task 'com': priority .* whole number"):
        wbc.ComTask(priority=priority)
    with pytest.raises(LimitError, match=r"limit 'com rises': priority .* whole number"):
        ComHeightLimit(0.0, priority)
    control = wbc.WholeBodyController(robot("talos"))
    control.add(wbc.ComTask()).priority = priority
    with pytest.raises(TaskError, match="task 'com': priority"):
        control.step(robot("talos").standing())


def test_a_weight_of_a_limit_must_be_positive():
    with pytest.raises(LimitError, match=r"limit 'x': weight 0\.0"):
        type("AnyLimit", (Limit,), {"write": lambda *_: None})("x", 1, unit="m", weight=0.0)


def test_a_problem_without_levels_is_refused():
    problem = random_problem(0, Shape())
    problem.levels = None
    with pytest.raises(WbcError, match="no levels"):
        HierarchicalSolver().solve(problem)
