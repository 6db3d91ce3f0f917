"""Finds faults in the readings of a robot."""

from __future__ import annotations

import math

import numpy as np

from wbc.hardware.hardware import Reading
from wbc.hardware.safety.limits import SafetyLimits
from wbc.measurement import Measurement
from wbc.robot import Robot


class ReadingMonitor:
    """Checks one reading after the other.

    Args:
        robot: its joint limits.
        limits: the limits.
    """

    def __init__(self, robot: Robot, limits: SafetyLimits) -> None:
        self._names = robot.joint_names
        self._limits = limits
        self._low = robot.q_min - limits.position_margin
        self._high = robot.q_max + limits.position_margin
        self._speed = limits.velocity * np.asarray(robot.v_max)
        self._jump_speed = np.minimum(self._speed, 100.0)
        self._last: Measurement | None = None
        self._changed_at = {"joint positions": 0.0, "gyro": 0.0, "accelerometer": 0.0}

    def fault(self, reading: Reading) -> str:
        """Return what is wrong with a reading; an empty text if nothing is."""
        m, last = reading.measurement, self._last
        for name, values in (
            ("joint position", m.joint_position),
            ("joint velocity", m.joint_velocity),
            ("gyro", m.gyro),
            ("accelerometer", m.accelerometer),
            ("joint torque", np.zeros(0) if m.joint_torque is None else m.joint_torque),
        ):
            if not math.isfinite(values.dot(values)):
                index = int(np.flatnonzero(~np.isfinite(values))[0])
                where = f" of '{self._names[index]}'" if name.startswith("joint") else f"[{index}]"
                return f"the {name}{where} is {values[index]}"
        if reading.stop_pressed:
            return "the operator pressed the stop key"
        if reading.tilt > self._limits.tilt:
            return (
                f"the base is tilted by {reading.tilt:.2f} rad, more than {self._limits.tilt} rad"
            )
        self._last = m
        q, v = m.joint_position, m.joint_velocity
        if last is not None:
            elapsed = max(m.time - last.time, 0.0)
            jump = np.abs(q - last.joint_position)
            allowed = self._jump_speed * elapsed + self._limits.jump_margin
            if (jump > allowed).any():
                return self._joint_fault("jumped by", jump, allowed, "rad")
            frozen = self._frozen(m, last)
            if frozen:
                return frozen
        else:
            self._changed_at = dict.fromkeys(self._changed_at, m.time)
        if (np.abs(v) > self._speed).any():
            return self._joint_fault("moves at", np.abs(v), self._speed, "rad/s")
        beyond = np.maximum(q - self._high, self._low - q)
        if (beyond > 0.0).any():
            worst = int(np.argmax(beyond))
            return (
                f"joint '{self._names[worst]}' is at {q[worst]:.3f} rad, outside of its range by "
                f"{beyond[worst] + self._limits.position_margin:.3f} rad"
            )
        return ""

    def _joint_fault(self, what: str, values: np.ndarray, limits: np.ndarray, unit: str) -> str:
        worst = int(np.argmax(values - limits))
        return (
            f"joint '{self._names[worst]}' {what} {values[worst]:.3f} {unit}, more than "
            f"{limits[worst]:.3f} {unit}"
        )

    def _frozen(self, m: Measurement, last: Measurement) -> str:
        pairs = (
            ("joint positions", m.joint_position, last.joint_position),
            ("gyro", m.gyro, last.gyro),
            ("accelerometer", m.accelerometer, last.accelerometer),
        )
        for name, now, before in pairs:
            if not np.array_equal(now, before):
                self._changed_at[name] = m.time
            elif m.time - self._changed_at[name] > self._limits.frozen - 1e-9:
                frozen = 1e3 * (m.time - self._changed_at[name])
                return (
                    f"the readings of the {name} have not changed for {frozen:.0f} ms: "
                    "the sensor is frozen"
                )
        return ""
