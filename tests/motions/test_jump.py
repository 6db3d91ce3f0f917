"""Jumps in physics: noise on every sensor, the estimator in the loop, judged by the truth."""

from functools import cache

import pytest

import wbc
from wbc.motions import MotionPlayer
from wbc.motions.jump import Jump
from wbc.motions.jumping import JumpController, JumpPhase
from wbc.runtime.report import Report
from wbc.sim import Mujoco
from wbc.trials import run_motions
from wbc.walking import Walker

CLEARANCE = 0.05
JUMP = Jump(CLEARANCE)  # keeps the plans of its robots


@cache
def robot(name: str) -> wbc.Robot:
    return wbc.load(name)


def keeps_limits(report: Report) -> bool:
    return (
        report.qp_failures == 0
        and report.torque_excess_nm <= 0.0
        and report.torque_peak_ratio <= 1.0
        and report.joint_limit_excess_rad <= 1e-3
    )


@pytest.mark.parametrize("name", [pytest.param("talos", marks=pytest.mark.slow), "g1"])
def test_robot_jumps_with_the_clearance_and_lands_standing(name):
    report = run_motions(robot(name), [JUMP], seed=3)
    assert report.survived
    assert keeps_limits(report)
    (flight,) = report.flights
    assert 45.0 < flight.clearance_mm < 60.0
    assert flight.rise_mm == pytest.approx(1e3 * flight.take_off_speed_m_s**2 / 19.62, abs=1.5)
    assert flight.rise_mm == pytest.approx(1e3 * JUMP.plan(robot(name)).rise, abs=4.0)
    assert flight.duration_s == pytest.approx(JUMP.plan(robot(name)).flight.duration, abs=0.02)
    assert flight.landing_error_mm < 15.0
    assert flight.landing_load < 3.0
    legs = robot(name).mass * JUMP.plan(robot(name)).speed * robot(name).leg_length
    assert flight.spin < 0.01 * legs, "it takes off without spin"
    assert flight.spin_change < 0.002 * legs, "and nothing changes that in the air"
    assert report.foot_slip_mm is not None
    assert report.foot_slip_mm < 5.0


def interrupt_in(phase: JumpPhase) -> Report:
    def interrupt(_: float, player: MotionPlayer, plant: Mujoco) -> None:
        override = player.context.override
        if (
            isinstance(override, JumpController)
            and override.phase is phase
            and player.playing is not None
        ):
            player.interrupt()

    return run_motions(robot("simple_humanoid"), [JUMP], seed=2, before_tick=interrupt)


@pytest.mark.slow
def test_interrupted_crouch_returns_to_standing_without_a_jump():
    report = interrupt_in(JumpPhase.CROUCH)
    assert report.survived
    assert keeps_limits(report)
    assert report.flights == ()


@pytest.mark.slow
def test_jump_interrupted_in_flight_is_completed():
    report = interrupt_in(JumpPhase.FLIGHT)
    assert report.survived
    assert keeps_limits(report)
    assert len(report.flights) == 1


@pytest.mark.slow
def test_push_in_flight_moves_the_landing_place_to_keep_balance():
    push = 0.03 * robot("simple_humanoid").mass  # N·s, forward

    def shove(_: float, player: MotionPlayer, plant: Mujoco) -> None:
        override = player.context.override
        if (
            isinstance(override, JumpController)
            and override.phase is JumpPhase.FLIGHT
            and not plant.push_force.any()
        ):
            if not pushed:
                plant.push((push, 0.0, 0.0), duration=0.02)
            pushed.append(True)

    pushed: list[bool] = []
    report = run_motions(robot("simple_humanoid"), [JUMP], seed=2, before_tick=shove)
    assert pushed
    assert report.survived
    assert keeps_limits(report)
    (flight,) = report.flights
    assert flight.landing_error_mm > 4.0, "it landed ahead of where it left"


def test_player_forwards_the_telemetry_of_an_override():
    player = MotionPlayer(robot("simple_humanoid"), motions=[])
    context = player.context
    controller = JumpController(context.robot, JUMP.plan(context.robot), context.dt)
    controller.reset(context.robot.standing())
    context.start_override(controller)
    controller.step(wbc.Estimate(context.robot.standing()))
    assert player.telemetry.com == pytest.approx(controller.telemetry.com)
    assert player.dcm_error == controller.dcm_error


def test_jump_controller_uses_the_walkers_solver():
    body_of = robot("simple_humanoid")
    player = MotionPlayer(body_of, walker=Walker(body_of, solver="daqp"))
    player.play(JUMP)
    for _ in range(1000):
        player.step(wbc.Estimate(body_of.standing()))
        if player.context.override is not None:
            break
    assert player.context.override._tasks.controller.solver.name == "daqp"
