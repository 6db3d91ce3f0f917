"""Any tick of a log is solved again alone, and explained."""

import os
import subprocess
import sys

import numpy as np
import pytest
from robottools import changed

import wbc
from wbc.command import Status
from wbc.log import FlightRecorder, LogError, LoggedRun, LoggedTick
from wbc.qp.inputs import packed_text, packed_values
from wbc.recorded_tick import recorded_controller
from wbc.runtime.controller_inputs import controller_inputs
from wbc.sim import Mujoco
from wbc.walking import HandContact


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """A walk that is pushed, and its log."""
    path = tmp_path_factory.mktemp("log") / "walk.mcap"
    robot = wbc.load("g1")
    walker = wbc.Walker(robot)
    walker.velocity = (0.2, 0.0, 0.0)
    with Mujoco(robot) as plant, FlightRecorder(path, robot) as log:
        plant.schedule_push(1.2, [0.0, 0.4 * robot.mass, 0.0])
        wbc.run(walker, plant, 2.0, observers=[log])
    return LoggedRun.read(path), robot


def test_ticks_of_a_pushed_walk_are_solved_again_to_the_same_torques(walk):
    run, robot = walk
    for time in np.random.default_rng(0).uniform(0.0, 2.0, 10):
        tick = LoggedTick(run, time, robot)
        assert tick.status is tick.command.status is Status.OK
        assert tick.torque_error < 1e-9
    assert tick.command.explain().tasks[0].name == "com"


def test_inputs_are_no_quantities_to_be_plotted(walk):
    run, _ = walk
    assert "controller_inputs" not in run
    assert len(run.log["/controller_inputs"]) == len(run)


def test_command_line_explains_a_tick(walk):
    run, _ = walk
    done = subprocess.run(
        [sys.executable, "-m", "wbc", "explain", str(run.log.path), "--at", "1.25"],
        capture_output=True,
        text=True,
        env=dict(os.environ),
    )
    assert done.returncode == 0, done.stderr
    assert "tick at 1.250 s, ok; solved again, torques within " in done.stdout
    assert "com (priority 1)" in done.stdout


@pytest.mark.parametrize("time", [-0.1, 2.1, np.nan])
def test_a_time_that_the_log_does_not_have_is_refused_with_its_span(walk, time):
    run, robot = walk
    with pytest.raises(LogError, match=r"has no tick at .* s: it goes from 0 to 1\.998 s"):
        LoggedTick(run, time, robot)
    assert LoggedTick(run, 2.0, robot).time == pytest.approx(1.998)


def test_a_log_without_inputs_says_so(walk):
    run, robot = walk
    older = LoggedRun.read(run.log.path)
    del older.log.topics["/controller_inputs"]
    with pytest.raises(LogError, match="does not hold what its ticks were made of"):
        LoggedTick(older, 1.0, robot)
    with pytest.raises(LogError, match="the log is of 'g1', not of 'talos'"):
        LoggedTick(run, 1.0, wbc.load("talos"))


def test_enough_numbers_are_reserved_for_a_walk_with_hands_in_contact_and_coupled_joints(tmp_path):
    mimic = '<mimic joint="left_{0}" multiplier="-1.0"/>'
    changes = [
        (child, child + mimic.format(joint))
        for joint, link in (("elbow", "forearm"), ("shoulder_roll", "upper_arm"))
        for child in [f'<child link="right_{link}"/>']
    ]
    robot = wbc.load(changed(tmp_path, *changes))
    assert len(robot.couplings) == 2
    walker = wbc.Walker(robot)
    for frame in ("left_hand", "right_hand"):
        walker.hand_contacts.add(HandContact(frame, np.array([-1.0, 0.0, 0.0]))).set_force(1.0, 9.0)
    controller = walker.controller
    walker.step(wbc.Estimate(robot.standing()))
    assert len(controller.contacts) == 4
    state = robot.standing()
    command = controller.step(state)
    words = command.source.packed_inputs(command, controller_inputs(robot).size)
    again = recorded_controller(robot, packed_text(words), packed_values(words))
    assert (again.step(state).tau == command.tau).all()
