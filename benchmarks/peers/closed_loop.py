"""Other libraries as controllers in closed loop, for `wbc trials`.

    PYTHONPATH=benchmarks wbc trials benchmarks/grids/peers.toml

A walker makes the references: footsteps, DCM plan, DCM feedback and step adjustment, swing foot,
contacts. The library solves the QP, in a process of its own environment, once per tick. What is
compared is therefore the balance of "TSID with a DCM plan", without the quick steps that catch a
push.
"""

from __future__ import annotations

import contextlib
import math
import os
import select
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

import wbc
from peers.case import BOTH, LEFT, RIGHT
from peers.environments import default_folder, prepare
from peers.recording import Recorder, make_case, make_problem, stack
from peers.reference import Reference
from wbc.closeable import Closeable
from wbc.trials.controllers import make_walker

BENCHMARKS = Path(__file__).resolve().parent.parent
POSTURE_WEIGHT = 0.1  # as high as in the comparison of ticks it moves the CoM by a centimetre
_LONGEST_TICK = 1.0  # s: some thousand times the usual
_LEAVING = {"left": LEFT, "right": RIGHT}


class LibraryController(Closeable):
    """A walker whose QP another library solves, in a process of its own.

    A copy has a process of its own. It goes on bit-identically, because the library keeps nothing
    from tick to tick; where the library finds no solution, the last torques stay. So they do where
    it does not end within a second (eiquadprog may cycle for ever): its process starts anew.

    Args:
        robot: the robot.
        dt: control period, s.
        adapter: "module:class" in `peers.adapters`.
        python: interpreter of the library's environment.
        quick_steps: whether the walker's quick steps catch a push.
    """

    def __init__(
        self, robot: wbc.Robot, dt: float, adapter: str, python: Path, quick_steps: bool = False
    ) -> None:
        self._robot, self._adapter, self._python = robot, adapter, python
        self.dt = dt
        self._recorder = Recorder(make_walker(robot, dt, recovery=quick_steps))
        self._last = np.zeros(robot.na), np.zeros(robot.nv)
        self._start()

    def __getstate__(self) -> dict[str, object]:
        state = self.__dict__.copy()
        for name in ("_scratch", "_log", "_process"):
            del state[name]
        return state

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state)
        self._start()

    def _start(self) -> None:
        """Start the library's process, and wait until it is ready."""
        self._scratch = tempfile.TemporaryDirectory(prefix="wbc-peer-")
        folder = Path(self._scratch.name)
        save_case(self._robot, folder)
        self._log = (folder / "log.txt").open("w+")
        self._process = subprocess.Popen(
            [str(self._python), "-m", "peers.stream_worker", self._adapter, str(folder)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            env=os.environ | {"PYTHONPATH": str(BENCHMARKS)},
            cwd=folder,
        )
        self._reply()

    @property
    def velocity(self) -> tuple[float, float, float]:
        """See `wbc.Walker.velocity`."""
        return self._recorder.walker.velocity

    @velocity.setter
    def velocity(self, value: tuple[float, float, float]) -> None:
        self._recorder.walker.velocity = value

    @property
    def gait_cycle(self) -> float:
        """See `wbc.Walker.gait_cycle`."""
        return self._recorder.walker.gait_cycle

    @property
    def telemetry(self) -> wbc.Telemetry:
        """See `wbc.Walker.telemetry`."""
        return self._recorder.walker.telemetry

    @property
    def contact_plan(self) -> wbc.ContactPlan:
        """See `wbc.Walker.contact_plan`."""
        return self._recorder.walker.contact_plan

    def reset(self, state: wbc.State) -> None:
        """Start anew, standing."""
        self._recorder.reset(state)
        self._last = np.zeros(self._robot.na), np.zeros(self._robot.nv)

    def step(self, estimate: wbc.Estimate) -> wbc.Command:
        """Return the library's torques for the walker's references."""
        walker = self._recorder.walker
        walker.step(estimate)
        row = self._recorder.row(estimate.state)
        leaving, force = BOTH, math.inf
        for contact in walker.controller.contacts:
            if contact.max_force < force:
                side = next(s.side for s in self._robot.soles if s.name == contact.frame)
                leaving, force = _LEAVING[side], contact.max_force
        reference = Reference(leaving=leaving, max_force=min(force, 1e6), **row)
        assert self._process.stdin is not None
        self._process.stdin.write(reference.pack().tobytes())
        self._process.stdin.flush()
        na, state = self._robot.na, estimate.state
        if self._replies():
            reply = self._reply()
        else:
            self._process.kill()
            self.close()
            self._start()
            reply = np.zeros(1)
        if reply[0]:
            self._last = reply[1 : 1 + na], reply[1 + na :]
        tau, acceleration = self._last
        limit = self._robot.tau_max
        joints = acceleration[6:]
        return wbc.Command(
            np.clip(tau, -limit, limit),
            acceleration,
            {},
            state.q[7:] + self.dt * state.v[6:],
            state.v[6:] + self.dt * joints,
            wbc.Status.OK if reply[0] else wbc.Status.INFEASIBLE,
            "" if reply[0] else "the library found no solution; the last torques stay",
        )

    def close(self) -> None:
        """End the process."""
        process = self._process
        if process.poll() is None:
            process.stdin.close()
            try:
                process.wait(timeout=10.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        process.stdout.close()
        self._log.close()
        self._scratch.cleanup()

    def _replies(self) -> bool:
        """Wait for a reply; return whether there is one in time."""
        return bool(select.select([self._process.stdout], [], [], _LONGEST_TICK)[0])

    def _reply(self) -> np.ndarray:
        na = self._robot.na
        size = 8 * (1 + na + na + 6)
        assert self._process.stdout is not None
        data = self._process.stdout.read(size)
        if len(data) < size:
            self._process.wait()
            self._log.seek(0)
            said = "\n".join(self._log.read().strip().splitlines()[-6:])
            raise RuntimeError(f"the library's process died ({self._process.returncode})\n{said}")
        return np.frombuffer(data).copy()


def save_case(robot: wbc.Robot, folder: Path) -> None:
    """Write robot, limits and gains for the process, with one tick of each set of feet."""
    state = robot.standing()
    recorder = Recorder(wbc.Walker(robot))
    recorder.reset(state)
    recorder.walker.step(wbc.Estimate(state))
    row = recorder.row(state)
    rows = [row | {"stance": stance} for stance in (BOTH, LEFT, RIGHT)]
    problem = make_problem(robot)
    problem = replace(problem, gains=replace(problem.gains, posture_weight=POSTURE_WEIGHT))
    make_case("walk", "", problem, stack(rows, state.q[7:].copy())).save(folder)


def make_tsid(robot: wbc.Robot, dt: float, *, quick_steps: bool = False) -> LibraryController:
    """Return TSID with the plan of a walker: a `ControllerFactory`.

    Args:
        robot: the robot.
        dt: control period, s.
        quick_steps: whether the walker's quick steps catch a push.
    """
    with contextlib.redirect_stdout(sys.stderr):
        python = prepare("tsid", default_folder())
    return LibraryController(robot, dt, "tsid_walking:TsidWalking", python, quick_steps)
