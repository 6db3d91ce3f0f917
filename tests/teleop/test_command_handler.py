"""The command handler: what each command does to a robot in a loop, and how it is acknowledged."""

import math
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
from motiontools import AbortingMotion

import wbc
from wbc.errors import MotionError
from wbc.motions import MOTIONS, MotionPlayer, OneLeg, Reach, Squat, Sway, Wave, pack, unpack
from wbc.runtime.loop import StopRun
from wbc.runtime.mode import Mode
from wbc.teleop import (
    CommandHandler,
    CommandOutcome,
    CommandRefused,
    FrameTaskCommand,
    GainCommand,
    GaitParameterCommand,
    HandTargetCommand,
    JointCommand,
    KeepVelocityCommand,
    MotionCommand,
    PauseCommand,
    PushCommand,
    ResetCommand,
    SessionChoices,
    StandCommand,
    StartSessionCommand,
    TimeScaleCommand,
    VelocityCommand,
)
from wbc.teleop.parameters import tunable_parameters

ACCEPTED, REFUSED, SUPERSEDED, DONE, ABORTED = (
    CommandOutcome.ACCEPTED,
    CommandOutcome.REFUSED,
    CommandOutcome.SUPERSEDED,
    CommandOutcome.DONE,
    CommandOutcome.ABORTED,
)


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


@pytest.fixture
def player(robot):
    return MotionPlayer(robot)


@pytest.fixture
def plant(robot):
    return wbc.sim.Mujoco(robot)


def new_handler(player, plant, **options):
    return CommandHandler(player, plant, **{"owns_clock": False, **options})


@pytest.fixture
def handler(player, plant):
    with new_handler(player, plant) as handler:
        yield handler


def client(idle):
    """A client that is told when there are no ticks, as a stream's readers are."""
    stream = SimpleNamespace(repeat=lambda mode, *_: idle(mode))
    nothing = dict.fromkeys(("begin", "observe", "end"), lambda *_: None)
    return SimpleNamespace(reset_hint="", stream=stream, **nothing)


class Run:
    """A run of commands at given times, and what happened in each tick."""

    def __init__(self, handler, duration, script=(), **options):
        self.handler, self.player = handler, handler.player
        self.time, self.tau, self.dcm, self.playing, self.steps = [], [], [], [], []
        self._joints = []
        self.outcomes = []
        handler.add_observer(lambda sent, ack: self.outcomes.append((sent.command, ack)))
        script = list(script)

        def submit_due(now):
            while script and now >= script[0][0] - 1e-9:
                handler.submit(script.pop(0)[1])

        self.report = wbc.teleop.run(
            handler, duration, observers=[self], real_time=False, before_tick=submit_due, **options
        )

    @property
    def joints(self):
        return np.array(self._joints)

    def outcomes_of(self, command):
        return [ack.outcome for sent, ack in self.outcomes if sent == command]

    def begin(self, controller, plant):
        pass

    def observe(self, tick):
        self.time.append(tick.time)
        self.tau.append(tick.command.tau.copy())
        self.dcm.append(tick.telemetry.dcm[:2].copy())
        self.playing.append(self.handler.playing)
        self.steps.append(self.player.steps)
        self._joints.append(tick.estimate.state.q[7:].copy())

    def end(self, report):
        pass


# In a simulation.


def test_a_velocity_changes_the_command_of_the_very_tick_after_it(handler):
    still = Run(handler, 0.2)
    moved = Run(handler, 0.2, [(0.1, VelocityCommand(0.1))])
    differs = [(a != b).any() for a, b in zip(still.tau, moved.tau, strict=True)]
    assert differs.index(True) == 50
    ((_, ack),) = moved.outcomes
    assert (ack.outcome, ack.time) == (ACCEPTED, pytest.approx(0.1))


def test_a_push_moves_the_dcm_to_the_robots_left_and_is_counted_when_survived(handler, player):
    impulse = 0.1 * player.robot.mass
    still = Run(handler, 0.4)
    pushed = Run(handler, 3.4, [(0.2, PushCommand((0.0, impulse, 0.0)))])
    k = 170  # 0.14 s after the push set in
    moved = pushed.dcm[k] - still.dcm[k]
    omega = player.walker.gait.omega
    assert moved[1] == pytest.approx(0.1 / omega, rel=0.5)  # Δξ = J / (m ω)
    assert abs(moved[0]) < 0.3 * moved[1]
    assert pushed.report.survived
    assert (handler.pushes.survived, handler.pushes.decided) == (1, 1)


def test_after_a_fall_only_a_reset_is_accepted_and_the_pushes_were_not_survived(handler):
    largest = PushCommand((0.0, handler.capabilities.max_impulse, 0.0))
    small, late = PushCommand((0.0, 5.0, 0.0)), PushCommand((0.0, 6.0, 0.0))
    messages, fallen = [], []

    def idle(mode):
        fallen.append(mode)
        if len(fallen) == 1:
            handler.submit(late)
            handler.submit(ResetCommand())

    run = Run(
        handler,
        3.0,
        [(0.1, largest), (0.2, small)],
        clients=[client(idle)],
        message=messages.append,
    )
    said = [line.split(":")[0] for line in messages]
    assert said == ["the robot is falling", "fell", "reset"]
    assert set(fallen) == {Mode.FALLEN}
    assert (handler.pushes.survived, handler.pushes.decided) == (0, 2)
    assert run.outcomes_of(late) == [REFUSED]
    assert "reset it first" in next(ack.reason for c, ack in run.outcomes if c == late)
    assert run.outcomes_of(ResetCommand()) == [ACCEPTED, DONE]
    assert run.report.survived


def test_without_a_client_that_could_reset_it_a_run_ends_with_the_fall(handler):
    fall = PushCommand((0.0, handler.capabilities.max_impulse, 0.0))
    run = Run(handler, 10.0, [(0.1, fall)])
    assert not run.report.survived
    assert run.report.duration_s < 5.0


def test_walking_and_a_motion_follow_one_another(handler, player):
    sway, again = MotionCommand(Sway()), VelocityCommand(0.15)
    run = Run(handler, 5.4, [(0.0, VelocityCommand(0.1)), (0.8, sway), (2.8, again)])
    assert run.report.survived
    playing = np.array([motion is not None for motion in run.playing])
    begin, end = np.flatnonzero(playing)[[0, -1]]
    assert 1.2 < run.time[begin] < 2.7  # first it comes to a stand
    assert run.time[end] == pytest.approx(2.8, abs=0.01)  # it ends at once
    assert player.velocity == (0.15, 0.0, 0.0)
    assert run.steps[-1] > run.steps[end]
    assert run.outcomes_of(sway) == [ACCEPTED, SUPERSEDED]
    reason = next(ack.reason for c, ack in run.outcomes if ack.outcome is SUPERSEDED)
    assert reason == "velocity command from script took its place"


def test_arms_wave_while_it_walks_and_velocities_are_still_followed(handler, player):
    wave = MotionCommand(Wave(seconds=0.5))
    run = Run(
        handler, 5.5, [(0.0, VelocityCommand(0.1)), (1.0, wave), (2.5, VelocityCommand(0.15))]
    )
    assert run.report.survived
    playing = np.array([motion == wave.motion for motion in run.playing])
    begin, end = np.flatnonzero(playing)[[0, -1]]
    assert begin == 500
    assert run.time[end] > 2.6
    assert not playing[-1]
    assert player.velocity == (0.15, 0.0, 0.0)
    assert run.steps[begin] < run.steps[end] < run.steps[-1]
    arms = player.context.upper_body.both_arms()
    home = player.context.posture.home
    raised = max(abs(run.joints - home)[begin:end][:, list(arm.joints)].max() for arm in arms)
    assert raised > 0.5
    assert run.outcomes_of(wave) == [ACCEPTED, DONE]


def test_the_push_that_a_motion_requests_is_given_and_counted(handler, player, monkeypatch):
    pushed = []
    push = handler.plant.push
    monkeypatch.setattr(
        handler.plant, "push", lambda impulse, **_: (pushed.append(impulse), push(impulse))
    )
    motion = OneLeg(leg="left", hold=0.4, impulse=0.02)
    run = Run(handler, 8.0, [(0.0, MotionCommand(motion))])
    assert run.report.survived
    assert len(pushed) == 1
    assert np.linalg.norm(pushed[0]) == pytest.approx(0.02 * player.robot.mass)
    assert (handler.pushes.survived, handler.pushes.decided) == (1, 1)


def test_stand_ends_walking_and_motions(handler):
    sway, squat = MotionCommand(Sway()), MotionCommand(Squat())
    run = Run(handler, 2.5, [(0.0, sway), (0.5, squat), (0.6, StandCommand())])
    assert set(run.playing[400:]) == {None}
    assert handler.player.idle
    assert run.outcomes_of(sway) == run.outcomes_of(squat) == [ACCEPTED, SUPERSEDED]


def test_a_motion_that_gives_up_is_aborted_with_the_reason_and_the_robot_stands(player, plant):
    with new_handler(player, plant, motions=(AbortingMotion,)) as handler:
        run = Run(handler, 3.0, [(0.0, MotionCommand(AbortingMotion()))])
    assert run.report.survived
    assert run.playing[-1] is None
    assert player.context.at_home
    assert run.outcomes_of(MotionCommand(AbortingMotion())) == [ACCEPTED, ABORTED]
    assert "its script raised" in run.outcomes[-1][1].reason


def test_pause_stops_time_and_commands_are_still_taken(handler, player, plant):
    seen = []

    def idle(mode):
        seen.append((plant.time, player.walker.com.weight[0], mode))
        if len(seen) == 3:
            handler.submit(GainCommand("com", "weight", 1000.0))
        if len(seen) == 6:
            handler.submit(PauseCommand(False))

    run = Run(handler, 0.1, [(0.04, PauseCommand())], clients=[client(idle)])
    assert len(seen) >= 6
    assert {(time, mode) for time, _, mode in seen} == {(0.04, Mode.PAUSED)}
    assert seen[-1][1] == 1000.0
    assert len(run.time) == 50


def test_slow_motion_makes_ticks_rarer(player, plant):
    with new_handler(player, plant, owns_clock=True) as handler:
        handler.submit(TimeScaleCommand(0.05))
        start = time.perf_counter()
        Run(handler, 0.02)
    assert time.perf_counter() - start > 9 * 0.002 / 0.05 - 0.01


def test_a_time_scale_is_refused_where_the_loop_keeps_the_time(handler):
    with pytest.raises(CommandRefused, match="wall clock"):
        handler.submit(TimeScaleCommand(0.5))


def test_a_reset_starts_the_run_again_once(handler):
    runs = []
    log = SimpleNamespace(begin=lambda *_: runs.append([]), end=lambda _: None)
    log.observe = lambda tick: runs[-1].append(tick.time)
    script = [(0.05, ResetCommand()), (0.05, ResetCommand())]

    def submit_due(now):
        while script and now >= script[0][0] - 1e-9 and len(runs) == 1:
            handler.submit(script.pop(0)[1])

    wbc.teleop.run(handler, 0.2, observers=[log], real_time=False, before_tick=submit_due)
    assert [times[0] for times in runs] == [0.0, 0.0]
    assert [times[-1] for times in runs] == pytest.approx([0.048, 0.148])


def test_a_reset_before_the_first_tick_is_done_at_once(handler):
    run = Run(handler, 0.1, [(0.0, ResetCommand())])
    assert run.report.survived
    assert len(run.time) == 50
    assert run.outcomes_of(ResetCommand()) == [ACCEPTED, DONE]


@pytest.mark.parametrize("speed", [0.0, 0.2])
def test_a_hand_goes_to_its_target_and_walks_along(handler, player, speed):
    arm = player.context.upper_body.arms[0]
    origin = player.walker.standing_frame.translation
    shoulder = player.walker.kinematics.frame(arm.shoulder).translation
    target = tuple((shoulder + arm.length * np.array([0.5, 0.15, -0.35])).tolist())
    start = player.walker.kinematics.frame(arm.hand).translation.copy()
    Run(handler, 2.5, [(0.0, VelocityCommand(speed)), (0.1, HandTargetCommand("left", target))])
    hand = player.walker.kinematics.frame(arm.hand).translation
    (quantity,) = (q for q in handler.quantities if q.name == "left_hand_target")
    now = quantity.source(None)
    assert np.linalg.norm(hand - now) < 0.02 < np.linalg.norm(start - target)
    walked = player.walker.standing_frame.translation[0] - origin[0]
    assert now[0] - target[0] == pytest.approx(walked, abs=0.08)
    assert (walked > 0.15) == bool(speed)


def test_standing_lets_go_of_a_hand_and_a_far_target_is_brought_within_reach(handler, player):
    arm = player.context.upper_body.arms[0]
    far = HandTargetCommand("left", (20.0, 0.0, 1.0))
    Run(handler, 0.5, [(0.0, far)])
    hands, walker = player.context.hands, player.walker
    shoulder = walker.kinematics.frame(arm.shoulder).translation
    source = next(q for q in handler.quantities if q.name == "left_hand_target").source
    assert np.linalg.norm(source(None) - shoulder) < arm.length
    assert hands.engaged
    Run(handler, 1.5, [(0.2, StandCommand())])
    assert not hands.engaged
    assert np.isnan(source(None))
    with pytest.raises(CommandRefused, match="no hand on the side 'up'"):
        handler.submit(HandTargetCommand("up", None))
    with pytest.raises(CommandRefused, match="position"):
        handler.submit(HandTargetCommand("left", (math.nan, 0.0, 0.0)))


def test_an_added_task_holds_a_link_until_it_is_removed(handler, player):
    """Beside it a task is switched off, and on again with the ratios of its rows."""
    walker, posture = player.walker, player.walker.posture
    ratios = posture.weight / posture.weight.max()
    held = FrameTaskCommand("left_hand", "position", 50.0)
    seen = []

    def base_to_hand():
        hand = walker.kinematics.frame("left_hand").translation - walker.kinematics.base.translation
        return walker.standing_frame.rotation.T @ hand

    def added():
        return [t.name for t in walker.controller.tasks if t.name.endswith("held")]

    def note(now):
        if len(seen) < 2 and now >= (0.1, 1.4)[len(seen)]:
            seen.append((base_to_hand(), added()))

    script = [
        (0.0, VelocityCommand(0.0, 0.0, 0.3)),
        (0.1, held),
        (0.1, GainCommand("posture", "weight", 0.0)),
        (1.45, GainCommand("posture", "weight", 2.0)),
        (1.45, FrameTaskCommand("left_hand", "position", 0.0)),
    ]

    def submit_due(now):
        note(now)
        while script and now >= script[0][0] - 1e-9:
            handler.submit(script.pop(0)[1])

    report = wbc.teleop.run(handler, 1.5, real_time=False, before_tick=submit_due)
    assert report.survived
    assert report.qp_failures == 0
    (before, none), (after, one) = seen
    assert np.linalg.norm(after - before) < 0.01
    assert (none, one, added()) == ([], ["left_hand position, held"], [])
    np.testing.assert_allclose(posture.weight, 2.0 * ratios)
    handler.submit(held)
    handler.before_tick(0.0)
    assert added() == one
    handler.begin()  # a reset removes it
    assert added() == []
    with pytest.raises(CommandRefused, match="no task can hold 'left_foot'"):
        handler.submit(FrameTaskCommand("left_foot", "position", 1.0))


OTHER_SESSION = StartSessionCommand("talos", "flat", 1)


def with_sessions(player, plant):
    choices = SessionChoices(("talos",), ("flat",), OTHER_SESSION)
    return new_handler(player, plant, sessions=choices)


def test_another_session_ends_this_one_also_where_it_is_paused_or_has_fallen(player, plant):
    for before in ([], [PauseCommand()], [PushCommand((0.0, 2.0 * player.robot.mass, 0.0))]):
        with with_sessions(player, plant) as handler:
            if not before:
                run = Run(handler, 3.0, [(0.1, OTHER_SESSION)])
                assert run.time[-1] == pytest.approx(0.098)
            else:
                wanted = client(lambda _, it=handler: it.submit(OTHER_SESSION))
                run = Run(handler, 3.0, [(0.1, command) for command in before], clients=[wanted])
            assert handler.next_session == OTHER_SESSION
            assert run.report is not None


@pytest.mark.parametrize(
    ("command", "why"),
    [
        (StartSessionCommand("tallos", "flat", 1), "'talos'"),
        (StartSessionCommand("talos", "sea", 1), "no terrain 'sea'"),
        (StartSessionCommand("talos", "flat", -1), "seed = -1"),
        (StartSessionCommand("talos", "flat", 1.5), "seed = 1.5"),
    ],
)
def test_a_session_that_cannot_be_started_is_refused(player, plant, command, why):
    with with_sessions(player, plant) as handler, pytest.raises(CommandRefused, match=why):
        handler.submit(command)


def test_without_choices_no_other_session_is_started(handler):
    with pytest.raises(CommandRefused, match="no other session"):
        handler.submit(OTHER_SESSION)


def test_a_gain_keeps_the_ratios_of_its_rows(handler, player):
    posture = player.walker.posture
    before = posture.weight.copy()
    run = Run(handler, 0.1, [(0.02, GainCommand("posture", "weight", 3.0 * before.max()))])
    assert run.report.qp_failures == 0
    np.testing.assert_allclose(posture.weight, 3.0 * before)


def test_gait_parameters_may_be_set_to_their_bounds_while_it_walks(handler, player):
    script = [(0.0, VelocityCommand(0.15))]
    at = 1.5
    for parameter in handler.capabilities.parameters:
        if parameter.group == "gait":
            for value in (parameter.high, parameter.low, parameter.default):
                name = parameter.name.removeprefix("gait.")
                script.append((at, GaitParameterCommand(name, value)))
                at += 0.4
    run = Run(handler, at + 0.5, script)
    assert run.report.survived, run.report.fell_why
    assert player.walker.gait == wbc.gait.GaitParameters.for_robot(player.robot)


def test_the_robot_survives_random_velocity_commands(handler):
    rng, at, script = np.random.default_rng(2), 0.3, []
    while at < 7.0:
        script.append((at, VelocityCommand(0.2 * float(rng.integers(2)))))
        at += rng.uniform(0.02, 0.5)
    run = Run(handler, 7.0, script)
    assert run.report.survived, run.report.fell_why
    assert run.report.steps > 2


# Tick by tick, without physics.


class PushedPlant:
    """A plant that only notes pushes."""

    time = 0.0

    def __init__(self):
        self.pushes = []

    def push(self, impulse, *, duration):
        self.pushes.append((impulse.tolist(), duration))

    def reset(self):
        pass


@pytest.fixture
def still(player):
    """The handler of a robot that does not move, after its first tick."""
    with new_handler(player, PushedPlant()) as handler:
        handler.begin()
        handler.before_tick(0.0)
        yield handler


def apply(handler, command):
    handler.submit(command)
    handler.before_tick(0.0)


def test_a_velocity_ends_with_its_timeout(still, player, monkeypatch):
    now = 4.0
    clock = SimpleNamespace(monotonic=lambda: now)
    monkeypatch.setattr("wbc.teleop.command_handler.time", clock)
    apply(still, VelocityCommand(0.1, timeout=1.0))
    assert player.velocity == (0.1, 0.0, 0.0)
    now = 4.99
    still.before_tick(0.0)
    assert player.velocity == (0.1, 0.0, 0.0)
    now = 5.01
    still.before_tick(0.0)
    assert player.velocity == (0.0, 0.0, 0.0)


def test_a_velocity_goes_on_while_its_sender_says_that_it_is_there(still, player, monkeypatch):
    now = time.monotonic()
    monkeypatch.setattr(time, "monotonic", lambda: now)
    acks, told = [], []
    still.add_observer(lambda sent, ack: acks.append((type(sent.command), ack.outcome)))
    still.on_timeout = told.append
    number = still.submit(VelocityCommand(0.1, timeout=0.5))
    still.before_tick(0.0)
    for _ in range(4):
        now += 0.4
        still.submit(KeepVelocityCommand(number, 0.5))
        still.submit(KeepVelocityCommand(number + 100, 50.0))  # another velocity's sender
        still.before_tick(0.0)
        assert player.walker.velocity[0] == 0.1
    now += 0.51
    still.before_tick(0.0)
    assert player.walker.velocity[0] == 0.0
    assert acks == [
        (VelocityCommand, CommandOutcome.ACCEPTED),
        (VelocityCommand, CommandOutcome.ABORTED),
    ]
    assert told == ["nothing more came from the script: the robot stops and stands"]
    still.submit(KeepVelocityCommand(number, 0.5))
    still.before_tick(0.0)
    assert player.walker.velocity[0] == 0.0


def test_a_reset_discards_earlier_commands_except_parameters(still, player):
    acks = []
    still.add_observer(lambda sent, ack: acks.append((type(sent.command), ack.outcome)))
    apply(still, VelocityCommand(0.1))
    still.submit(ResetCommand())
    with pytest.raises(StopRun, match="reset"):
        still.before_tick(0.0)
    assert still.reset_wanted
    still.submit(VelocityCommand(0.2))
    still.submit(GainCommand("com", "weight", 1234.0))
    still.begin()
    for _ in range(2):
        still.before_tick(0.0)
        player.reset(player.robot.standing())
        assert player.velocity == (0.0, 0.0, 0.0)
    assert not still.reset_wanted
    assert player.walker.com.weight[0] == 1234.0
    assert acks[1:] == [
        (ResetCommand, ACCEPTED),
        (VelocityCommand, SUPERSEDED),
        (GainCommand, ACCEPTED),
        (ResetCommand, DONE),
    ]
    apply(still, VelocityCommand(0.1))
    assert player.velocity == (0.1, 0.0, 0.0)


def test_joints_move_no_faster_than_they_may_and_arrive(still, robot, player):
    elbow, posture = robot.joint_index("left_elbow"), player.context.posture
    start = posture.value.copy()
    target = start[elbow] + 0.01
    apply(still, JointCommand(("left_elbow",), (target,), max_speed=0.5))
    assert posture.value[elbow] - start[elbow] == pytest.approx(0.5 * player.dt)
    for _ in range(20):
        still.before_tick(0.0)
    assert posture.value[elbow] == pytest.approx(target)
    others = np.arange(robot.na) != elbow
    assert np.array_equal(posture.value[others], start[others])


def test_joints_arrive_at_the_end_of_the_commanded_duration(still, robot, player):
    elbow, posture = robot.joint_index("left_elbow"), player.context.posture
    start = posture.value[elbow]
    apply(still, JointCommand(("left_elbow",), (start + 0.1,), duration=100.0))
    assert 0.0 < posture.value[elbow] - start < 1e-5


def until_playing(handler, player):
    """Ticks of a robot that does not move, until a motion plays."""
    estimate = wbc.Estimate(player.robot.standing())
    for _ in range(round(20.0 / player.dt)):
        player.step(estimate)
        handler.before_tick(0.0)
        if handler.playing is not None:
            return
    raise AssertionError("no motion plays")


def test_joints_wait_until_a_motion_is_over(still, robot, player):
    elbow, posture = robot.joint_index("left_elbow"), player.context.posture
    home = posture.home[elbow]
    apply(still, MotionCommand(Squat()))
    until_playing(still, player)
    apply(still, JointCommand(("left_elbow",), (home + 0.2,), max_speed=0.5))
    assert not player.idle
    assert posture.home[elbow] == home
    player.reset(robot.standing())
    still.before_tick(0.0)
    assert posture.home[elbow] == pytest.approx(home + 0.5 * player.dt)


def test_a_push_is_given_once(still):
    apply(still, PushCommand((0.0, 5.0, 0.0), 0.2, "world"))
    for _ in range(3):
        still.before_tick(0.0)
    assert still.plant.pushes == [([0.0, 5.0, 0.0], 0.2)]


def test_nothing_is_checked_or_planned_in_the_loop(still, player, monkeypatch):
    motions = [
        unpack(pack(motion, player.robot), player.robot) for motion in (Squat(), Reach(), Wave())
    ]
    for kind in MOTIONS:
        monkeypatch.setattr(kind, "check", None)
    for motion in motions:
        apply(still, MotionCommand(motion))
        until_playing(still, player)
        still.submit(StandCommand())


def test_commands_of_other_threads_are_all_applied(still, player):
    acks = []
    still.add_observer(lambda sent, ack: acks.append(sent.id))

    def submit():
        for _ in range(100):
            still.submit(VelocityCommand(0.1))

    threads = [threading.Thread(target=submit) for _ in range(3)]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        still.before_tick(0.0)
    still.before_tick(0.0)
    assert sorted(acks) == list(range(1, 301))


# Validation.


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (VelocityCommand(math.nan), "velocity.forward = nan is out of range"),
        (VelocityCommand(100.0), "velocity.forward = 100.0 is out of range: -"),
        (VelocityCommand("fast"), "velocity.forward is 'fast'; it is a number"),
        (VelocityCommand(True), "it is a number"),
        (VelocityCommand(10**400), "out of range"),
        (VelocityCommand(0.1, timeout=-1.0), "timeout = -1.0"),
        (PushCommand((0.0, 1e9, 0.0)), "push = 1000000000.0 is out of range"),
        (PushCommand((math.nan, 0.0, 0.0)), "push = nan"),
        (PushCommand((1.0, 2.0)), r"it is \(x, y, z\) in N·s"),
        (PushCommand(5.0), r"it is \(x, y, z\) in N·s"),
        (PushCommand((1.0, 0.0, 0.0), duration=0.0), "duration = 0.0"),
        (PushCommand((1.0, 0.0, 0.0), frame="torso"), "'world' or 'heading'"),
        (GaitParameterCommand("swing_hight", 0.1), "did you mean 'gait.swing_height'"),
        (GaitParameterCommand("swing_height", -0.1), "out of range: 0.0"),
        (GainCommand("com", "weight", 1.0), "com.weight = 1.0 is out of range: 300 to 30000"),
        (GainCommand("comm", "weight", 1.0), "no parameter 'comm.weight'; did you mean"),
        (GainCommand("gait", "swing_height", 0.08), "'gait' is not a task"),
        (GainCommand("velocity", "forward", 0.1), "'velocity' is not a task"),
        (MotionCommand(AbortingMotion()), "no motion 'aborting'"),
        (MotionCommand("squat"), "no motion 'squat'"),
        (JointCommand(("left_knee",), (1.0,)), "joint of a leg, which the gait needs"),
        (JointCommand(("left_elbo",), (1.0,)), "did you mean 'left_elbow'"),
        (JointCommand(("left_elbow",) * 2, (1.0, 1.0)), "named twice"),
        (JointCommand(("left_elbow",), ()), "1 joints have 0 positions"),
        (JointCommand((), ()), "names no joints"),
        (JointCommand(("left_elbow",), (99.0,)), "left_elbow = 99.0 is out of range"),
        (PauseCommand(1), "it is true or false"),
        ("walk", "'walk' is not a command"),
    ],
)
def test_an_invalid_command_is_refused_with_the_reason(still, command, words):
    with pytest.raises(CommandRefused, match=words):
        still.submit(command)


def test_a_value_at_its_bound_is_accepted(still):
    for parameter in still.capabilities.parameters:
        group, _, name = parameter.name.partition(".")
        for value in (parameter.low, parameter.high, parameter.default):
            if group == "velocity":
                still.submit(VelocityCommand(**{name: value}))
            elif group == "gait":
                still.submit(GaitParameterCommand(name, value))
            else:
                still.submit(GainCommand(group, name, value))
    still.submit(PushCommand((0.0, -still.capabilities.max_impulse, 0.0)))


def test_each_task_has_a_parameter_and_each_motion_is_offered(still, player):
    names = [parameter.name for parameter in still.capabilities.parameters]
    for task in player.walker.tasks:
        assert f"{task.name}.weight" in names
    assert {"velocity.forward", "velocity.left", "velocity.turn"} <= set(names)
    assert {"gait.single_support", "gait.swing_height", "gait.step_width"} <= set(names)
    assert len(set(names)) == len(names)
    assert still.capabilities.motions == MOTIONS


def test_a_velocity_that_a_robot_does_not_have_is_refused_as_such():
    turn = next(
        p for p in tunable_parameters(wbc.Walker(wbc.load("bolt")), False) if "turn" in p.name
    )
    assert f"{turn.low} {turn.high}" == "0.0 0.0"
    assert turn.check(0.0) == 0.0
    with pytest.raises(
        CommandRefused, match=r"velocity\.turn = 0\.3 is out of range: it can only be 0"
    ):
        turn.check(0.3)


def test_pushes_and_resets_are_refused_where_the_plant_has_none(player):
    with new_handler(player, SimpleNamespace(time=0.0)) as handler:
        with pytest.raises(CommandRefused, match="cannot be pushed"):
            handler.submit(PushCommand((0.0, 1.0, 0.0)))
        with pytest.raises(CommandRefused, match="cannot be reset"):
            handler.submit(ResetCommand())


def test_a_motion_that_another_process_could_not_import_is_refused_with_the_cure(player, plant):
    class Hidden(AbortingMotion):
        name = "hidden"

    with pytest.raises(MotionError, match=r"'hidden' is defined where .* module of its own"):
        new_handler(player, plant, motions=(Hidden,))
