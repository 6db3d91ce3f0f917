"""One run of the tour in MuJoCo."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

from wbc.estimation import Estimator, GroundTruthEstimator
from wbc.gait import VelocityLimits
from wbc.geometry.planar import Placement, ground_point
from wbc.robot import Robot, load
from wbc.robot.attitude import heading
from wbc.runtime.loop import run
from wbc.runtime.protocols import StateEstimator, VelocityController
from wbc.sim import Mujoco
from wbc.trials.controllers import ControllerSpec
from wbc.trials.tour.arms import ArmMotion, TourController
from wbc.trials.tour.schedule import Tour, TourParameters, draw_tour
from wbc.walking import VelocityClamped, Walker, WaypointFollower

_DT = 0.002  # s, the control period
_COMMAND_PERIOD = 0.02  # s
_SPEED_SHARE = 0.6  # of a walker's largest velocity: what is left catches punches


@dataclass(frozen=True, slots=True)
class TourResult:
    """The outcome of one run of the tour.

    Attributes:
        seed: seed of the tour and of the sensor noise.
        completed: whether the robot was on its feet at the end.
        survived: time until the end or the fall, s.
        position_error: mean distance from each waypoint when its time was over, m.
        yaw_error: mean angle between heading and wanted heading then, rad.
        fall: why the robot counts as fallen; empty if it does not.
        last_punch: the last punch before the end.
    """

    seed: int
    completed: bool
    survived: float
    position_error: float
    yaw_error: float
    fall: str
    last_punch: str


class _TourEvents:
    """Gives waypoints, moves the arms and punches at the times of a tour.

    Args:
        tour: the tour.
        plant: the robot.
        controller: its controller.
        limits: largest velocities to command.
    """

    def __init__(
        self, tour: Tour, plant: Mujoco, controller: TourController, limits: VelocityLimits
    ) -> None:
        self._tour, self._plant, self._controller = tour, plant, controller
        self._limits = limits
        self._follower = WaypointFollower(limits)
        self._start = tour.parameters.standing_time
        self._every = round(_COMMAND_PERIOD / plant.dt)
        self._ticks = 0
        self._origin: Placement | None = None
        self._waypoint = -1
        self._punches = list(tour.punches)
        self._error = Placement(0j, 0.0)
        self.errors: list[Placement] = []
        self.last_punch = ""

    def before_tick(self, time: float) -> None:
        """Command the controller, and punch the robot."""
        elapsed = time - self._start
        if elapsed < -1e-9:
            return
        self._controller.time = max(elapsed, 0.0)
        punches, parameters = self._punches, self._tour.parameters
        if punches and elapsed >= punches[0].time - 1e-9:
            punch = punches.pop(0)
            impulse = parameters.punch_duration * punch.force
            self._plant.push(impulse, duration=parameters.punch_duration, frame=punch.joint)
            self.last_punch = str(punch)
        if self._ticks % self._every == 0:
            self._command(elapsed)
        self._ticks += 1

    def _command(self, elapsed: float) -> None:
        pose = self._pose()
        if self._origin is None:
            self._origin = pose
        parameters = self._tour.parameters
        index = min(int(elapsed / parameters.segment + 1e-9), parameters.waypoints - 1)
        if index != self._waypoint:
            self.finish()
            self._waypoint = index
            self._follower = WaypointFollower(self._limits)
        goal = self._origin.compose(self._tour.waypoints[index])
        self._error = goal.relative_to(pose)
        self._controller.velocity = self._follower.velocity(goal, pose)

    def finish(self) -> None:
        """Record the error at the end of a waypoint's time."""
        if self._waypoint >= 0:
            self.errors.append(self._error)

    def _pose(self) -> Placement:
        state = self._plant.ground_truth()
        return Placement(ground_point(state.q), heading(self._plant.robot, state))


def run_tour(
    robot: Robot,
    controller: VelocityController,
    tour: Tour,
    *,
    plant: Mujoco | None = None,
    estimator: StateEstimator | None = None,
) -> TourResult:
    """Run a tour in MuJoCo.

    The waypoints are given relative to the robot's true pose, as by an operator or motion capture;
    everything else the controller knows from the estimator.

    Args:
        robot: the robot.
        controller: walks at a velocity. A `Walker` is told at most 60 % of what its gait can do.
        tour: waypoints, punches and the seed of the arms' motion and the sensor noise.
        plant: the simulated robot; made when left out.
        estimator: measurement to estimate; the filter on noisy sensors by default.
    """
    parameters = tour.parameters
    truth = isinstance(estimator, GroundTruthEstimator)
    if plant is None:
        plant = Mujoco(
            robot, dt=_DT, seed=tour.seed, ground_truth=truth, friction=parameters.friction
        )
    toured = TourController(controller, ArmMotion(robot, tour.seed), plant)
    events = _TourEvents(tour, plant, toured, _limits(controller))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VelocityClamped)
        report = run(
            toured,
            plant,
            parameters.standing_time + parameters.duration,
            estimator=estimator or Estimator(robot, plant.dt),
            before_tick=events.before_tick,
        )
    events.finish()
    errors = events.errors or [Placement(0j, 0.0)]
    survived = report.duration_s - parameters.standing_time
    return TourResult(
        tour.seed,
        report.survived,
        parameters.duration if report.survived else max(survived, 0.0),
        sum(abs(error.point) for error in errors) / len(errors),
        sum(abs(error.yaw) for error in errors) / len(errors),
        report.fell_why,
        events.last_punch,
    )


def simulate_tour(
    robot: str, controller: ControllerSpec, seed: int, parameters: TourParameters
) -> TourResult:
    """Load a robot and run the tour of a seed with a controller; for other processes.

    Args:
        robot: name of a robot, or path of a URDF or robot data file.
        controller: the controller.
        seed: seed of the tour.
        parameters: parameters of the tour.
    """
    loaded = load(robot)
    made = controller.resolve()(loaded, _DT)
    return run_tour(loaded, made, draw_tour(loaded, seed, parameters))


def _limits(controller: VelocityController) -> VelocityLimits:
    if not isinstance(controller, Walker):
        return VelocityLimits()
    return controller.gait.max_velocity.scaled(_SPEED_SHARE)
