"""Motions in physics: from standing to standing, interrupted, blended, evaluated by the truth."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from cases import slow
from coretools import robot

import wbc
from wbc.errors import MotionError
from wbc.motions import Motion, MotionContext, MotionPlayer, MotionReference, Script
from wbc.motions.bow import Bow
from wbc.motions.brace import Brace
from wbc.motions.carry import Carry
from wbc.motions.demo import DEMO_MOTIONS, Demo
from wbc.motions.hold_hand import HoldHand
from wbc.motions.jump import Jump
from wbc.motions.keyframes import Keyframes
from wbc.motions.look import Look
from wbc.motions.one_leg import OneLeg
from wbc.motions.push_cart import PushCart
from wbc.motions.reach import Reach
from wbc.motions.registry import MOTIONS, find_motion
from wbc.motions.sine import Sine
from wbc.motions.squat import Squat
from wbc.motions.step_in_place import StepInPlace
from wbc.motions.sway import Sway
from wbc.motions.wave import Wave
from wbc.robot.fall import fall_reason
from wbc.sim import Mujoco
from wbc.trials import RunEvaluator, run_motions

#: Share of its torque limit by which a joint's torque may change in a tick because a motion is
#: interrupted, begun or blended over: a joint has its whole torque in 0.1 s at the soonest.
JUMP = 0.02


def assert_clean(report: wbc.Report) -> None:
    assert report.survived, report.table()
    assert report.qp_failures == 0, report.explanation
    assert report.joint_limit_excess_rad <= 1e-3
    assert report.torque_excess_nm <= 0.0
    assert report.foot_slip_mm < 5.0


@pytest.mark.parametrize(
    ("name", "motion", "error"),
    [
        ("talos", Sway(rounds=1.5), 6.0),
        ("g1", Sway(rounds=1.5, shape="eight"), 6.0),
        ("simple_humanoid", Squat(times=2), 5.0),
        ("g1", Squat(times=1), 5.0),
        ("simple_humanoid", Bow(hold=0.2), 6.0),
        ("simple_humanoid", Look(seconds=3.0), 6.0),
        ("simple_humanoid", Sine(seconds=2.0), 6.0),
    ],
    ids=lambda x: x.name if isinstance(x, Motion) else str(x),
)
def test_motion_tracks_its_com_and_returns_to_standing(name, motion, error):
    players = []
    report = run_motions(
        robot(name),
        [motion],
        seed=3,
        before_tick=lambda t, player, _: players.append(player),
    )
    assert_clean(report)
    assert report.com_error_rms_mm < error
    assert report.steps == 0
    context = players[-1].context
    assert context.at_home
    assert players[-1].idle
    assert np.abs(context.walker.kinematics.state.v).max() < 0.3


def test_squat_reaches_its_depth_and_locks_no_knee():
    one, depths, knees = robot("simple_humanoid"), [], []
    knee = one.joint_index("left_knee")

    def look(time, player, plant):
        truth = plant.ground_truth()
        depths.append(wbc.Kinematics(one, truth).p_com[2])
        knees.append(truth.q[7 + knee])

    report = run_motions(one, [Squat(depth=15.0, frequency=0.5, times=1)], before_tick=look)
    assert_clean(report)
    went = depths[-1] - min(depths)
    assert went == pytest.approx(0.15 * one.leg_length, abs=0.006)
    assert max(depths) < depths[0] + 0.005
    assert min(knees) > 0.3


def test_one_leg_lifts_holds_against_a_push_and_puts_down():
    one, heights, pushed = robot("simple_humanoid"), [], []

    def look(time, player, plant):
        truth = wbc.Kinematics(one, plant.ground_truth())
        heights.append(truth.frame("left_sole").translation[2])
        pushed.extend(player.context.pushes)

    motion = OneLeg(leg="right", hold=1.6, towards=-90.0)
    report = run_motions(one, [motion], seed=1, before_tick=look)
    assert_clean(report)
    assert report.com_error_rms_mm < 6.0
    assert max(heights) == pytest.approx(0.08 * one.leg_length, abs=0.01)
    assert sum(h > 0.05 for h in heights) * 0.002 > 1.5
    assert abs(heights[-1]) < 0.002
    assert len(pushed) == 1
    assert pushed[0] == pytest.approx([0.0, -0.05, 0.0], abs=1e-9)


@pytest.mark.slow
def test_hands_wave_above_the_shoulders_while_it_walks():
    one, above = robot("simple_humanoid"), []

    def look(time, player, plant):
        truth = wbc.Kinematics(one, plant.ground_truth())
        above.append(
            min(
                truth.frame(f"{side}_hand").translation[2]
                - truth.frame(f"{side}_upper_arm").translation[2]
                for side in ("left", "right")
            )
        )

    report = run_motions(one, [Wave(walk=0.3, seconds=2.0)], before_tick=look)
    assert_clean(report)
    assert report.displacement_m[0] > 0.4
    assert sum(a > 0.0 for a in above) * 0.002 > 2.0


@pytest.mark.slow
def test_hands_reach_positions_and_a_note_names_those_out_of_reach():
    report = run_motions(
        robot("simple_humanoid"), [Reach(random=2, place_seed=5, hold=0.4)], seed=2
    )
    assert_clean(report)
    assert (report.targets, report.targets_reached) == (4, 4)
    assert report.target_error_max_mm < 10.0
    far = run_motions(robot("simple_humanoid"), [Reach(left=(0.9, 0.2, 1.2), hold=0.2)])
    assert_clean(far)
    assert far.targets == 0
    assert "left hand: (0.9 0.2 1.2) m is out of reach by" in far.notes[0]
    assert far.notes[0].endswith(("at the limit", "is stretched"))


@dataclass(frozen=True)
class TwoSteps(Motion):
    name: ClassVar[str] = "two-steps"
    summary: ClassVar[str] = "walk until two feet have landed"

    def play(self, context: MotionContext) -> Script:
        context.feet.walk((0.2, 0.0, 0.0))
        for step in (1, 2):
            yield from context.feet.until_touchdown()
            context.note(f"{step}: {context.walker.steps} after {context.time:.2f} s")
        context.feet.walk((0.0, 0.0, 0.0))
        yield from context.until(lambda: context.standing)
        began = context.time
        yield from context.feet.until_touchdown(timeout=0.5)  # none comes
        context.note(f"waited {context.time - began:.2f} s")


def test_motion_script_waits_for_touchdowns():
    report = run_motions(robot("simple_humanoid"), [TwoSteps()], seed=1)
    assert_clean(report)
    first, second, waited = report.notes
    assert first.startswith("1: 1 after")
    assert second.startswith("2: 2 after")
    assert 3 <= report.steps <= 4
    assert waited == "waited 0.50 s"


def test_steps_in_place_stay_in_place():
    report = run_motions(robot("simple_humanoid"), [StepInPlace(steps=3)])
    assert_clean(report)
    assert report.steps == 3
    assert np.hypot(*report.displacement_m) < 0.03


def test_fall_of_the_open_loop_pattern_is_reported_with_its_time():
    report = run_motions(robot("simple_humanoid"), [Sine(open_loop=True)])
    assert not report.survived
    assert 1.0 < report.fell_at_s < 10.0
    assert report.fell_why in report.table()


@dataclass(frozen=True)
class Mixture(Motion):
    """Everything at once, to be broken off anywhere."""

    name: ClassVar[str] = "mixture"
    summary: ClassVar[str] = "for these tests"

    def play(self, context: MotionContext) -> Script:
        context.com.follow(lambda t: 0.02 * np.array([np.sin(3 * t), np.cos(3 * t), np.sin(4 * t)]))
        context.turn_trunk((0.0, 0.15, 0.3), 0.6)
        context.hands.reach("left", (0.35, 0.2, 1.1), 0.8)
        yield from context.wait(1.3)
        context.hands.release(side="left")
        context.com.move_to(0.0, 0.6)
        yield from context.feet.lift("left", 0.05, 0.6)
        yield from context.wait(1.0)


#: Every motion, shortened; the open-loop one comes last, for it may fall.
PROGRAMME = (
    Sway(rounds=1.0),
    Squat(times=1),
    Wave(seconds=1.5, walk=0.2),
    Reach(random=1),
    Look(seconds=2.0),
    OneLeg(leg="left", hold=0.6),
    Bow(hold=0.1),
    StepInPlace(steps=2),
    Sine(seconds=1.5),
    Jump(),
    Sine(open_loop=True, seconds=0.5),
)
OTHERS = (Squat(), Bow(), Look(), Wave(), Reach(random=1), Sway(), Sine())


def answer(player: MotionPlayer, order: Callable[[], None], estimate: wbc.Estimate) -> np.ndarray:
    """Torques of this tick if an order were given; in a process of its own, so none is."""
    end, begin = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            order()
            os.write(begin, player.step(estimate).tau.tobytes())
        finally:
            os._exit(0)
    os.close(begin)
    with open(end, "rb") as pipe:
        torque = np.frombuffer(pipe.read())
    os.waitpid(child, 0)
    return torque


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="a tick is tried out in a forked process")
def test_interrupting_or_blending_any_motion_keeps_torque_steps_within_the_bound():
    one, random, asked = robot("simple_humanoid"), np.random.default_rng(7), {}
    for motion in OTHERS:
        motion.prepare(one)
    player = MotionPlayer(one, motions=PROGRAMME)

    def blend(motion: Motion) -> Callable[[], None]:
        return lambda: player.blend(motion)

    orders = (*[player.interrupt] * len(OTHERS), *map(blend, OTHERS))
    with Mujoco(one, seed=4) as plant:
        estimator = wbc.Estimator(one, plant.dt)
        estimator.reset(plant.ground_truth())
        player.reset(plant.ground_truth())
        expected = before = None
        while not player.idle and not fall_reason(one, plant.ground_truth()):
            measurement = plant.measure()
            estimate = estimator.update(measurement, acceleration=expected)
            playing, tried = player.playing, None
            if playing is not None and random.random() < 0.012:
                tried = answer(player, random.choice(orders), estimate)
            command = player.step(estimate)
            expected = command.acceleration
            plant.step(command)
            if tried is not None:
                change = np.abs(tried - command.tau) / one.tau_max
                bound = JUMP
                if before is not None and set(command.wrenches) > set(before.wrenches):
                    # A foot lands, which changes torques by itself; by more no order does.
                    bound = (np.abs(command.tau - before.tau) / one.tau_max).max()
                assert change.max() < bound, (plant.time, playing, change.argmax())
                asked[playing] = asked.get(playing, 0) + 1
            before = command
    assert set(asked) == set(PROGRAMME)
    assert sum(asked.values()) > 150


def test_changing_contacts_keeps_forces_and_torques_continuous():
    one = robot("simple_humanoid")
    player = MotionPlayer(one, motions=[Mixture()])
    quiet = wbc.sim.SensorNoise.none()
    changes, before = [], None
    with Mujoco(one, noise=quiet, ground_truth=True) as plant:
        player.reset(plant.ground_truth())
        estimator = wbc.GroundTruthEstimator(one)
        while plant.time < 9.0 and not player.idle:
            measurement = plant.measure()
            command = player.step(estimator.update(measurement))
            plant.step(command)
            now = (
                set(command.wrenches),
                sum(w[:3] for w in command.wrenches.values()),
                command.tau,
            )
            if before is not None and before[0] != now[0]:
                changes.append((now[0], now[1] - before[1], now[2] - before[2]))
            before = now
        assert player.idle
    assert [len(contacts) for contacts, _, _ in changes] == [1, 2]  # lifted, put down
    for _, force, torque in changes:
        # The weight is carried by whatever is left, and no joint feels the change.
        assert np.linalg.norm(force) < 0.05 * one.weight
        assert (np.abs(torque) / one.tau_max).max() < 0.06


@pytest.mark.parametrize(
    ("motion", "moment"),
    [
        (Mixture(), 0.83),
        slow(Mixture(), 2.9),
        slow(Mixture(), 4.1),
        (Wave(walk=0.3), 2.17),
        (StepInPlace(), 1.9),
        slow(Sway(size=0.05, frequency=0.5), 1.31),
    ],
    ids=lambda x: getattr(x, "name", str(x)),
)
def test_an_interrupted_motion_returns_to_standing_and_the_next_begins(motion, moment):
    def interrupt(time, player, plant):
        if abs(time - moment) < 1e-6:
            player.interrupt(Squat(times=1, frequency=1.0, depth=6.0))

    one = robot("simple_humanoid")
    report = run_motions(one, [motion], seed=int(1000 * moment), before_tick=interrupt)
    assert_clean(report)
    assert report.duration_s < moment + 9.0


def test_motions_play_in_order_and_one_may_replace_another():
    one, seen = robot("simple_humanoid"), []

    def look(time, player, plant):
        if player.playing is not None and player.playing.name not in seen:
            seen.append(player.playing.name)
        if abs(time - 0.5) < 1e-6:
            player.play(Bow(angle=15.0, seconds=0.8, hold=0.1))
        if abs(time - 1.2) < 1e-6:
            player.blend(Squat(times=1, frequency=1.0, depth=6.0))

    report = run_motions(one, [Sway(rounds=2)], before_tick=look)
    assert_clean(report)
    assert seen == ["sway", "squat"]  # what waited is forgotten


def test_player_walks_identically_to_the_walker():
    one = robot("simple_humanoid")
    player = MotionPlayer(one)

    def steer(time):
        player.velocity = (0.3, 0.0, 0.0) if 0.2 < time < 2.5 else (0.0, 0.0, 0.0)

    with Mujoco(one, seed=3) as plant:
        report = wbc.run(player, plant, 5.2, before_tick=steer)
    assert report.survived
    assert report.displacement_m[0] > 0.4
    assert player.context.at_home
    assert player.telemetry.phase == "stand"


def test_motions_that_a_robot_cannot_do_are_refused_with_the_bound():
    with pytest.raises(MotionError, match=r"squat: g1 .*ankle_pitch.* limit, and 2\d\.\d % is the"):
        MotionPlayer(robot("g1"), motions=[Squat(depth=40.0)])
    with pytest.raises(MotionError, match=r"sway: the circle .* size at most 0\.0\d\d m"):
        MotionPlayer(robot("g1")).play(Sway(size=0.2))
    with pytest.raises(MotionError, match=r"bow: romeo cannot bow by 80°"):
        Bow(angle=80.0).check(robot("romeo"))
    with pytest.raises(MotionError, match=r"look: talos .* 7\d° down, which is \d+° more"):
        Look(point=(0.4, 0.0, 0.0), radius=0.0).check(robot("talos"))
    with pytest.raises(MotionError, match=r"reach: left = .* finite"):
        Reach(left=(np.nan, 0.0, 0.0)).check(robot("talos"))
    with pytest.raises(MotionError, match=r"frequency = -1\.0 must be positive"):
        Sway(frequency=-1.0).check(robot("talos"))
    with pytest.raises(MotionError, match=r"bow: simple_humanoid .* pelvis would tilt by 60°"):
        Bow(angle=60.0).check(robot("simple_humanoid"))
    with pytest.raises(MotionError, match="sway: no shape 'cycle'; did you mean 'circle'"):
        Sway(shape="cycle").prepare(robot("talos"))
    with pytest.raises(MotionError, match="wave: walk = nan must be finite"):
        Wave(walk=np.nan).prepare(robot("talos"))


def test_foot_commands_in_the_wrong_stance_are_refused():
    context = MotionPlayer(robot("simple_humanoid")).context
    with pytest.raises(MotionError, match="no foot is lifted"):
        next(context.feet.move_foot())
    context.stance.weight_shift.move_to(1.0, 0.1)
    for _ in range(5):
        context.stance.weight_shift.advance(0.002)
    with pytest.raises(MotionError, match="weight in the middle"):
        context.feet.walk((0.2, 0.0, 0.0))


def test_the_registry_names_every_motion_once_and_the_demo_plays_all_of_them():
    names = [motion.name for motion in MOTIONS]
    assert len(set(names)) == len(names)
    asked = ("sway", "squat", "wave", "reach", "look", "one-leg", "bow", "step-in-place")
    assert {*asked, "sine", "jump", "demo", "keyframes"} <= set(names)
    assert set(MOTIONS) - set(DEMO_MOTIONS) == {Brace, Carry, Demo, HoldHand, Keyframes, PushCart}
    assert all(motion.summary and motion.__doc__ for motion in MOTIONS)
    with pytest.raises(MotionError, match="no motion 'squad'; did you mean 'squat'"):
        find_motion("squad")


class OffsetPlayer(MotionPlayer):
    """Promises to lean three centimetres forward, and stands."""

    @property
    def reference(self) -> MotionReference:
        promised = super().reference
        return replace(promised, com=promised.com + np.array([0.03, 0.0, 0.0]))


def test_evaluator_compares_references_with_the_true_state():
    one = robot("simple_humanoid")
    player, evaluator = OffsetPlayer(one), RunEvaluator()
    with Mujoco(one, seed=0) as plant:
        report = wbc.run(player, plant, 1.0, observers=[evaluator])
    assert report.com_error_rms_mm is None
    evaluated = evaluator.amend(report)
    assert evaluated.com_error_rms_mm == pytest.approx(30.0, abs=5.0)
    assert "CoM tracking error" in evaluated.table()
