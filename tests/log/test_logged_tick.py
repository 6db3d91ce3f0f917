"""Any tick of a log is solved again alone, and explained."""

import os
import subprocess
import sys

import numpy as np
import pytest

import wbc
from wbc.command import Status
from wbc.log import FlightRecorder, LogError, LoggedRun, LoggedTick
from wbc.sim import Mujoco


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


def test_a_log_without_inputs_says_so(walk):
    run, robot = walk
    older = LoggedRun.read(run.log.path)
    del older.log.topics["/controller_inputs"]
    with pytest.raises(LogError, match="does not hold what its ticks were made of"):
        LoggedTick(older, 1.0, robot)
    with pytest.raises(LogError, match="the log is of 'g1', not of 'talos'"):
        LoggedTick(run, 1.0, wbc.load("talos"))
