"""What all simulated runs share: options, the run in MuJoCo, and its report."""

from __future__ import annotations

import argparse
import contextlib
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace

import wbc
from wbc.cli.interrupt import interruptible
from wbc.cli.itinerary import Itinerary, Velocity
from wbc.cli.keepsakes import Keepsakes, add_keepsake_options
from wbc.cli.parser import FELL, INTERRUPTED, output, push, seconds, seed
from wbc.cli.progress import ProgressLine
from wbc.cli.robot_options import add_robot_options, stated
from wbc.errors import PlantError, WbcError
from wbc.runtime.loop import StopRun
from wbc.runtime.protocols import Controller, Recorder
from wbc.runtime.statistics import Progress
from wbc.sim import Flat, Mujoco, Terrain, Tiles
from wbc.trials import RunEvaluator
from wbc.view import Meshcat

_REACH = 1.5  # m/s: tiles are laid as far as this takes the robot, and a bit
_FARTHEST = 12.0  # m


def add_options(parser: argparse.ArgumentParser, duration: str) -> None:
    """The options that every simulated run has."""
    run = parser.add_argument_group("the run")
    run.add_argument(
        "--robot",
        default="talos",
        metavar="NAME|FILE",
        help="a robot's name, or a URDF or robot data file (default: talos)",
    )
    run.add_argument("--duration", type=seconds, metavar="S", help=f"s (default: {duration})")
    run.add_argument(
        "--push",
        type=push,
        action="append",
        default=[],
        metavar='"T IX IY IZ"',
        help="push the torso from T s on, for 0.1 s, with an impulse in N·s, world axes "
        "(the robot starts heading along x); may be given again",
    )
    run.add_argument(
        "--terrain",
        choices=("flat", "tiles"),
        default="flat",
        help="flat, or square tiles of random height up to 30 mm",
    )
    run.add_argument(
        "--seed", type=seed, default=0, metavar="N", help="of sensor noise and tiles (default: 0)"
    )
    run.add_argument(
        "--ground-truth",
        action="store_true",
        help="give the controller the simulator's exact state instead of an estimate",
    )
    run.add_argument("--solver", metavar="NAME", help="QP solver (default: wbc, the library's own)")
    run.add_argument("--real-time", action="store_true", help="a second takes a second, not less")
    run.add_argument("--no-view", action="store_true", help="no view in the browser")
    run.add_argument("--json", type=output, metavar="FILE", help="also write the report as JSON")
    add_keepsake_options(run)
    add_robot_options(parser)


class Simulation:
    """A robot and its walker, to be run in MuJoCo as the options say.

    Args:
        options: parsed, see `add_options`.

    Attributes:
        robot: the robot.
        walker: its controller.

    Raises:
        WbcError: bad input; the text says which.
    """

    def __init__(self, options: argparse.Namespace) -> None:
        self._options = options
        self.robot = wbc.load(options.robot, **stated(options))
        self.walker = wbc.Walker(self.robot, solver=options.solver)

    def run(self, itinerary: Itinerary, duration: float) -> int:
        """Walk along an itinerary, show, report; returns the exit code.

        Raises:
            WbcError: bad input.
        """
        return self.perform(self.walker, duration, _Helm(self.walker, itinerary))

    def perform(
        self,
        controller: Controller,
        duration: float,
        before_tick: Callable[[float, Mujoco], None],
        evaluator: RunEvaluator | None = None,
        expected: float | None = None,
    ) -> int:
        """Run a controller, show, report; returns the exit code.

        Args:
            controller: that steps with the walker's period.
            duration: s, at most.
            before_tick: called with time and plant before each tick, see `wbc.run`.
            evaluator: adds its figures to the report.
            expected: how long it will take as far as is known, s; the duration if left out.

        Raises:
            WbcError: bad input.
        """
        options = self._options
        terrain = self._terrain(duration)
        plant = self._plant(terrain, duration)
        keepsakes = Keepsakes(options, self.robot, terrain.boxes())
        with contextlib.ExitStack() as stack:
            viewer = None
            if not options.no_view:
                viewer = stack.enter_context(Meshcat(self.robot, boxes=terrain.boxes()))
            logs: list[Recorder] = [*keepsakes.logs(stack)]
            if evaluator is not None:
                logs.append(evaluator)
            line = ProgressLine()
            stack.callback(line.close)
            interrupted = stack.enter_context(interruptible())
            stack.enter_context(_clamping_told(line))

            def progress(now: Progress) -> None:
                line.show(now if expected is None else replace(now, duration=expected))
                if interrupted:
                    raise StopRun("interrupted")

            estimator = wbc.GroundTruthEstimator(self.robot) if options.ground_truth else None
            try:
                report = wbc.run(
                    controller,
                    plant,
                    duration,
                    estimator=estimator,
                    viewer=viewer,
                    recording=keepsakes.recording,
                    log=logs,
                    real_time=options.real_time,
                    announce=lambda conditions: line.note(conditions.describe()),
                    before_tick=lambda time: before_tick(time, plant),
                    progress=progress,
                )
            except PlantError as error:
                line.note(f"the run ended: {error}")
                return FELL
        if evaluator is not None:
            report = evaluator.amend(report)
        print(report.table())
        if options.json is not None:
            report.save(options.json)
        keepsakes.finish()
        if interrupted:
            return INTERRUPTED
        return 0 if report.survived and not report.aborted_motions else FELL

    def _terrain(self, duration: float) -> Terrain:
        if self._options.terrain == "flat":
            return Flat()
        return Tiles(seed=self._options.seed, extent=min(_FARTHEST, 2.0 + _REACH * duration))

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


class _Helm:
    """Steers a walker along an itinerary; a velocity is set once, not at every tick."""

    def __init__(self, walker: wbc.Walker, itinerary: Itinerary) -> None:
        self._walker = walker
        self._itinerary = itinerary
        self._velocity: Velocity | None = None

    def __call__(self, time: float, plant: Mujoco) -> None:
        velocity = self._itinerary.velocity(time)
        if velocity != self._velocity:
            self._velocity = self._walker.velocity = velocity


@contextlib.contextmanager
def _clamping_told(line: ProgressLine) -> Iterator[None]:
    """A velocity command that is clamped is told in one line."""

    def tell(message: Warning | str, *_: object, **__: object) -> None:
        line.note(f"note: {message}")

    with warnings.catch_warnings():
        warnings.simplefilter("always", wbc.VelocityClamped)
        warnings.showwarning = tell
        yield
