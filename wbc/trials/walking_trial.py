"""Seeded trials of walking scenarios in physics."""

from __future__ import annotations

from wbc.estimation import GroundTruthEstimator
from wbc.robot import Robot
from wbc.runtime.loop import run
from wbc.runtime.protocols import StateEstimator
from wbc.runtime.report import Report
from wbc.sim import Mujoco
from wbc.state import State
from wbc.trials.scenario import Scenario
from wbc.walking import Walker


def run_scenario(
    robot: Robot,
    scenario: Scenario,
    seed: int,
    *,
    walker: Walker | None = None,
    estimator: StateEstimator | None = None,
    start: State | None = None,
    foot_sensors: bool = True,
    friction: float = 0.8,
) -> Report:
    """Run a scenario in MuJoCo with noisy sensors and the base-state estimator.

    Args:
        robot: the robot.
        scenario: the walk and what counts as success.
        seed: seed of the sensor noise.
        walker: its controller; `Walker(robot)` by default.
        estimator: its state estimator; by default the filter on noisy sensors. A
            `GroundTruthEstimator` gets the exact state.
        start: initial state; by default the robot stands at the origin.
        foot_sensors: the soles have force sensors; without them the joints' torques are measured.
        friction: Coulomb coefficient between soles and ground.
    """
    walker = walker or Walker(robot)

    def command(time: float) -> None:
        walker.velocity = scenario.velocity_at(time)

    truth = isinstance(estimator, GroundTruthEstimator)
    with Mujoco(
        robot,
        dt=walker.dt,
        friction=friction,
        seed=seed,
        ground_truth=truth,
        foot_sensors=foot_sensors,
    ) as plant:
        if start is not None:
            plant.reset(start)
        return run(walker, plant, scenario.duration, estimator=estimator, before_tick=command)
