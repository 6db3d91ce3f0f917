"""The log tells what was done to the robot, and what happened to it."""

import json
import re

import numpy as np
import pytest
from logtools import StreamedLog, random_tick, robot
from matplotlib.figure import Figure

import wbc
from wbc.cli import main
from wbc.log import FlightRecorder, LoggedRun
from wbc.log.plots.style import broken_time, mark_events
from wbc.motions import MotionPlayer
from wbc.runtime.event import COMMAND, FALL, RESET, RunEvent
from wbc.sim import Mujoco
from wbc.teleop import (
    CommandHandler,
    GainCommand,
    GaitParameterCommand,
    PushCommand,
    ResetCommand,
    VelocityCommand,
)


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """A session with a reset and a fall, and a gain that changes."""
    path = tmp_path_factory.mktemp("events") / "session.mcap"
    humanoid = wbc.load("simple_humanoid")
    player = MotionPlayer(humanoid)
    plant = Mujoco(humanoid, dt=player.dt)
    with CommandHandler(player, plant, owns_clock=False) as handler:
        push = PushCommand((0.0, handler.capabilities.max_impulse, 0.0))
        gait = handler.capabilities.parameter("gait.swing_height")
        script = {
            0.02: [VelocityCommand(0.1), GainCommand("com", "weight", 2000.0)],
            0.06: [GaitParameterCommand("swing_height", gait.high)],
            0.1: [ResetCommand()],
        }
        last = [0.0]

        def submit(now):
            if now < last[0]:
                script.update({0.04: [push]})
            last[0] = now
            for due in [at for at in script if now >= at - 1e-9]:
                for command in script.pop(due):
                    handler.submit(command, source="tester")

        with FlightRecorder(path, humanoid) as log:
            wbc.teleop.run(handler, 3.0, observers=[log], real_time=False, before_tick=submit)
    return LoggedRun.read(path)


def test_every_command_is_in_the_log_with_its_time_sender_and_outcome(session):
    commands = [event for event in session.events if event.kind == COMMAND]
    told = [(event.name, event.source, event.outcome) for event in commands]
    assert told == [
        ("velocity", "tester", "accepted"),
        ("gain", "tester", "accepted"),
        ("gait_parameter", "tester", "accepted"),
        ("reset", "tester", "accepted"),
        ("reset", "tester", "done"),
        ("push", "tester", "accepted"),
    ]
    assert json.loads(commands[0].value)["forward"] == 0.1
    assert commands[0].time == pytest.approx(0.02)
    assert commands[3].time == pytest.approx(0.1)
    reset = session.time[np.flatnonzero(np.diff(session["tick"]) < 0)[0] + 1]
    assert commands[5].time == pytest.approx(reset + 0.04)


def test_falls_and_resets_are_events_and_in_the_title(session):
    kinds = [event.kind for event in session.events if event.kind in (FALL, RESET)]
    assert kinds == [RESET, FALL]
    assert re.search(r"1 fall, 1 reset$", session.title)
    assert session.events[-1].kind == FALL
    assert "base" in session.events[-1].reason


def test_parameters_are_a_topic_when_they_change(session):
    first, second = session.log["/parameter_events"].messages()
    assert (first.node, first.changed_parameters[0].name) == ("tester", "com.weight")
    assert first.changed_parameters[0].value.double_value == 2000.0
    assert second.changed_parameters[0].name == "gait.swing_height"


def test_wbc_log_lists_the_events(session, capsys):
    assert main(["log", str(session.log.path)]) == 0
    told = capsys.readouterr().out
    assert re.search(r"push +tester +accepted", told)
    assert re.search(r"\bfall\b +the base", told)


def test_plots_mark_falls_and_break_lines_at_resets(session):
    axes = Figure().subplots()
    mark_events(axes, session)
    lines = sorted(line.get_xdata()[0] for line in axes.get_lines())
    marked = [e.time for e in session.events if e.kind != COMMAND and e.kind != "falling"]
    marked += [e.time for e in session.events if e.name == "push"]
    assert lines == pytest.approx(sorted(marked))
    assert np.isnan(broken_time(session, slice(None))).sum() == 1


def test_an_event_waits_for_its_tick_and_the_last_ones_for_the_end(tmp_path):
    humanoid = robot()
    rng = np.random.default_rng(0)
    path = tmp_path / "events.mcap"
    with StreamedLog(path, humanoid) as log:
        log.stream.begin_run()
        log.begin()
        for k in range(5):
            log.log.on_event(RunEvent(0.002 * k, COMMAND, "page", k, "stand", "{}", "accepted"))
            log.record(random_tick(humanoid, rng, 0.002 * k))
        log.log.on_event(RunEvent(5.0, FALL, reason="x" * 10_000))
    events = LoggedRun.read(path).events
    assert [event.number for event in events] == [0, 1, 2, 3, 4, 0]
    assert [event.time for event in events] == pytest.approx([0.0, 0.002, 0.004, 0.006, 0.008, 5.0])
    assert set(events[-1].reason) == {"x"}
