"""The safety layer: the only way from hardware to a plant that a loop can run."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NoReturn

import numpy as np

from wbc.closeable import Closeable
from wbc.command import Command
from wbc.hardware.errors import HardwareError
from wbc.hardware.hardware import ConnectionState, Hardware
from wbc.hardware.safety.command_filter import CommandFilter
from wbc.hardware.safety.foot_load import FootLoad, feet_carry
from wbc.hardware.safety.limits import SafetyLimits
from wbc.hardware.safety.response_monitor import ResponseMonitor
from wbc.hardware.safety.state_stream import StateFault, StateStream
from wbc.hardware.safety.transitions import (
    OnTransition,
    SafetyState,
    Transition,
    log_transition,
)
from wbc.measurement import Measurement
from wbc.runtime.event import SAFETY, RunEvent
from wbc.runtime.loop import StopRun
from wbc.servo import ServoCommand, ServoGains
from wbc.servo_reference import ServoReference

_CONNECT_TIMEOUT = 5.0  # s
_DAMPING_TIME, _REST_TIMEOUT = 0.3, 5.0  # s, least and longest damping before the robot moves
_POSTURE_FREQUENCY, _CONTROL_FREQUENCY = 20.0, 10.0  # Hz, of the servos, at most
_CYCLES = 0.04  # of the servos per period: a servo may close its loop only when a command comes
_POSTURE_SPEED = 0.4  # rad/s
_LEAST_RAMP = 2.0  # s
_HOLD_TIME = 2.0  # s, least time to hold the posture
_BLEND_TIME = 0.5  # s from the posture to the controller


class SafeHardware(Closeable):
    """A robot as a plant, which damps its joints as soon as anything is wrong.

    It starts by `start`, which the first `measure` calls: damping, then slowly to the nominal
    posture, which it holds. The controller then takes over within half a second. Any fault, the end
    of the run (`stop`) and `close` lead back to damping, in the same tick; from then on nothing but
    damping is sent: another run takes another connection. A run with a fault ends with its reason.
    No option switches any of this off.

    The loop is locked to the robot's clock: `measure` waits for the next state message. A message
    that was lost is replaced by an extrapolation, so that every period has one measurement; further
    messages that came meanwhile are worked off at once.

    Args:
        hardware: the robot.
        limits: the limits.
        gains: gains of the servos while the controller commands; those of
            `ServoGains.for_robot` by default, lower for a period beyond 4 ms.
        ready: called in every period while the posture is held with the share of the weight that
            the feet carry, None if the robot does not measure joint torques; returns whether the
            controller may take over. By default it may when they carry 60 % of it.
        on_transition: called with every transition; logs it by default.

    Attributes:
        robot: its model.
        dt: control period, s: the period of the robot's state messages.
        state: what the robot is doing.
        fault: why the joints were damped; empty without a fault.
        transitions: all transitions so far.
        lateness: delay of the last command behind the robot's clock, s.
        max_lateness: largest such delay so far, s.
        latency: measures the time from a reading to the torque that answers it.
        emit: is told of every transition as an event of the run, see `EventSource`.
    """

    def __init__(
        self,
        hardware: Hardware,
        *,
        limits: SafetyLimits | None = None,
        gains: ServoGains | None = None,
        ready: Callable[[float | None], bool] = feet_carry,
        on_transition: OnTransition = log_transition,
    ) -> None:
        self.robot = hardware.robot
        self.dt = hardware.period
        self.state = SafetyState.DAMPING
        self.fault = ""
        self.transitions: list[Transition] = []
        self.emit: Callable[[RunEvent], object] = lambda _: None
        self.lateness = self.max_lateness = 0.0
        self._hardware = hardware
        self._limits = limits or SafetyLimits()
        self._states = StateStream(hardware, self._limits)
        self._response = ResponseMonitor(self.robot, self._limits, self.dt)
        self.latency = self._response.latency
        self._filter = CommandFilter(self.robot, self._limits, self.dt)
        control, posture = (
            ServoGains.for_robot(self.robot, min(frequency, _CYCLES / self.dt))
            for frequency in (_CONTROL_FREQUENCY, _POSTURE_FREQUENCY)
        )
        self._reference = ServoReference(gains or control, self.dt)
        self._ready, self._on_transition = ready, on_transition
        self._posture_gains = posture
        self._start_time = 0.0
        self._periods = 0
        self._stopped = self._closed = False

    @property
    def connection(self) -> ConnectionState:
        """Counters of the connection."""
        return self._hardware.connection

    @property
    def lost(self) -> int:
        """State messages that were replaced by extrapolations."""
        return self._states.lost

    @property
    def time(self) -> float:
        """Time of the robot's clock since the robot was ready, s."""
        return self._states.time - self._start_time

    # The start.

    def start(self) -> None:
        """Go from damping to the nominal posture, and hold it until the operator is ready.

        Raises:
            HardwareError: there is no robot, it is another one, it is not in a posture to start
                from, or a fault was found; its joints are damped then.
        """
        if not self._states.start(_CONNECT_TIMEOUT):
            raise HardwareError(
                f"no valid state message within {_CONNECT_TIMEOUT:g} s: check the cable, the "
                "network interface, and that the robot is on"
            )
        self._enter(SafetyState.DAMPING, "connected")
        try:
            self._come_to_rest()
            self._go_to_posture()
        except StopRun as stop:
            raise HardwareError(str(stop)) from stop
        self._start_time = self._states.time

    def _come_to_rest(self) -> None:
        """Damp the joints until they are still, and check the posture that they come to rest in."""
        names, limits, begin = self.robot.joint_names, self._limits, self._states.time
        while True:
            m = self._next()
            self._hardware.damp()
            fastest = int(np.argmax(np.abs(m.joint_velocity)))
            still = abs(m.joint_velocity[fastest]) < limits.start_velocity
            if still and m.time - begin > _DAMPING_TIME:
                break
            if m.time - begin > _REST_TIMEOUT:
                self._fail(
                    f"joint '{names[fastest]}' moves at {m.joint_velocity[fastest]:.2f} rad/s "
                    "although it is damped: hold the robot still"
                )
        distance = np.abs(m.joint_position - self.robot.q_nominal[7:])
        worst = int(np.argmax(distance))
        if distance[worst] > limits.start_distance:
            self._fail(
                f"joint '{names[worst]}' is {distance[worst]:.2f} rad from the nominal posture, "
                f"more than {limits.start_distance} rad: bring the robot near that posture"
            )

    def _go_to_posture(self) -> None:
        assert self._states.last is not None
        start, goal = self._states.last.joint_position, self.robot.q_nominal[7:]
        duration = max(_LEAST_RAMP, float(np.abs(goal - start).max()) / _POSTURE_SPEED)
        self._enter(SafetyState.POSTURE, f"to the nominal posture in {duration:.1f} s")
        begin, still, gains = self._states.time, np.zeros(self.robot.na), self._posture_gains
        foot_load = FootLoad(self.robot, self.dt)
        load: float | None = None
        while True:
            elapsed = self._states.time - begin
            if elapsed > duration + _HOLD_TIME and self._ready(load):
                return
            m = self._next()
            load = foot_load.update(m)
            share = 0.5 - 0.5 * math.cos(math.pi * min(elapsed / duration, 1.0))
            target = start + share * (goal - start)
            error = np.abs(m.joint_position - target)
            worst = int(np.argmax(error))
            held = elapsed > duration + 0.5 * _HOLD_TIME
            if error[worst] > (self._limits.posture_error if held else self._limits.tracking):
                self._fail(
                    f"joint '{self.robot.joint_names[worst]}' is {error[worst]:.2f} rad from its "
                    f"reference {'in' if held else 'on the way to'} the posture: it is blocked or "
                    "weak, or the motors have another order than the model's joints"
                )
            self._send(ServoCommand(target, still, still, min(1.0, elapsed) * gains.kp, gains.kd))

    # The run.

    def measure(self) -> Measurement:
        """Wait for the next reading and return it, its time counted from the start.

        Raises:
            HardwareError: see `start`, which the first call calls.
            StopRun: a fault was found, or the run is over; the joints are damped.
        """
        if not self.transitions:
            self.start()
        m = self._next()
        return replace(m, time=self.time)

    def step(self, command: Command) -> None:
        """Send a command, within the limits.

        Raises:
            StopRun: a fault was found, or the run is over; the joints are damped.
        """
        self._check_running()
        if self.state is SafetyState.DAMPING:
            self._fail("a command came before the robot was started")
        if self.state is SafetyState.POSTURE:
            self._enter(SafetyState.STANDING, "the controller takes over")
            self._periods = 0
        servo = self._reference.update(command)
        finite = servo.q.dot(servo.q) + servo.v.dot(servo.v) + servo.tau.dot(servo.tau)
        if not math.isfinite(finite):
            self._fail("the controller's command is not finite")
        if self.state is SafetyState.STANDING:
            servo = self._blended(servo, self._periods * self.dt / _BLEND_TIME)
            if self._periods * self.dt >= _BLEND_TIME:
                self._enter(SafetyState.CONTROL, "the controller has taken over")
        self._periods += 1
        self._send(servo)

    def _blended(self, servo: ServoCommand, share: float) -> ServoCommand:
        """Return a command between the posture (share 0) and the controller's (1)."""
        share, gains, goal = min(share, 1.0), self._posture_gains, self.robot.q_nominal[7:]
        kp = (1.0 - share) * gains.kp + share * servo.kp
        kd = (1.0 - share) * gains.kd + share * servo.kd
        q = goal + share * (servo.q - goal)
        return ServoCommand(q, share * servo.v, share * servo.tau, kp, kd)

    def _next(self) -> Measurement:
        """Return the measurement of the next period of the robot's clock."""
        self._check_running()
        try:
            m, was_read = self._states.next()
        except StateFault as fault:
            self._fail(str(fault))
        if was_read and (unanswered := self._response.fault(m)):
            self._fail(unanswered)
        return m

    def _check_running(self) -> None:
        if self.fault or self._stopped:
            raise StopRun(self.fault or "the run is over: connect to the robot anew")

    def _send(self, servo: ServoCommand) -> None:
        m = self._states.last
        assert m is not None
        late = self.lateness = self._states.delay()
        self.max_lateness = max(self.max_lateness, late)
        if late > self._limits.lateness:
            self._fail(f"the controller is {1e3 * late:.0f} ms behind the robot's clock")
        servo = self._filter.apply(servo, m)
        self.latency.commanded(servo)
        self._hardware.send(servo)

    # The end.

    def _enter(self, state: SafetyState, reason: str) -> None:
        self.state = state
        self.transitions.append(Transition(self._states.time, state, reason))
        self._on_transition(self.transitions[-1])
        time = self.time if self._start_time else 0.0
        self.emit(RunEvent(time, SAFETY, "safety", 0, state.value, reason=reason))

    def _fail(self, reason: str) -> NoReturn:
        """Damp the joints for good.

        Raises:
            StopRun: always.
        """
        self._hardware.damp()
        self.fault = reason
        self._enter(SafetyState.DAMPING, reason)
        raise StopRun(reason)

    def stop(self) -> None:
        """Damp the joints for good; `wbc.run` does it right after the last tick."""
        if self._stopped:
            return
        self._stopped = True
        self._hardware.damp()
        if self.state is not SafetyState.DAMPING:
            self._enter(SafetyState.DAMPING, "the run is over")

    def close(self) -> None:
        """Damp the joints and end the connection."""
        if self._closed:
            return
        self._closed = True
        self.stop()
        self._hardware.close()
