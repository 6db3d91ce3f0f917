"""The common part of all runs in MuJoCo: robot, plant, files, progress and exit code."""

from __future__ import annotations

import contextlib
import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal, cast

import wbc
from wbc.cli.argument_types import Argument, RobotName
from wbc.cli.exit_code import ExitCode
from wbc.cli.interrupt import exit_on_interrupt, graceful_interrupt
from wbc.cli.model_options import ModelOptions
from wbc.cli.outputs import OutputOptions, RunOutputs
from wbc.cli.progress import ProgressLine
from wbc.errors import PlantError, WbcError
from wbc.runtime.protocols import Observer
from wbc.runtime.report import Report
from wbc.sim import Cart, Flat, JointServos, Mujoco, Ramp, Terrain, Tiles, Wall
from wbc.teleop import StartSessionCommand
from wbc.teleop.gains_file import apply_gains

#: Name of a terrain.
TerrainName = Literal["flat", "tiles", "ramp", "wall", "cart"]

_MAX_SPEED = 1.5  # m/s, by which the extent of the tiles is chosen
_TILE_MARGIN = 2.0  # m
_SERVO_LATENCY = 0.002  # s
_MAX_TILE_EXTENT = 12.0  # m


@dataclass(frozen=True)
class SimulationOptions:
    """Options of every run in MuJoCo.

    Attributes:
        outputs: files to write.
        model: properties of the robot.
        robot: name of a robot, or path of a URDF or robot data file.
        solver: QP solver (default: the solver of the library).
        planner: plans footsteps and DCM: analytic, by preview control, or model-predictive.
        terrain: flat ground, square tiles of random height up to 30 mm, a ramp of 10° up to a
            plateau and down again, or a wall or a cart 0.3 m in front of the robot.
        seed: random seed of sensor noise and tiles.
        actuation: what the joints are driven by: ideal sources of torque, or servos with soft
            gains, 2 ms of delay, friction and a backlash of 0.5°.
        gains: gains and gait parameters, as the page of wbc live saves them.
    """

    outputs: OutputOptions
    model: ModelOptions
    robot: RobotName = "talos"
    solver: Annotated[str | None, Argument("NAME")] = None
    planner: Literal["dcm", "preview", "mpc", "placo"] = "dcm"
    terrain: TerrainName = "flat"
    seed: int = 0
    actuation: Literal["torque", "servo"] = "torque"
    gains: Annotated[Path | None, Argument("FILE", Path)] = None

    def for_session(self, wanted: StartSessionCommand, number: int) -> SimulationOptions:
        """Return the options of another session, whose files bear its number.

        What was stated about the robot holds for this robot only: properties of its model, gains.
        """
        same = wanted.robot == self.robot
        return replace(
            self,
            outputs=self.outputs.numbered(number),
            model=self.model if same else ModelOptions(),
            robot=wanted.robot,
            terrain=cast(TerrainName, wanted.terrain),
            seed=wanted.seed,
            gains=self.gains if same else None,
        )


@dataclass(frozen=True)
class Session:
    """The objects that are open while a robot is simulated.

    Attributes:
        stack: closes what is entered when the run is over.
        observers: observers of the run.
        line: shows the progress.
        interrupted: not empty once Ctrl-C was pressed or SIGTERM came; the run is to end then.
    """

    stack: contextlib.ExitStack
    observers: list[Observer]
    line: ProgressLine
    interrupted: list[int]


class Simulation:
    """A robot with its walking controller in MuJoCo.

    Args:
        options: parsed options.
        duration: maximum duration of the run, s.
        ground_truth: whether the plant measures the exact state.

    Attributes:
        robot: the robot.
        walker: the walking controller, on two legs or on four.
        boxes: boxes of the terrain; see `wbc.sim.Terrain`.
        plant: the simulated robot.

    Raises:
        WbcError: bad input; the message says which.
    """

    def __init__(
        self, options: SimulationOptions, duration: float = math.inf, ground_truth: bool = False
    ) -> None:
        with exit_on_interrupt():  # it imports and compiles
            self.robot = options.model.load(options.robot)
            self.walker = _make_walker(self.robot, options)
            terrain = _terrain(options, duration)
            self.boxes = terrain.boxes()
            servos = JointServos() if options.actuation == "servo" else None
            self.plant = Mujoco(
                self.robot,
                dt=self.walker.dt,
                terrain=terrain,
                seed=options.seed,
                latency=_SERVO_LATENCY if servos is not None else 0.0,
                servos=servos,
                ground_truth=ground_truth,
                cart=Cart() if options.terrain == "cart" else None,
            )
            self._outputs = RunOutputs(options.outputs, self.robot, self.boxes)

    @property
    def biped_walker(self) -> wbc.Walker:
        """The walking controller of a robot on two legs.

        Raises:
            WbcError: the robot has four.
        """
        if isinstance(self.walker, wbc.QuadrupedWalker):
            raise WbcError(
                f"'{self.robot.name}' has four legs: it stands and walks (wbc stand, wbc walk); "
                "motions and the live page are for robots on two"
            )
        return self.walker

    def run(self, execute: Callable[[Session], Report | None]) -> ExitCode:
        """Run a function that simulates; print its report, and write the requested files.

        Args:
            execute: runs until it is over or interrupted, and returns the report, if there is one.

        Raises:
            WbcError: bad input, or a file cannot be written.
        """
        with contextlib.ExitStack() as stack:
            observers = self._outputs.open_observers(stack)
            line = stack.enter_context(ProgressLine())
            interrupted = stack.enter_context(graceful_interrupt())
            stack.enter_context(_clamping_notes(line))
            try:
                report = execute(Session(stack, observers, line, interrupted))
            except PlantError as error:
                line.print(f"The simulation failed: {error}")
                report = None
        if report is not None:
            print(report.table())
            self._outputs.write(report)
        if interrupted:
            return ExitCode(128 + interrupted[0])
        survived = report is not None and report.survived and not report.aborted_motions
        return ExitCode.SUCCESS if survived else ExitCode.FAILED


def _make_walker(robot: wbc.Robot, options: SimulationOptions) -> wbc.Walker | wbc.QuadrupedWalker:
    if robot.is_quadruped:
        for name, value in (("--gains", options.gains), ("--planner", options.planner != "dcm")):
            if value:
                raise WbcError(f"{name} is for robots on two legs, and '{robot.name}' has four")
        return wbc.QuadrupedWalker(robot, solver=options.solver)
    walker = wbc.Walker(robot, planner=options.planner, solver=options.solver)
    if options.gains is not None:
        apply_gains(walker, options.gains)
    return walker


def _terrain(options: SimulationOptions, duration: float) -> Terrain:
    if options.terrain in ("flat", "cart"):
        return Flat()
    if options.terrain == "ramp":
        return Ramp()
    if options.terrain == "wall":
        return Wall()
    extent = min(_MAX_TILE_EXTENT, _TILE_MARGIN + _MAX_SPEED * duration)
    return Tiles(seed=options.seed, extent=extent)


@contextlib.contextmanager
def _clamping_notes(line: ProgressLine) -> Iterator[None]:
    """Print each warning about a clamped velocity command as one line."""

    def show(message: Warning | str, *_: object, **__: object) -> None:
        line.print(f"note: {message}")

    with warnings.catch_warnings():
        warnings.simplefilter("always", wbc.VelocityClamped)
        warnings.showwarning = show
        yield
