"""A run with commands known beforehand, which `wbc walk`, `stand` and `motion` share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import wbc
from wbc.cli.argument_types import Pushes
from wbc.cli.exit_code import ExitCode
from wbc.cli.simulation import Session, Simulation, SimulationOptions
from wbc.errors import WbcError
from wbc.runtime.event import COMMAND, RunEvent, tell
from wbc.runtime.loop import StopRun
from wbc.runtime.protocols import Controller, Observer, VelocityController
from wbc.runtime.report import Report
from wbc.runtime.statistics import Progress
from wbc.sim import Mujoco
from wbc.teleop import commands
from wbc.trials import RunEvaluator
from wbc.view import Meshcat

Velocity = tuple[float, float, float]
#: Time, s, and the velocity (forward m/s, left m/s, turn rad/s) that is commanded from then on.
Schedule = list[tuple[float, Velocity]]


@dataclass(frozen=True)
class RunOptions:
    """Options of a run whose commands are known before it begins.

    Attributes:
        simulation: robot and ground.
        push: push the torso at T s for 0.1 s with an impulse in N·s, in world axes (the robot
            starts heading along x).
        ground_truth: give the controller the exact state of the simulator instead of an estimate.
        real_time: run no faster than real time.
        view: do not show the run in the browser.
    """

    simulation: SimulationOptions
    push: Pushes = ()
    ground_truth: bool = False
    real_time: bool = False
    view: bool = True


class ScriptedRun:
    """A run in MuJoCo whose commands are known before it begins.

    Args:
        options: parsed options.
        duration: maximum duration, s.

    Attributes:
        robot: the robot.
        walker: its walking controller.

    Raises:
        WbcError: bad input; the message says which.
    """

    def __init__(self, options: RunOptions, duration: float) -> None:
        for at, _ in options.push:
            if at >= duration:
                raise WbcError(f"the push at {at:g} s comes after the end at {duration:g} s")
        self._options, self._duration = options, duration
        self._simulation = Simulation(options.simulation, duration, options.ground_truth)
        self.robot, self.walker = self._simulation.robot, self._simulation.walker
        for at, impulse in options.push:
            self._simulation.plant.schedule_push(at, impulse)

    @property
    def biped_walker(self) -> wbc.Walker:
        """See `Simulation.biped_walker`."""
        return self._simulation.biped_walker

    def walk(self, schedule: Schedule) -> ExitCode:
        """Stand until the schedule begins, and walk according to it."""
        remaining = list(schedule)

        def command(time: float, _: Mujoco) -> None:
            while remaining and time >= remaining[0][0]:
                self.walker.velocity = remaining.pop(0)[1]

        return self.run(self.walker, command)

    def run(
        self,
        controller: Controller,
        before_tick: Callable[[float, Mujoco], None],
        *,
        evaluator: RunEvaluator | None = None,
        expected_duration: float | None = None,
    ) -> ExitCode:
        """Run a controller, print the report and write the requested files.

        Args:
            controller: a controller with the period of the walker.
            before_tick: called with the time, s, and the plant before each tick.
            evaluator: extends the report.
            expected_duration: to show in the progress line, s; the maximum when left out.

        Raises:
            WbcError: bad input, or a file cannot be written.
        """
        simulation = self._simulation

        def execute(session: Session) -> Report:
            observers = session.observers
            if self._options.view:
                viewer = Meshcat(self.robot, boxes=simulation.boxes)
                observers.append(session.stack.enter_context(viewer))
            if evaluator is not None:
                observers.append(evaluator)

            told = CommandEvents(self.walker, self._options.push, observers)

            def tick(time: float) -> None:
                before_tick(time, simulation.plant)
                told.on_tick(time)

            def progress(now: Progress) -> None:
                session.line.show_run(replace(now, duration=expected_duration or now.duration))
                if session.interrupted:
                    raise StopRun("interrupted")

            truth = self._options.ground_truth
            report = wbc.run(
                controller,
                simulation.plant,
                self._duration,
                estimator=wbc.GroundTruthEstimator(self.robot) if truth else None,
                observers=observers,
                real_time=self._options.real_time,
                on_conditions=lambda conditions: session.line.print(conditions.describe()),
                on_falling=lambda text: session.line.print(f"the robot is {text}"),
                before_tick=tick,
                progress=progress,
            )
            return report if evaluator is None else evaluator.amend(report)

        return simulation.run(execute)


class CommandEvents:
    """Tells the observers of a run when its velocity changes and its pushes begin."""

    def __init__(
        self,
        walker: VelocityController,
        pushes: Pushes,
        observers: Sequence[Observer],
    ) -> None:
        self._walker, self._observers = walker, observers
        self._pushes = sorted(pushes)
        self._velocity: Velocity = (0.0, 0.0, 0.0)
        self._number = 0

    def on_tick(self, time: float) -> None:
        """Tell what has changed since the tick before."""
        if self._walker.velocity != self._velocity:
            self._velocity = self._walker.velocity
            self._tell(time, commands.VelocityCommand(*self._velocity))
        while self._pushes and time >= self._pushes[0][0]:
            _, impulse = self._pushes.pop(0)
            self._tell(time, commands.PushCommand(impulse, frame="world"))

    def _tell(self, time: float, command: commands.TeleopCommand) -> None:
        self._number += 1
        name, value = commands.command_name(command), commands.command_json(command)
        event = RunEvent(time, COMMAND, "script", self._number, name, value, "accepted")
        tell(self._observers, event)
