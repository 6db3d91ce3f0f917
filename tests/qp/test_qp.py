"""Elimination and assembly: different formulations of one problem have one optimum."""

import numpy as np
import pytest
from coretools import (
    CONTACT_SETS,
    SOLE_SETS,
    contact_set,
    controller,
    few,
    force_of,
    robot,
    robots,
    seeds,
    some,
    standing_state,
)
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.command import Status


@some
@given(robots, st.sampled_from(CONTACT_SETS), seeds)
def test_reduced_and_full_formulation_agree(name, contacts, seed):
    bot = robot(name)
    state = standing_state(bot, seed)
    commands = []
    for formulation in (wbc.Formulation.REDUCED, wbc.Formulation.FULL):
        control = controller(bot, contacts, formulation=formulation)
        commands.append(control.step(state))
        assert commands[-1].status is Status.OK, commands[-1].explanation
    reduced, full = commands
    np.testing.assert_allclose(reduced.acceleration, full.acceleration, atol=1e-6)
    for contact in control.contacts:
        a, b = (force_of(contact, c) for c in commands)
        np.testing.assert_allclose(a, b, atol=1e-4 if "both" in contacts else 1e-5)


@few
@given(robots, seeds)
def test_the_optimum_does_not_depend_on_which_sole_comes_first(name, seed):
    bot = robot(name)
    state = standing_state(bot, seed)
    taus = []
    for order in (1, -1):
        control = controller(bot, contact_set(bot, "both")[::order])
        taus.append(control.step(state).tau)
    np.testing.assert_allclose(taus[0], taus[1], atol=1e-5)


@pytest.mark.parametrize("contacts", CONTACT_SETS)
@pytest.mark.parametrize("formulation", list(wbc.Formulation))
def test_every_row_has_a_name_and_a_unit(contacts, formulation):
    bot = robot("simple_humanoid")
    control = controller(bot, contacts, formulation=formulation)
    control.add(wbc.PositionTask(bot.torso, priority=0))
    control.step(bot.standing())
    problem = control.problem
    end = 0
    for block in problem.blocks:
        assert block.start == end
        assert block.stop > block.start
        assert block.name
        assert block.unit
        assert not block.labels or len(block.labels) == block.stop - block.start
        end = block.stop
    assert end == problem.lb.size == problem.ub.size
    assert end == problem.bounded + problem.C.shape[0]
    equal = problem.equality
    np.testing.assert_array_equal(problem.lb[equal], problem.ub[equal])
    named = [b.name for b in problem.blocks for r in range(b.start, b.stop) if equal[r]]
    assert named.count(f"{bot.torso} position") == 3


@few
@given(robots, st.lists(st.sampled_from((*SOLE_SETS, "none")), min_size=3, max_size=8), seeds)
def test_a_warm_start_across_contact_switches_changes_nothing(name, sequence, seed):
    bot = robot(name)
    warm = controller(bot, "both")
    kept = {name: contact_set(bot, name) for name in (*SOLE_SETS, "none")}
    for k, contacts in enumerate(sequence):
        state = standing_state(bot, seed + k)
        cold = controller(bot, contacts)
        for task, other in zip(warm.tasks, cold.tasks, strict=True):
            task.target = None if task.name != "posture" else task.target
            if task.name == "angular momentum":
                task.target = other.target
        warm.set_contacts(kept[contacts])
        a, b = warm.step(state), cold.step(state)
        assert a.status is b.status is Status.OK
        np.testing.assert_allclose(a.tau, b.tau, atol=1e-6)
        np.testing.assert_allclose(a.acceleration, b.acceleration, atol=1e-6)


def test_solving_the_same_problem_again_gives_the_same_answer():
    bot = robot("talos")
    control = controller(bot, "both")
    state = standing_state(bot, 11, speed=0.4)
    first = control.step(state)
    for _ in range(3):
        np.testing.assert_allclose(control.step(state).tau, first.tau, atol=1e-8)


def test_a_changed_weight_target_or_friction_counts_from_the_next_tick():
    bot = robot("talos")
    state = standing_state(bot, 2)

    def push(control: wbc.WholeBodyController, contact: wbc.SurfaceContact) -> None:
        control.tasks[0].weight = 5.0
        control.tasks[0].acceleration[:] = (3.0, 0.0, 0.0)
        contact.friction = 0.1
        contact.max_force = 600.0

    used, fresh = controller(bot, "both"), controller(bot, "both")
    used.step(state)
    push(used, used.contacts[1])
    push(fresh, fresh.contacts[1])
    for task in (*used.tasks[:2], *fresh.tasks[:2]):
        task.target = None
    np.testing.assert_allclose(used.step(state).tau, fresh.step(state).tau, atol=1e-7)
    force = used.step(state).wrenches["right_sole"]
    assert abs(force[0]) <= 0.1 / np.sqrt(2.0) * force[2] + 1e-6
    assert force[2] <= 600.0 + 1e-6


def test_priority_and_contact_softness_may_change_between_ticks():
    bot = robot("talos")
    state = standing_state(bot, 3)
    control = controller(bot, "both")
    control.step(state)
    control.contacts[1].motion_weight = 3000.0
    control.tasks[1].priority = 0
    fresh = controller(bot, "left exact, right soft")
    fresh.tasks[1].priority = 0
    np.testing.assert_allclose(control.step(state).tau, fresh.step(state).tau, atol=1e-6)


@few
@given(robots, seeds)
def test_identical_exact_tasks_do_not_conflict_even_far_from_their_target(name, seed):
    bot = robot(name)
    state = standing_state(bot, seed, speed=0.3)
    state.q[:3] += (300.0, -200.0, 10.0)
    plain, twice = controller(bot, "left"), controller(bot, "left")
    twice.add(wbc.FrameTask("left_sole", priority=0, kp=0.0, kd=30.0))
    a, b = plain.step(state), twice.step(state)
    assert a.status is b.status is Status.OK, b.explanation
    np.testing.assert_allclose(a.acceleration, b.acceleration, atol=1e-5)
    again = wbc.PointContact("left_sole", name="again")
    command = controller(bot, [*contact_set(bot, "left"), again]).step(state)
    assert command.status is Status.OK, command.explanation
    at = wbc.Kinematics(bot, state).motion("left_sole")
    moves = at.jacobian @ command.acceleration + at.bias
    np.testing.assert_allclose(moves, -30.0 * at.velocity, atol=1e-7)


@some
@given(robots, st.sampled_from(CONTACT_SETS), seeds, st.data())
def test_any_weights_give_a_solution_that_meets_the_constraints(name, contacts, seed, data):
    bot = robot(name)
    state = standing_state(bot, seed)
    control = controller(bot, contacts)
    for task in control.tasks:
        task.weight = 10.0 ** data.draw(st.floats(-6.0, 6.0), label=task.name)
    command = control.step(state)
    assert command.status is Status.OK, command.explanation
    x = control.solver.solve(control.problem).x
    assert control.problem.violation(x).max() < 1e-6
