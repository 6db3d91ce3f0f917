"""A tick explains itself: what tasks got, which rows stood in their way, what one unit costs."""

import copy

import numpy as np
import pytest
from coretools import contact_set, hand, robot, standing_state
from level_problems import Shape, random_problem
from scipy.optimize import linprog

import wbc
from wbc.command import Status
from wbc.errors import WbcError
from wbc.qp.multipliers import LevelMultipliers
from wbc.qp.solvers.hierarchical import HierarchicalSolver


def reaching(priorities: tuple[int, int, int], lift: float = 30.0) -> wbc.WholeBodyController:
    """A controller whose hand is to rise faster than the torques allow."""
    bot = robot("talos")
    control = wbc.WholeBodyController(bot)
    control.add(wbc.ComTask(weight=1000.0, priority=priorities[0]))
    control.add(wbc.PositionTask(hand(bot), name="hand", priority=priorities[1]))
    control.tasks[1].acceleration[2] = lift
    control.add(wbc.PostureTask(bot, priority=priorities[2]))
    control.set_contacts(contact_set(bot, "both"))
    return control


@pytest.mark.parametrize(("priorities", "lift"), [((1, 1, 1), 100.0), ((1, 2, 3), 30.0)])
def test_a_row_that_gives_way_by_a_little_brings_what_was_foretold(priorities, lift):
    state = standing_state(robot("talos"), 1)
    control = reaching(priorities, lift)
    command = control.step(state)
    assert command.status is Status.OK
    why = command.explain()
    row, gain = next(
        (row, gain)
        for row in why.active
        for gain in row.gains
        if row.name.startswith("torque limit") and gain.name.startswith("hand")
    )
    step = 1e-4
    joint = control.robot.joint_names.index(row.name[len("torque limit [") : -1])
    before = next(task for task in why.tasks if task.name == "hand")
    eased = reaching(priorities, lift)
    limits = list(eased.limits)
    maximum = limits[0].maximum.copy()
    maximum[joint] += step
    limits[0] = wbc.TorqueLimit(eased.robot, maximum=maximum)
    eased.set_limits(limits)
    after = next(task for task in eased.step(state).explain().tasks if task.name == "hand")
    axis = before.labels.index(gain.name[len("hand [") : -1])
    off, now = before.asked[axis] - before.got[axis], after.asked[axis] - after.got[axis]
    assert abs(off) - abs(now) == pytest.approx(step * gain.change, rel=1e-2)


def test_a_task_is_told_what_it_asked_for_and_got():
    bot = robot("talos")
    control = reaching((1, 2, 3))
    command = control.step(standing_state(bot, 1))
    com, lifted, _ = command.explain().tasks
    kin = control.kinematics
    np.testing.assert_allclose(com.got, kin.J_com @ command.acceleration + kin.bias_com)
    np.testing.assert_allclose(com.got, com.asked, atol=1e-7)
    at = kin.motion(hand(bot))
    np.testing.assert_allclose(lifted.got, (at.jacobian @ command.acceleration + at.bias)[:3])
    assert lifted.units == ("m/s²",) * 3
    assert lifted.asked[2] - lifted.got[2] > 1.0
    text = str(command.explain())
    assert "com (priority 1): got what it asked for" in text
    assert "in the way:" in text
    assert "m/s² closer to what is asked" in text


def test_nothing_is_in_the_way_of_tasks_that_got_what_they_asked_for():
    bot = robot("talos")
    control = reaching((1, 2, 3))
    control.tasks[1].acceleration[:] = 0.0
    why = control.step(bot.standing()).explain()
    assert {row.priority for row in why.active} <= {0, 3}
    assert "hand (priority 2): got what it asked for" in str(why)


def test_explaining_does_not_change_the_next_tick():
    bot = robot("talos")
    plain, explained = reaching((1, 2, 3)), reaching((1, 2, 3))
    for seed in range(3):
        state = standing_state(bot, seed)
        tau = plain.step(state).tau
        command = explained.step(state)
        np.testing.assert_array_equal(command.tau, tau)
        command.explain()


def test_a_tick_without_a_solution_names_the_rows_and_how_much_each_gives():
    control = reaching((1, 2, 3))
    control.add(wbc.ComTask(priority=0, name="stay"))
    control.add(wbc.ComTask(priority=0, name="go")).acceleration[0] = 1.0
    command = control.step(robot("talos").standing())
    why = command.explain()
    assert why.reason == str(why) == command.explanation
    assert {(row.name, row.unit) for row in why.conflict} == {
        ("go [x]", "m/s²"),
        ("stay [x]", "m/s²"),
    }
    for row in why.conflict:
        assert row.equality
        assert abs(row.violation) == pytest.approx(0.5)
    control.remove(control.tasks[-1])
    assert control.step(robot("talos").standing()).explain().conflict == ()


@pytest.mark.parametrize("asked", [40.0, 200.0])
def test_rows_in_conflict_can_hold_once_each_gives_way_by_its_amount(asked):
    control = reaching((1, 2, 3))
    control.add(wbc.ComTask(priority=0, name="jump")).acceleration[2] = asked
    command = control.step(robot("talos").standing())
    problem, rows = control.problem, command.explain().conflict
    place = {b.label(i): i for b in problem.blocks for i in range(b.start, b.stop)}
    A = np.vstack((np.eye(problem.bounded, problem.g.size), problem.C))
    lb, ub = problem.exact_bounds()

    def feasible(give: float) -> bool:
        at = [place[row.name] for row in rows]
        below = lb[at] + give * np.array([min(row.violation, 0.0) for row in rows])
        above = ub[at] + give * np.array([max(row.violation, 0.0) for row in rows])
        known = np.concatenate((np.isfinite(above), np.isfinite(below)))
        G, h = np.vstack((A[at], -A[at]))[known], np.concatenate((above, -below))[known]
        return linprog(np.zeros(A.shape[1]), G, h, bounds=(-1e4, 1e4)).status == 0

    assert not feasible(0.0)
    assert not feasible(0.9)
    assert feasible(1.001)


def test_only_the_last_command_of_a_controller_can_be_explained():
    control, state = reaching((1, 2, 3)), robot("talos").standing()
    first = control.step(state)
    first.explain()
    control.step(state)
    with pytest.raises(WbcError, match="before the next step"):
        first.explain()
    with pytest.raises(WbcError, match="copied, or comes from no QP"):
        copy.deepcopy(control.step(state)).explain()


@pytest.mark.parametrize("degenerate", [False, True])
def test_multipliers_balance_the_gradient_of_every_level_with_the_right_signs(degenerate):
    for seed in range(10):
        problem = random_problem(seed, Shape(levels=(3, 4)), degenerate=degenerate)
        x = HierarchicalSolver().solve(problem).x
        found = LevelMultipliers(problem, x)
        assert found.residual.max() < 1e-6
        signed = ~problem.equality & (problem.levels.level == 0)
        assert (found.values[:, signed & ~found.at_upper] <= 0.0).all()
        assert (found.values[:, signed & ~found.at_lower] >= 0.0).all()
