"""What the simulated runs share: options, the run in MuJoCo, and its report."""

from __future__ import annotations

import argparse
import contextlib
import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace

import wbc
from wbc.cli.exit_codes import FAILED, INTERRUPTED, SUCCESS
from wbc.cli.interrupt import exit_on_interrupt, graceful_interrupt
from wbc.cli.parser import output_file, push, seconds, seed
from wbc.cli.progress import ProgressLine
from wbc.cli.robot_options import add_model_options, add_robot_option, load_arguments
from wbc.cli.run_outputs import RunOutputs, add_output_options, write_report
from wbc.cli.velocity_schedule import Velocity, VelocitySchedule
from wbc.errors import PlantError, WbcError
from wbc.runtime.loop import StopRun
from wbc.runtime.protocols import Controller, Observer
from wbc.runtime.statistics import Progress
from wbc.sim import Flat, Mujoco, Terrain, Tiles
from wbc.trials import RunEvaluator
from wbc.view import Meshcat

_MAX_SPEED = 1.5  # m/s, by which the extent of the tiles is chosen
_TILE_MARGIN = 2.0  # m
_MAX_TILE_EXTENT = 12.0  # m


def add_terrain_options(parser: argparse.ArgumentParser) -> None:
    """Add `--terrain` and `--seed`."""
    parser.add_argument(
        "--terrain",
        choices=("flat", "tiles"),
        default="flat",
        help="flat ground, or square tiles of random height up to 30 mm (default: flat)",
    )
    parser.add_argument(
        "--seed",
        type=seed,
        default=0,
        metavar="N",
        help="random seed of sensor noise and tiles (default: 0)",
    )


def add_solver_option(parser: argparse.ArgumentParser) -> None:
    """Add `--solver`."""
    parser.add_argument(
        "--solver", metavar="NAME", help="QP solver (default: the solver of the library)"
    )


def make_terrain(options: argparse.Namespace, duration: float = math.inf) -> Terrain:
    """Return the terrain of `add_terrain_options`, for a run of a duration, s."""
    if options.terrain == "flat":
        return Flat()
    extent = min(_MAX_TILE_EXTENT, _TILE_MARGIN + _MAX_SPEED * duration)
    return Tiles(seed=options.seed, extent=extent)


def add_options(parser: argparse.ArgumentParser, duration: str) -> None:
    """Add the options of a simulated run."""
    add_robot_option(parser)
    parser.add_argument(
        "--duration", type=seconds, metavar="S", help=f"duration, s (default: {duration})"
    )
    parser.add_argument(
        "--push",
        type=push,
        action="append",
        default=[],
        metavar='"T IX IY IZ"',
        help="push the torso at T s for 0.1 s with an impulse in N·s, in world axes (the robot "
        "starts heading along x); repeatable",
    )
    add_terrain_options(parser)
    parser.add_argument(
        "--ground-truth",
        action="store_true",
        help="give the controller the exact state of the simulator instead of an estimate",
    )
    add_solver_option(parser)
    parser.add_argument("--real-time", action="store_true", help="run no faster than real time")
    parser.add_argument("--no-view", action="store_true", help="do not show the run in the browser")
    parser.add_argument("--json", type=output_file, metavar="FILE", help="write the report as JSON")
    add_output_options(parser)
    add_model_options(parser)


class SimulatedRun:
    """A robot and its walker, and a run in MuJoCo as requested by the options.

    Args:
        options: parsed options, see `add_options`.

    Attributes:
        robot: the robot.
        walker: the walking controller.

    Raises:
        WbcError: bad input; the message says which.
    """

    def __init__(self, options: argparse.Namespace) -> None:
        self._options = options
        with exit_on_interrupt():  # it imports and compiles
            self.robot = wbc.load(options.robot, **load_arguments(options))
            self.walker = wbc.Walker(self.robot, solver=options.solver)

    def walk(self, schedule: VelocitySchedule, duration: float) -> int:
        """Walk according to a velocity schedule; see `run`."""
        return self.run(self.walker, duration, _VelocityCommands(self.walker, schedule))

    def run(
        self,
        controller: Controller,
        duration: float,
        before_tick: Callable[[float, Mujoco], None],
        evaluator: RunEvaluator | None = None,
        expected_duration: float | None = None,
    ) -> int:
        """Run a controller, print the report and write the requested files.

        Args:
            controller: a controller with the period of the walker.
            duration: maximum duration, s.
            before_tick: called with the time, s, and the plant before each tick.
            evaluator: extends the report.
            expected_duration: duration to show in the progress line, s; `duration` by default.

        Returns:
            The exit code.

        Raises:
            WbcError: bad input, or a file cannot be written.
        """
        options = self._options
        with exit_on_interrupt():
            terrain = make_terrain(options, duration)
            plant = self._plant(terrain, duration)
            outputs = RunOutputs(options, self.robot, terrain.boxes())
        with contextlib.ExitStack() as stack:
            observers: list[Observer] = []
            if not options.no_view:
                observers.append(stack.enter_context(Meshcat(self.robot, boxes=terrain.boxes())))
            observers += outputs.open_observers(stack)
            if evaluator is not None:
                observers.append(evaluator)
            line = ProgressLine()
            stack.callback(line.close)
            interrupted = stack.enter_context(graceful_interrupt())
            stack.enter_context(_clamping_notes(line))

            def progress(now: Progress) -> None:
                shown = (
                    now if expected_duration is None else replace(now, duration=expected_duration)
                )
                line.show(shown)
                if interrupted:
                    raise StopRun("interrupted")

            estimator = wbc.GroundTruthEstimator(self.robot) if options.ground_truth else None
            try:
                report = wbc.run(
                    controller,
                    plant,
                    duration,
                    estimator=estimator,
                    observers=observers,
                    real_time=options.real_time,
                    on_conditions=lambda conditions: line.print(conditions.describe()),
                    before_tick=lambda time: before_tick(time, plant),
                    progress=progress,
                )
            except PlantError as error:
                line.print(f"The simulation failed: {error}")
                return FAILED
        if evaluator is not None:
            report = evaluator.amend(report)
        print(report.table())
        with contextlib.ExitStack() as stack:
            stack.callback(outputs.write)  # even if the report cannot be written
            write_report(report, options)
        if interrupted:
            return INTERRUPTED
        return SUCCESS if report.survived and not report.aborted_motions else FAILED

    def _plant(self, terrain: Terrain, duration: float) -> Mujoco:
        options = self._options
        plant = Mujoco(
            self.robot,
            dt=self.walker.dt,
            terrain=terrain,
            seed=options.seed,
            ground_truth=options.ground_truth,
        )
        for time, impulse in options.push:
            if time >= duration:
                raise WbcError(f"the push at {time:g} s comes after the end at {duration:g} s")
            plant.schedule_push(time, impulse)
        return plant


class _VelocityCommands:
    """Sets the velocity of a walker according to a schedule, when it changes."""

    def __init__(self, walker: wbc.Walker, schedule: VelocitySchedule) -> None:
        self._walker = walker
        self._schedule = schedule
        self._velocity: Velocity | None = None

    def __call__(self, time: float, plant: Mujoco) -> None:
        velocity = self._schedule.velocity(time)
        if velocity != self._velocity:
            self._velocity = self._walker.velocity = velocity


@contextlib.contextmanager
def _clamping_notes(line: ProgressLine) -> Iterator[None]:
    """Print each warning about a clamped velocity command as one line."""

    def show(message: Warning | str, *_: object, **__: object) -> None:
        line.print(f"note: {message}")

    with warnings.catch_warnings():
        warnings.simplefilter("always", wbc.VelocityClamped)
        warnings.showwarning = show
        yield
