"""`Bridge`: a robot in a running loop, as a node of a ROS 2 system."""

from __future__ import annotations

import logging
import os
import time
from dataclasses import replace
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np

from wbc.command import Status
from wbc.process import Child, ChildError
from wbc.ros.bridge.helm import Helm
from wbc.ros.bridge.layout import HEAD, PHASES, Layout, Mode
from wbc.ros.bridge.mailbox import Mailbox
from wbc.ros.bridge.order import Order
from wbc.ros.bridge.ring import StateRing
from wbc.ros.errors import RosError
from wbc.ros.network import Network
from wbc.ros.wire import import_cyclonedds
from wbc.telemetry import Balance

if TYPE_CHECKING:
    from wbc.protocols import Controller, Plant
    from wbc.report import Report
    from wbc.tick import Tick
    from wbc.walking import Walker

logger = logging.getLogger(__name__)

_LOOK = 0.5  # s, between two looks whether the process is still there
_STATUS = {status: i for i, status in enumerate(Status)}
_PHASE = {phase: i for i, phase in enumerate(PHASES)}
_UNKNOWN = Balance()


class Bridge:
    """Shows a robot to a ROS 2 system, and lets it be driven from there.

    All of DDS happens in another process. The loop's process copies each tick into shared
    memory and looks there for orders, some microseconds in all; it never waits, and goes on,
    standing, when the other process has died.

    Example:
        >>> with Bridge(walker, plant) as bridge:
        ...     wbc.run(walker, plant, 60.0, log=bridge, before_tick=bridge.helm, real_time=True)

    Args:
        walker: whom to drive.
        plant: what it walks in; it may have `push` and `reset`.
        name: of the node.
        namespace: of the node.
        network: domain and interface; from the environment when left out.
        update_rate: of the joint states, Hz; a parameter of the node.

    Attributes:
        helm: takes orders; `before_tick` of `wbc.run`.

    Raises:
        MissingExtra: `cyclonedds` is not installed.
        RosError: the node cannot be made.
    """

    def __init__(
        self,
        walker: Walker,
        plant: Any,
        *,
        name: str = "wbc",
        namespace: str = "/",
        network: Network | None = None,
        update_rate: float = 50.0,
    ) -> None:
        import_cyclonedds()
        robot = walker.robot
        layout = Layout.of(robot)
        self._soles = [sole.name for sole in robot.soles]
        self._no_wrench = np.full(6, np.nan)
        self._ring = StateRing(layout.size)
        self._mailbox = Mailbox(robot.na)
        self.helm = Helm(self._mailbox, walker, plant)
        self._run = 0
        self._before = self._look = time.perf_counter()
        self._last: np.ndarray | None = None
        assert self._mailbox.descriptor is not None
        self._process = Child(
            "wbc.ros.bridge.server", (self._ring.descriptor, self._mailbox.descriptor)
        )
        order = Order(
            # A fresh copy: meshes that somebody has looked at stay at home.
            robot=replace(robot),
            name=name,
            space=namespace,
            network=network or Network.of(),
            update_rate=update_rate,
            dt=walker.dt,
            max_velocity=walker.gait.max_velocity,
            may_push=hasattr(plant, "push"),
            may_reset=hasattr(plant, "reset"),
            ring=self._ring.descriptor,
            mailbox=self._mailbox.descriptor,
            parent=os.getpid(),
        )
        try:
            self._process.introduce(order)
        except BaseException as error:
            self.close()
            if isinstance(error, ChildError):
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
        """A run begins, see `wbc.protocols.Recorder`: orders from before it are forgotten."""
        self._run += 1
        self._before = time.perf_counter()
        self.helm.begin()

    def record(self, tick: Tick, controller: Controller) -> None:
        """Show a tick. Never waits; whatever happens to the node, returns."""
        now = time.perf_counter()
        period, self._before = now - self._before, now
        if now >= self._look:
            self._look_after(now)
        balance: Balance = getattr(controller, "balance", _UNKNOWN)
        wrenches = tick.measurement.foot_wrenches or tick.command.wrenches
        record = self._ring.begin()
        np.concatenate(
            (
                tick.state.q,
                tick.state.v,
                tick.command.tau,
                balance.com,
                balance.dcm,
                balance.dcm_reference,
                balance.zmp,
                *[wrenches.get(name, self._no_wrench) for name in self._soles],
            ),
            out=record[len(HEAD) :],
        )
        record[: len(HEAD)] = (
            time.time(),
            tick.time,
            self._run,
            Mode.RUNNING,
            _STATUS[tick.command.status],
            _PHASE.get(balance.phase, 0),
            getattr(controller, "steps", 0),
            tick.estimator_time + tick.controller_time,
            period,
            getattr(controller, "dcm_error", np.nan),
        )
        self._ring.publish()
        self._last = record

    def end(self, report: Report) -> None:
        """The run is over, see `wbc.protocols.Recorder`."""

    def fallen(self) -> None:
        """Show where it lies, again: a fallen robot has no ticks, but its sensors do not die."""
        if self._last is None:
            return
        last = self._last.copy()
        record = self._ring.begin()
        record[:] = last
        record[0], record[3] = time.time(), Mode.FALLEN
        self._ring.publish()
        self._last = record

    def _look_after(self, now: float) -> None:
        """Report the end of the process, once."""
        self._look = now + _LOOK
        if not self._process.alive:
            self._look = float("inf")
            logger.warning(
                "the ROS 2 node's process has ended (exit code %s); the run goes on without it",
                self._process.exit_code,
            )

    def close(self) -> None:
        """End the node."""
        self._look = float("inf")
        self._process.close()
        self._ring.close()
        self._mailbox.close()

    def __enter__(self) -> Bridge:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
