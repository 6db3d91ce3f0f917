"""`Bridge`: a robot in a running loop, as a node of a ROS 2 system."""

from __future__ import annotations

import os
import struct
import time
from typing import TYPE_CHECKING

import numpy as np

from wbc.closeable import Closeable
from wbc.command import Status
from wbc.process import ChildProcess, LatestValue, ProcessStartError, RecordRing
from wbc.ros.bridge.config import NodeConfig
from wbc.ros.bridge.layout import HEAD, MOST, Layout
from wbc.ros.dds_types import import_cyclonedds
from wbc.ros.errors import RosError
from wbc.ros.network import Network
from wbc.runtime.mode import Mode
from wbc.telemetry import PHASES, Balance

if TYPE_CHECKING:
    from wbc.runtime.protocols import Controller, Plant
    from wbc.runtime.report import Report
    from wbc.runtime.tick import Tick
    from wbc.teleop import CommandHandler

_STATUS = {status: i for i, status in enumerate(Status)}
_PHASE = {phase: i for i, phase in enumerate(PHASES)}
_UNKNOWN = Balance()
_HEAD = struct.Struct(f"={len(HEAD)}d")
_MORE = 2.0
_IDLE_PERIOD = 0.02  # s between two records while there are no ticks


class Bridge(Closeable):
    """Shows a robot to a ROS 2 system, which sends commands to it.

    All of DDS happens in another process. The loop's process copies ticks into shared memory, at
    twice the rate at which they are published; it never waits, and goes on when the other process
    has died.

    Example:
        >>> with CommandHandler(player, plant) as handler, Bridge(handler) as bridge:
        ...     wbc.teleop.run(handler, 3600.0, clients=[bridge])

    Args:
        handler: takes the node's commands.
        name: name of the node.
        namespace: namespace of the node.
        network: domain and interface; from the environment when left out.
        update_rate: of the joint states, Hz; a parameter of the node.
        use_sim_time: stamp messages with the plant's time, not the system's; likewise.

    Attributes:
        reset_hint: how a person resets the robot.

    Raises:
        MissingExtra: `cyclonedds` is not installed.
        RosError: the node cannot be made.
    """

    reset_hint = "call the service /reset_robot"

    def __init__(
        self,
        handler: CommandHandler,
        *,
        name: str = "wbc",
        namespace: str = "/",
        network: Network | None = None,
        update_rate: float = 50.0,
        use_sim_time: bool = False,
    ) -> None:
        import_cyclonedds()
        robot, dt = handler.player.robot, handler.player.dt
        layout = Layout.of(robot)
        self._soles = [sole.name for sole in robot.soles]
        self._no_wrench = np.full(6, np.nan)
        self._ring = RecordRing(layout.size)
        self._needed_rate = LatestValue(1)
        self._needed_rate.write((np.inf,))  # every tick, until the node says
        self._run = 0
        self._before = time.perf_counter()
        self._idle_due = 0.0
        self._last: np.ndarray | None = None
        self._dt, self._to_go = dt, 0  # ticks until one is shown
        self._timing: list[float] = []  # of the ticks since the last that was shown
        channel = handler.open_channel().config
        descriptors = (*channel.descriptors, self._ring.descriptor, self._needed_rate.descriptor)
        self._process = ChildProcess("wbc.ros.bridge.server", descriptors, title="the ROS 2 node")
        config = NodeConfig(
            robot=robot,
            name=name,
            namespace=namespace,
            network=network or Network.from_environment(),
            channel=channel,
            update_rate=update_rate,
            use_sim_time=use_sim_time,
            dt=dt,
            ring=self._ring.descriptor,
            rate=self._needed_rate.descriptor,
            parent=os.getpid(),
        )
        try:
            self._process.configure(config)
        except BaseException as error:
            self.close()
            if isinstance(error, ProcessStartError):
                raise RosError(str(error)) from error
            raise

    @property
    def alive(self) -> bool:
        """Whether the node's process runs."""
        return self._process.alive

    @property
    def pid(self) -> int:
        """Process id of the node's process."""
        return self._process.pid

    def begin(self, controller: Controller, plant: Plant) -> None:
        """A run begins, see `wbc.runtime.protocols.Recorder`."""
        self._run += 1
        self._before = time.perf_counter()
        self._to_go = 0
        self._timing.clear()

    def record(self, tick: Tick, controller: Controller) -> None:
        """Show a tick. Never waits; whatever happens to the node, returns.

        Of most ticks the node needs to know no more than how they went: it gets that with the
        next one that is shown.
        """
        now = time.perf_counter()
        self._timing += (
            tick.estimator_time + tick.controller_time,
            now - self._before,
            _STATUS[tick.command.status],
        )
        self._before = now
        self._to_go -= 1
        if self._to_go <= 0:
            # The node's own rates do not go into the loop's: it gets some more than it asks for.
            self._to_go = min(int(1.0 / (_MORE * self._needed_rate.read()[0] * self._dt)), MOST)
            self._show(tick, controller)
            self._process.warn_if_exited(now)

    def _show(self, tick: Tick, controller: Controller) -> None:
        balance: Balance = getattr(controller, "balance", _UNKNOWN)
        wrenches = tick.measurement.foot_wrenches or tick.command.wrenches
        record = self._ring.begin()
        np.concatenate(
            (
                tick.estimate.state.q,
                tick.estimate.state.v,
                tick.command.tau,
                balance.com,
                balance.dcm,
                balance.dcm_reference,
                balance.zmp,
                *[wrenches.get(name, self._no_wrench) for name in self._soles],
            ),
            out=record[len(HEAD) : -3 * MOST],
        )
        self._ring.pack(
            _HEAD,
            time.time(),
            tick.time,
            self._run,
            Mode.RUNNING,
            _STATUS[tick.command.status],
            _PHASE.get(balance.phase, 0),
            getattr(controller, "steps", 0),
            getattr(controller, "dcm_error", np.nan),
            self._tell_timing(record),
        )
        self._ring.publish()
        self._last = record

    def _tell_timing(self, record: np.ndarray) -> int:
        """Write how the ticks went since the last that was shown; returns how many numbers."""
        count = len(self._timing)
        record[-3 * MOST :][:count] = self._timing
        self._timing.clear()
        return count

    def end(self, report: Report) -> None:
        """The run is over, see `wbc.runtime.protocols.Recorder`."""

    def idle(self, mode: Mode) -> None:
        """Show where the robot is while there are no ticks: its sensors go on."""
        now = time.perf_counter()
        if self._last is None or now < self._idle_due:
            return
        self._idle_due = now + _IDLE_PERIOD
        last = self._last.copy()
        record = self._ring.begin()
        record[:] = last
        record[HEAD.index("stamp")] = time.time()
        record[HEAD.index("mode")] = mode
        record[HEAD.index("timed")] = self._tell_timing(record)  # those before the fall
        self._ring.publish()
        self._last = record

    def close(self) -> None:
        """End the node's process."""
        self._process.close()
        self._ring.close()
        self._needed_rate.close()
