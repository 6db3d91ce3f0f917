"""Commands from another process: they arrive whole, and the sender learns what became of them."""

import os
import time
from dataclasses import replace

import pytest
from motiontools import InfeasibleMotion, SlowlyPlannedMotion, WaitingMotion

import wbc
from wbc.motions import MotionPlayer
from wbc.process import BlobQueue
from wbc.teleop import (
    CommandClient,
    CommandHandler,
    CommandOutcome,
    CommandRefused,
    GainCommand,
    JointCommand,
    MotionCommand,
    PushCommand,
    ResetCommand,
    StandCommand,
    VelocityCommand,
)


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


@pytest.fixture
def handler(robot):
    player = MotionPlayer(robot)
    plant = wbc.sim.Mujoco(robot)
    motions = (WaitingMotion, SlowlyPlannedMotion, InfeasibleMotion)
    with CommandHandler(player, plant, motions=motions, owns_clock=False) as handler:
        handler.begin()
        handler.before_tick(0.0)
        yield handler


@pytest.fixture
def client(handler, robot):
    """The other end of a channel, as another process has it."""
    config = handler.open_channel().config
    config = replace(
        config,
        commands=os.dup(config.commands),
        acknowledgements=os.dup(config.acknowledgements),
    )
    client = CommandClient(robot, config, "test")
    client.start_planning()
    return client


def poll(client, count):
    """The next acknowledgements, (id, outcome, reason)."""
    found, end = [], time.monotonic() + 20.0
    while len(found) < count:
        assert time.monotonic() < end
        found += [(ack.id, ack.outcome, ack.reason) for ack in client.poll()]
        time.sleep(0.001)
    return found


def received_by(handler):
    """The commands that the handler takes before its next two ticks."""
    received = []
    handler.add_observer(lambda sent, _: received.append(sent))
    for _ in range(2):
        handler.before_tick(0.0)
    return received


def test_commands_arrive_whole_and_in_order_and_are_acknowledged(handler, client):
    commands = [
        VelocityCommand(0.1, 0.02, -0.2, timeout=0.5),
        PushCommand((1.0, 2.0, 3.0), 0.2, "world"),
        GainCommand("com", "weight", 1000.0),
        JointCommand(("left_elbow",), (0.3,), 1.0, 0.7),
        StandCommand(),
    ]
    before = time.monotonic()
    numbers = [client.send(command) for command in commands]
    received = received_by(handler)
    assert [sent.command for sent in received] == commands
    assert [sent.id for sent in received] == numbers
    assert {sent.source for sent in received} == {"test"}
    assert all(before <= sent.stamp <= time.monotonic() for sent in received)
    assert poll(client, 5) == [(number, CommandOutcome.ACCEPTED, "") for number in numbers]


def test_a_flood_of_commands_is_spread_over_ticks_and_none_is_lost(handler, client):
    numbers = [client.send(GainCommand("com", "weight", 1000.0 + k)) for k in range(30)]
    received = received_by(handler)
    assert 0 < len(received) < 10
    for _ in range(8):
        handler.before_tick(0.0)
    assert [sent.id for sent in received] == numbers


def test_an_invalid_command_never_reaches_the_loop(handler, client):
    with pytest.raises(CommandRefused, match="out of range"):
        client.send(VelocityCommand(50.0))
    with pytest.raises(CommandRefused, match="no motion"):
        client.send(MotionCommand(wbc.motions.Wave()))
    assert received_by(handler) == []


def test_a_motion_arrives_planned_and_is_acknowledged(handler, client, robot):
    number = client.send(MotionCommand(WaitingMotion(0.2)))
    while client.planning is not None:
        assert client.poll() == []
    handler.before_tick(0.0)
    assert handler.playing == WaitingMotion(0.2) or handler.waiting == WaitingMotion(0.2)
    assert poll(client, 1) == [(number, CommandOutcome.ACCEPTED, "")]
    client.send(StandCommand())
    for _ in range(2500):  # back to standing
        handler.before_tick(0.0)
        handler.player.step(wbc.Estimate(robot.standing()))
    (_, (done, outcome, reason)) = poll(client, 2)
    assert (done, outcome) == (number, CommandOutcome.SUPERSEDED)
    assert reason == "stand command from test took its place"


def test_a_motion_that_the_robot_cannot_do_is_refused_with_the_reason(handler, client):
    number = client.send(MotionCommand(InfeasibleMotion()))
    assert poll(client, 1) == [
        (number, CommandOutcome.REFUSED, "infeasible_motion: no robot can do it")
    ]
    assert received_by(handler) == []


def test_a_motion_whose_planning_fails_is_refused(client):
    number = client.send(MotionCommand(SlowlyPlannedMotion(folder="nowhere")))
    ((refused, outcome, reason),) = poll(client, 1)
    assert (refused, outcome) == (number, CommandOutcome.REFUSED)
    assert "FileNotFoundError" in reason


@pytest.mark.parametrize(
    ("command", "reason"),
    [
        (VelocityCommand(0.1), "commanded to walk"),
        (StandCommand(), "commanded to stand"),
        (ResetCommand(), "was reset"),
        (MotionCommand(WaitingMotion()), "another motion"),
    ],
)
def test_a_motion_that_is_being_planned_is_superseded(client, tmp_path, command, reason):
    number = client.send(MotionCommand(SlowlyPlannedMotion(folder=str(tmp_path))))
    client.send(command)
    ((superseded, outcome, text),) = poll(client, 1)
    assert (superseded, outcome) == (number, CommandOutcome.SUPERSEDED)
    assert reason in text
    (tmp_path / "plan").touch()


def test_standing_velocities_do_not_supersede_a_motion(client, tmp_path):
    client.send(MotionCommand(SlowlyPlannedMotion(folder=str(tmp_path))))
    client.send(VelocityCommand())
    assert client.planning is not None
    (tmp_path / "plan").touch()


def test_sending_to_a_loop_that_takes_no_commands_is_refused(client):
    for _ in range(32):
        client.send(VelocityCommand(0.1))
    with pytest.raises(CommandRefused, match="too many commands at once"):
        client.send(VelocityCommand(0.1))


def test_a_sender_that_reads_no_acknowledgements_does_not_stop_the_loop(handler, client):
    for _ in range(400):
        client.send(VelocityCommand(0.1))
        handler.before_tick(0.0)
    assert len(client.poll()) == 256


def test_a_plan_that_is_too_large_is_refused(client, monkeypatch):
    client._commands = BlobQueue(32, 64)
    number = client.send(MotionCommand(WaitingMotion()))
    ((refused, outcome, reason),) = poll(client, 1)
    assert (refused, outcome) == (number, CommandOutcome.REFUSED)
    assert "make it shorter" in reason
