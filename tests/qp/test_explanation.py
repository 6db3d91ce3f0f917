"""When the QP has no solution the command is safe, and the rows in conflict are named."""

import re

import numpy as np
import pytest
from coretools import (
    contact_set,
    controller,
    few,
    many,
    robot,
    robots,
    seeds,
    sole_contact,
    standing_state,
)
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

import wbc
from wbc.command import Status
from wbc.errors import ContactError, TaskError
from wbc.qp import Outcome, Problem, Solution, Solver, explain
from wbc.qp.explanation import ElasticRows
from wbc.qp.rows import RowBlock


class GivingUp(Solver):
    """A solver that fails when told to."""

    name = "giving up"

    def __init__(self, inner: Solver) -> None:
        self.inner = inner
        self.result: Solution | None = None

    def solve(self, problem: Problem) -> Solution:
        return self.result or self.inner.solve(problem)


def assert_safe(command: wbc.Command, bot: wbc.Robot) -> None:
    for x in (command.tau, command.acceleration, command.q_target, command.v_target):
        assert np.isfinite(x).all()
    assert (np.abs(command.tau) <= bot.tau_max + 1e-12).all()
    assert all(np.isfinite(w).all() for w in command.wrenches.values())
    assert command.explanation


@pytest.mark.parametrize("formulation", list(wbc.Formulation))
@pytest.mark.parametrize("solver", ["daqp", "osqp"])
def test_explanation_names_torque_limits_that_an_exact_task_exceeds(formulation, solver):
    bot = robot("talos")
    limits = [wbc.TorqueLimit(bot)]
    control = controller(bot, "left", formulation=formulation, solver=solver, limits=limits)
    jump = control.add(wbc.ComTask(priority=0, name="jump"))
    jump.acceleration[2] = 200.0
    command = control.step(bot.standing())
    assert command.status is Status.INFEASIBLE
    assert "torque limit [leg_left_" in command.explanation
    assert "jump [" in command.explanation
    assert "N·m" in command.explanation
    assert_safe(command, bot)


def test_explanation_names_both_of_two_contradictory_exact_tasks():
    bot = robot("g1")
    control = controller(bot, "both")
    for name, a in (("up", 1.0), ("down", -1.0)):
        control.add(wbc.ComTask(priority=0, name=name)).acceleration[2] = a
    command = control.step(bot.standing())
    assert command.status is Status.INFEASIBLE
    assert "up [z] off by 1 m/s²" in command.explanation
    assert "down [z] off by 1 m/s²" in command.explanation
    assert "torque" not in command.explanation
    assert_safe(command, bot)


def test_explanation_names_a_contact_force_beyond_the_torque_limits():
    bot = robot("simple_humanoid")
    contact = sole_contact(bot, "left")
    contact.min_force = 1e5
    control = controller(bot, [contact])
    command = control.step(bot.standing())
    assert command.status is Status.INFEASIBLE
    assert "left_sole normal force [fz] below its minimum by" in command.explanation
    assert_safe(command, bot)


def test_explanation_names_bounds_that_exclude_each_other():
    bot = robot("simple_humanoid")
    control = controller(bot, "left exact, right soft")
    control.contacts[1].min_force, control.contacts[1].max_force = 50.0, 20.0
    command = control.step(bot.standing())
    assert command.status is Status.INFEASIBLE
    assert "right_sole normal force [fz] must be at least 50 and at most 20" in command.explanation
    assert_safe(command, bot)


@few
@given(robots, seeds, st.floats(0.01, 0.3))
def test_weak_motors_give_a_solution_or_an_explained_conflict(name, seed, strength):
    bot = robot(name)
    control = controller(bot, "left", limits=[wbc.TorqueLimit(bot, scale=strength)])
    heavy = control.add(wbc.ComTask(priority=0, name="hold the trunk up"))
    command = control.step(standing_state(bot, seed))
    assert heavy.target is not None
    if command.status is Status.OK:
        assert control.problem.violation(control.solver.solve(control.problem).x).max() < 1e-6
    else:
        assert command.status is Status.INFEASIBLE
        assert "torque limit [" in command.explanation
        assert_safe(command, bot)


def test_explanation_omits_rows_that_do_not_conflict():
    bot = robot("talos")
    control = controller(bot, "both")
    control.add(wbc.PositionTask(bot.torso, priority=0, name="bystander"))
    for name, a in (("up", 1.0), ("down", -1.0)):
        control.add(wbc.ComTask(priority=0, name=name)).acceleration[2] = a
    text = control.step(bot.standing()).explanation
    assert text.startswith("Infeasible: these constraints conflict — ")
    assert len(text.split("; ")) == 2
    assert "bystander" not in text


@many
@given(st.integers(2, 8), st.integers(1, 12), seeds)
def test_explanation_agrees_with_a_linear_program_on_feasibility(n, m, seed):
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, n, m)
    rows = np.vstack((np.eye(problem.bounded, n), problem.C))
    lp = linprog(
        np.zeros(n),
        A_ub=np.vstack((rows, -rows)),
        b_ub=np.concatenate((problem.ub, -problem.lb)),
        bounds=(None, None),
    )
    text = explain(problem)
    assert (lp.status == 0) == (text == ""), text


@many
@given(st.integers(2, 8), st.integers(2, 12), seeds)
def test_violations_of_an_infeasible_qp_certify_its_infeasibility(n, m, seed):
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, n, m)
    elastic = ElasticRows(problem)
    x, y = elastic.least_violation()
    np.testing.assert_allclose(np.abs(y) * elastic.norm, problem.violation(x), atol=1e-7)
    if np.abs(y).max() < 1e-6:
        return
    y /= np.abs(y).max()
    np.testing.assert_allclose(elastic.A.T @ y, 0.0, atol=1e-6)
    # y ≥ 0 on upper bounds and ≤ 0 on lower ones: 0 = yᵀ A x ≤ Σ y⁺ ub + y⁻ lb for any x that
    # holds the rows, so there is none when that sum is negative.
    lb, ub = problem.lb / elastic.norm, problem.ub / elastic.norm
    assert y[y > 0] @ ub[y > 0] + y[y < 0] @ lb[y < 0] < 0.0


def random_problem(rng: np.random.Generator, n: int, m: int) -> Problem:
    bounded = int(rng.integers(0, n + 1))
    middle = rng.standard_normal(bounded + m)
    width = np.abs(rng.standard_normal(bounded + m))
    equality = rng.random(bounded + m) < 0.2
    width[equality] = 0.0
    C = rng.standard_normal((m, n)) * 10.0 ** rng.uniform(-1, 2, (m, 1))
    blocks = (RowBlock("all", "", 0, bounded + m),)
    return Problem(
        np.eye(n), np.zeros(n), C, middle - width, middle + width, bounded, equality, blocks
    )


def test_failed_solves_give_fading_damping_torques_within_limits():
    bot = robot("talos")
    control = controller(bot, "both")
    state = standing_state(bot, 1, speed=0.3)
    good = control.step(state)
    control.solver = GivingUp(control.solver)
    control.solver.result = Solution(np.zeros(1), Outcome.FAILED, 7, "tired")
    taus = []
    for _ in range(100):
        command = control.step(state)
        assert command.status is Status.FAILED
        assert "the solver gave up (tired)" in command.explanation
        assert set(command.wrenches) == {"left_sole", "right_sole"}
        assert_safe(command, bot)
        taus.append(command.tau)
    damping = -0.05 * bot.tau_max * state.v[6:]
    np.testing.assert_allclose(taus[0], 0.98 * good.tau + damping, atol=1e-9)
    assert np.abs(taus[-1] - damping).max() < 0.2 * np.abs(good.tau).max()
    control.solver.result = None
    again = control.step(state)
    assert again.status is Status.OK
    np.testing.assert_allclose(again.tau, good.tau, atol=1e-6)


def test_a_solver_that_returns_nan_does_not_reach_the_motors():
    bot = robot("g1")
    control = controller(bot, "left")
    control.step(bot.standing())
    control.solver = GivingUp(control.solver)
    control.solver.result = Solution(np.full(control.problem.g.size, np.nan), Outcome.SOLVED)
    command = control.step(bot.standing())
    assert command.status is Status.FAILED
    assert "not finite" in command.explanation
    assert_safe(command, bot)


NAN = np.nan


@pytest.mark.parametrize(
    ("spoil", "culprit"),
    [
        (lambda c: c.tasks[0].target.__setitem__(1, NAN), "task 'com'.*target"),
        (lambda c: c.tasks[0].acceleration.__setitem__(0, np.inf), "task 'com'.*acceleration"),
        (lambda c: setattr(c.tasks[1], "target", np.full((3, 3), NAN)), "orientation'.*target"),
        (lambda c: c.tasks[2].rate.__setitem__(2, NAN), "task 'angular momentum'.*rate"),
        (lambda c: c.tasks[3].target.__setitem__(4, NAN), "task 'posture'.*target"),
        (lambda c: c.tasks[4].velocity.__setitem__(0, NAN), "task 'exact'.*velocity"),
        (lambda c: setattr(c.contacts[0], "damping", NAN), "contact 'left_sole'.*damping = nan"),
        (lambda c: setattr(c.contacts[1], "motion_weight", NAN), "'right_sole'.*motion_weight"),
        (lambda c: setattr(c.contacts[1], "motion_weight", -1.0), "contact 'right_sole'"),
        (lambda c: setattr(c.contacts[1], "max_force", NAN), "contact 'right_sole'.*max_force"),
    ],
)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_nan_in_a_task_or_contact_gives_a_safe_command_that_names_it(spoil, culprit):
    bot = robot("talos")
    control = controller(bot, "left exact, right soft")
    control.add(wbc.PositionTask(bot.torso, priority=0, name="exact"))
    state = standing_state(bot, 3)
    good = control.step(state)
    assert good.status is Status.OK
    spoil(control)
    command = control.step(state)
    assert command.status is Status.FAILED
    assert_safe(command, bot)
    assert re.search(culprit, command.explanation), command.explanation


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_controller_recovers_once_a_nan_target_is_corrected():
    bot = robot("talos")
    control = controller(bot, "both")
    state = standing_state(bot, 3)
    good = control.step(state)
    kept = control.tasks[0].target.copy()
    control.tasks[0].target[:] = NAN
    control.step(state)
    control.tasks[0].target = kept
    np.testing.assert_allclose(control.step(state).tau, good.tau, atol=1e-6)


@pytest.mark.parametrize(
    ("attribute", "value"),
    [("target", np.zeros(2)), ("velocity", np.zeros((3, 3))), ("acceleration", "fast")],
)
def test_an_attribute_of_the_wrong_shape_is_refused_with_task_and_attribute(attribute, value):
    bot = robot("talos")
    control = controller(bot, "both")
    control.step(bot.standing())
    setattr(control.tasks[0], attribute, value)
    with pytest.raises(TaskError, match=rf"task 'com' cannot write its rows.*{attribute}"):
        control.step(bot.standing())


def test_an_invalid_contact_attribute_is_refused_with_the_contacts_name():
    bot = robot("talos")
    control = controller(bot, contact_set(bot, "left"))
    control.contacts[0].damping = "much"
    with pytest.raises(ContactError, match="contact 'left_sole' cannot write its rows"):
        control.step(bot.standing())
