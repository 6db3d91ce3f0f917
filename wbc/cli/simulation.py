"""What `wbc walk` and `wbc stand` share: options, the run in MuJoCo, and its report."""

from __future__ import annotations

import argparse
import contextlib
import signal
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import wbc
from wbc.cli.itinerary import Itinerary
from wbc.cli.parser import BAD_INPUT, FELL, INTERRUPTED, output, push, seconds, seed
from wbc.cli.progress import ProgressLine
from wbc.cli.robot_options import add_robot_options, load_robot
from wbc.errors import PlantError, WbcError
from wbc.loop import Progress, StopRun
from wbc.sim import Flat, Mujoco, Terrain, Tiles
from wbc.view import Meshcat, Recording

_REACH = 1.5  # m/s: no tiles are laid farther than this takes the robot


def add_options(parser: argparse.ArgumentParser, duration: str) -> None:
    """The options that every simulated run has."""
    parser.add_argument(
        "--robot",
        default="talos",
        metavar="NAME|FILE",
        help="a robot's name, or a URDF or robot data file (default: talos)",
    )
    add_robot_options(parser)
    parser.add_argument("--duration", type=seconds, metavar="S", help=f"s (default: {duration})")
    parser.add_argument(
        "--push",
        type=push,
        action="append",
        default=[],
        metavar='"T IX IY IZ"',
        help="push the torso from T s on, for 0.1 s, with an impulse in N·s, world axes "
        "(the robot starts heading along x); may be given again",
    )
    parser.add_argument(
        "--terrain",
        choices=("flat", "tiles"),
        default="flat",
        help="flat, or square tiles of random height up to 30 mm",
    )
    parser.add_argument("--seed", type=seed, default=0, help="of sensor noise and tiles")
    parser.add_argument(
        "--ground-truth",
        action="store_true",
        help="give the controller the simulator's exact state instead of the estimate",
    )
    parser.add_argument(
        "--solver", default="daqp", metavar="NAME", help="QP solver (default: daqp)"
    )
    parser.add_argument(
        "--real-time", action="store_true", help="a second takes a second, not less"
    )
    parser.add_argument("--no-view", action="store_true", help="do not serve the browser's view")
    parser.add_argument("--json", type=output, metavar="FILE", help="also write the report as JSON")
    parser.add_argument(
        "--html", type=output, metavar="FILE", help="leave a recording that opens offline"
    )


class Simulation:
    """A robot, its walker and its plant, ready to run as the options say.

    Args:
        options: parsed, see `add_options`.

    Raises:
        WbcError: bad input; the text says which.
    """

    def __init__(self, options: argparse.Namespace) -> None:
        self._options = options
        self.robot = load_robot(options.robot, options)
        self.walker = wbc.Walker(self.robot, solver=options.solver)

    def run(self, itinerary: Itinerary, duration: float) -> int:
        """Run, show, report; returns the exit code."""
        options = self._options
        for shove in options.push:
            if shove.time >= duration:
                raise WbcError(
                    f"the push at {shove.time:g} s comes after the end at {duration:g} s"
                )
        terrain: Terrain = Flat()
        if options.terrain == "tiles":
            terrain = Tiles(seed=options.seed, extent=min(12.0, 2.0 + _REACH * duration))
        with contextlib.ExitStack() as stack:
            plant = stack.enter_context(
                Mujoco(
                    self.robot,
                    dt=self.walker.dt,
                    terrain=terrain,
                    seed=options.seed,
                    ground_truth=options.ground_truth,
                )
            )
            for shove in options.push:
                plant.schedule_push(shove.time, shove.impulse)
            boxes = terrain.boxes()
            viewer = None if options.no_view else Meshcat(self.robot, boxes=boxes)
            if viewer is not None:
                stack.enter_context(viewer)
            recording = Recording(self.robot, boxes=boxes) if options.html else None
            line = ProgressLine()
            stack.callback(line.close)
            stop = stack.enter_context(_interruptible())
            stack.enter_context(_clamping_noted(line))

            def command(time: float) -> None:
                velocity = itinerary.velocity(time)
                if velocity != command_now[0]:
                    command_now[0] = velocity
                    self.walker.velocity = velocity

            def progress(now: Progress) -> None:
                line.show(now)
                if stop:
                    raise StopRun("interrupted")

            command_now: list[Any] = [None]
            try:
                report = wbc.run(
                    self.walker,
                    plant,
                    duration,
                    estimator=wbc.GroundTruthEstimator() if options.ground_truth else None,
                    viewer=viewer,
                    recording=recording,
                    real_time=options.real_time,
                    before_tick=command,
                    progress=progress,
                )
            except PlantError as error:
                line.note(f"the run ended: {error}")
                return FELL
        print(report.table())
        if options.json is not None:
            report.save(options.json)
        if recording is not None:
            print(f"\nrecording: {_save(recording, options.html)}")
        if stop:
            return INTERRUPTED
        return 0 if report.survived else FELL


def _save(recording: Recording, path: Path) -> Path:
    return recording.save(path).resolve()


@contextlib.contextmanager
def _clamping_noted(line: ProgressLine) -> Iterator[None]:
    """Velocity commands that were clamped are told once each, in one line."""
    told = set()

    def show(message: Warning | str, *_: object, **__: object) -> None:
        if str(message) not in told:
            told.add(str(message))
            line.note(f"note: {message}")

    with warnings.catch_warnings():
        warnings.simplefilter("always", wbc.VelocityClamped)
        warnings.showwarning = show
        yield


@contextlib.contextmanager
def _interruptible() -> Iterator[list[int]]:
    """Ctrl-C asks for the end instead of tearing the tick apart; a second one does not ask.

    Yields:
        A list that is empty until then.
    """
    asked: list[int] = []

    def ask(signum: int, _: FrameType | None) -> None:
        if asked:
            raise KeyboardInterrupt
        asked.append(signum)

    try:
        before = signal.signal(signal.SIGINT, ask)
    except ValueError:  # not in the main thread: nobody presses Ctrl-C on us
        yield asked
        return
    try:
        yield asked
    finally:
        signal.signal(signal.SIGINT, before)
