"""`Bridge`: a robot in a running loop, as a node of a ROS 2 system."""

from __future__ import annotations

import os
import struct
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wbc.closeable import Closeable
from wbc.command import Status
from wbc.motions import MOTIONS, Motion, MotionPlayer
from wbc.motions.engine.packing import check_importable
from wbc.process import ChildProcess, ProcessStartError, RecordRing
from wbc.ros.bridge.helm import Helm
from wbc.ros.bridge.layout import HEAD, MOST, Layout, Mode
from wbc.ros.bridge.mailbox import Mailbox
from wbc.ros.bridge.order import Order
from wbc.ros.dds_types import import_cyclonedds
from wbc.ros.errors import RosError
from wbc.ros.network import Network
from wbc.telemetry import PHASES, Balance

if TYPE_CHECKING:
    from wbc.runtime.protocols import Controller, Plant
    from wbc.runtime.report import Report
    from wbc.runtime.tick import Tick

_STATUS = {status: i for i, status in enumerate(Status)}
_PHASE = {phase: i for i, phase in enumerate(PHASES)}
_UNKNOWN = Balance()
_HEAD = struct.Struct(f"={len(HEAD)}d")
_MORE = 2.0
_LYING = 0.02  # s between two looks at a robot that lies


class Bridge(Closeable):
    """Shows a robot to a ROS 2 system, and lets it be driven from there.

    All of DDS happens in another process. The loop's process copies ticks into shared memory, at
    some more than the rate at which they are published, and looks there for orders, microseconds
    in all; it never waits, and goes on, standing, when the other process has died.

    Example:
        >>> with Bridge(player, plant) as bridge:
        ...     drive(bridge, player, plant, 3600.0)

    Args:
        player: whom to drive.
        plant: what it is in; it may have `push` and `reset`.
        name: of the node.
        namespace: of the node.
        network: domain and interface; from the environment when left out.
        update_rate: of the joint states, Hz; a parameter of the node.
        use_sim_time: stamp messages with the plant's time, not the system's; likewise.
        motions: that may be asked for; the whole catalogue when left out.

    Attributes:
        helm: takes orders; `before_tick` of `wbc.run`.
        paces: the helm does not: the loop keeps the time.
        rescue: how a robot that fell is set on its feet.

    Raises:
        MissingExtra: `cyclonedds` is not installed.
        RosError: the node cannot be made.
        MotionError: a motion is not at the top of a module.
    """

    paces = False
    rescue = "/reset_robot sets it on its feet"

    def __init__(
        self,
        player: MotionPlayer,
        plant: Any,
        *,
        name: str = "wbc",
        namespace: str = "/",
        network: Network | None = None,
        update_rate: float = 50.0,
        use_sim_time: bool = False,
        motions: Sequence[type[Motion]] = MOTIONS,
    ) -> None:
        import_cyclonedds()
        for motion in motions:
            check_importable(motion)
        robot = player.robot
        layout = Layout.of(robot)
        self._soles = [sole.name for sole in robot.soles]
        self._no_wrench = np.full(6, np.nan)
        self._ring = RecordRing(layout.size)
        self._mailbox = Mailbox(robot.na)
        self.helm = Helm(self._mailbox, player, plant)
        self._run = 0
        self._before = time.perf_counter()
        self._last: np.ndarray | None = None
        self._dt, self._to_go = player.dt, 0  # ticks until one is shown
        self._timing: list[float] = []  # of the ticks since the last that was shown
        assert self._mailbox.descriptor is not None
        shelf, slip = self.helm.shelf.descriptor, self.helm.slip.descriptor
        self._process = ChildProcess(
            "wbc.ros.bridge.server",
            (self._ring.descriptor, self._mailbox.descriptor, shelf, slip),
            title="the ROS 2 node",
        )
        order = Order(
            robot=robot,
            name=name,
            space=namespace,
            network=network or Network.from_environment(),
            update_rate=update_rate,
            use_sim_time=use_sim_time,
            dt=player.dt,
            max_velocity=player.walker.gait.max_velocity,
            motions=tuple(motions),
            may_push=hasattr(plant, "push"),
            may_reset=hasattr(plant, "reset"),
            ring=self._ring.descriptor,
            mailbox=self._mailbox.descriptor,
            shelf=shelf,
            slip=slip,
            parent=os.getpid(),
        )
        try:
            self._process.configure(order)
        except BaseException as error:
            self.close()
            if isinstance(error, ProcessStartError):
                raise RosError(str(error)) from error
            raise

    @property
    def alive(self) -> bool:
        """Whether the node's process is there."""
        return self._process.alive

    @property
    def pid(self) -> int:
        """Of the node's process."""
        return self._process.pid

    def begin(self, controller: Controller, plant: Plant) -> None:
        """A run begins, see `Recorder`: orders from before it are forgotten."""
        self._run += 1
        self._before = time.perf_counter()
        self._to_go = 0
        self._timing.clear()
        self.helm.begin()

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
            self._to_go = min(int(1.0 / (_MORE * self._mailbox.latest.rate * self._dt)), MOST)
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
            self.helm.motions,
            self.helm.stage,
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

    @property
    def reset_wanted(self) -> bool:
        """Whether a reset has been asked for since the run began."""
        return self.helm.reset_wanted

    def heed(self, stop: Callable[[], bool]) -> None:
        """Nothing to do: its helm never waits."""

    def lie(self) -> None:
        """Show where it lies: a fallen robot has no ticks, but its sensors do not die."""
        time.sleep(_LYING)
        if self._last is None:
            return
        last = self._last.copy()
        record = self._ring.begin()
        record[:] = last
        record[HEAD.index("stamp")] = time.time()
        record[HEAD.index("mode")] = Mode.FALLEN
        record[HEAD.index("timed")] = self._tell_timing(record)  # those before the fall
        self._ring.publish()
        self._last = record

    def close(self) -> None:
        """End the node."""
        self._process.close()
        self._ring.close()
        self._mailbox.close()
        self.helm.close()
