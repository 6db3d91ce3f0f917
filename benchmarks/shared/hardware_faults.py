"""Faults injected into the wire of a simulated G1: when they are found, and what becomes of it."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import wbc
from wbc.hardware import SafeHardware, UnitreeG1
from wbc.hardware.unitree.lockstep import Disturbance, LockstepTransport, undisturbed
from wbc.hardware.unitree.messages import LOW_COMMAND, LOW_STATE, MessageBuffer
from wbc.hardware.unitree.stand_in import G1StandIn
from wbc.runtime.loop import StopRun

Row = dict[str, Any]
_STANDING = 1.2  # s under control, after which the gantry has let go
_LONGEST = 2.0  # s for a fault to be found
_AFTERWARDS = 3.0  # s of damping until the robot lies still
_COMMAND_TIMEOUT = 0.02  # s after which the robot damps its joints itself
#: The motors of a message shifted by ten, and those of the two sides exchanged.
_SHIFTED = [*range(19, 29), *range(19)]
_MIRRORED = [*range(6, 12), *range(6), 12, 13, 14, *range(22, 29), *range(15, 22)]


@dataclass
class FaultRun:
    """A simulated robot and its safety layer, on a wire that can be disturbed.

    Attributes:
        robot: the robot.
        wire: between both.
        plant: the safety layer.
        walker: controls it.
    """

    robot: G1StandIn
    wire: LockstepTransport
    plant: SafeHardware
    walker: wbc.Walker

    @classmethod
    def hanging(cls, seed: int = 0, latency: float = 0.0) -> FaultRun:
        """Return a robot that hangs in its gantry, and whose joints are damped."""
        robot = G1StandIn(seed=seed, latency=latency)
        wire = LockstepTransport(robot)
        plant = SafeHardware(UnitreeG1(robot.robot, wire), on_transition=lambda change: None)
        return cls(robot, wire, plant, wbc.Walker(robot.robot))

    def stand(self, duration: float) -> str:
        """Stand under control; return the fault that ended it, an empty text without one."""
        estimator = wbc.Estimator(self.plant.robot, self.plant.dt)
        standing = self.plant.robot.standing()
        estimator.reset(standing)
        self.walker.reset(standing)
        end, expected = self.wire.now() + duration, None
        try:
            while self.wire.now() < end:
                estimate = estimator.update(self.plant.measure(), acceleration=expected)
                command = self.walker.step(estimate)
                expected = command.acceleration
                self.plant.step(command)
        except (StopRun, wbc.WbcError) as error:
            return str(error)
        return ""

    def row(self, what: str, begin: float, reason: str) -> Row:
        """Wait until the joints are damped and the robot has come to rest; return what was seen."""
        found, limit = self.wire.now(), self.wire.now() + 0.1
        while not self.robot.damping and self.wire.now() < limit:
            self.wire.advance()
        damped, heights = self.wire.now(), list[float]()
        while self.wire.now() < damped + _AFTERWARDS:
            self.wire.advance()
            heights.append(float(self.robot.plant.ground_truth().q[2]))
        state = self.robot.plant.ground_truth()
        tilt = math.acos(np.clip(1.0 - 2.0 * (state.q[3] ** 2 + state.q[4] ** 2), -1.0, 1.0))
        return {
            "what": what,
            "found_after_ms": round(1e3 * (found - begin), 1),
            "damping_after_ms": round(1e3 * (damped - found), 1),
            "final": "damping" if self.robot.damping else "commanded",
            "base_height_m": round(float(state.q[2]), 2),
            "base_tilt_deg": round(math.degrees(tilt)),
            "sinking_speed_m_s": round(-min(np.diff(heights)) / self.plant.dt, 2),
            "reason": reason or "no fault",
        }


def _changed(change: Callable[[np.ndarray], None], dtype: Any = LOW_STATE) -> Disturbance:
    def disturb(time: float, data: bytes) -> list[bytes]:
        buffer = MessageBuffer(dtype)
        assert buffer.decode(data)
        change(buffer.fields)
        return [buffer.encode()]

    return disturb


def _set_motor(name: str, value: float) -> Disturbance:
    def change(fields: np.ndarray) -> None:
        fields["motor_state"][name][0, 3] = value

    return _changed(change)


def _freeze(name: str) -> Disturbance:
    kept: list[np.ndarray] = []

    def change(fields: np.ndarray) -> None:
        kept.extend([] if kept else [fields[name].copy()])
        fields[name] = kept[0]

    return _changed(change)


def _flip(time: float, data: bytes) -> list[bytes]:
    damaged = bytearray(data)
    damaged[500] ^= 1
    return [bytes(damaged)]


def _set_tilt(fields: np.ndarray) -> None:
    fields["imu_state"]["quaternion"][0] = (np.cos(0.5), np.sin(0.5), 0.0, 0.0)


def _press_stop(fields: np.ndarray) -> None:
    fields["wireless_remote"][0, 3] = 0b10


def _set_machine(fields: np.ndarray) -> None:
    fields["mode_machine"] = 4


def _reordered(share: float) -> Disturbance:
    """Lose a share of the messages, and deliver as many after the next one."""
    random, held = np.random.default_rng(0), list[bytes]()

    def disturb(time: float, data: bytes) -> list[bytes]:
        draw = random.random()
        if draw < share:
            return []
        if draw < 2.0 * share:
            held.append(data)
            return []
        arriving = [data, *held]
        held.clear()
        return arriving

    return disturb


def _ordered(order: list[int]) -> tuple[Disturbance, Disturbance]:
    """Exchange the motors in states and in commands, as swapped cables do."""

    def states(fields: np.ndarray) -> None:
        fields["motor_state"][0, order] = fields["motor_state"][0, :29].copy()

    def commands(fields: np.ndarray) -> None:
        fields["motor_cmd"][0, :29] = fields["motor_cmd"][0, order]

    return _changed(states), _changed(commands, LOW_COMMAND)


def fault_rows() -> list[Row]:
    """Inject each fault into a robot that stands, or that starts; return what was seen."""
    standing = FaultRun.hanging()
    standing.plant.start()
    assert standing.stand(_STANDING) == ""
    lossy = _reordered(0.05)
    under_control: dict[str, tuple[Disturbance, Disturbance]] = {
        "frozen IMU": (_freeze("imu_state"), undisturbed),
        "frozen encoders": (_freeze("motor_state"), undisturbed),
        "NaN of an encoder": (_set_motor("q", float("nan")), undisturbed),
        "encoder jump": (_set_motor("q", 1.2), undisturbed),
        "joint beyond its velocity": (_set_motor("dq", 40.0), undisturbed),
        "tilt": (_changed(_set_tilt), undisturbed),
        "stop key": (_changed(_press_stop), undisturbed),
        "all states lost": (lambda time, data: [], undisturbed),
        "all commands lost": (undisturbed, lambda time, data: []),
        "bits flipped in all states": (_flip, undisturbed),
        "bits flipped in all commands": (undisturbed, _flip),
        "5 % lost, 5 % reordered": (lossy, lossy),
        "end of the run": (undisturbed, undisturbed),
    }
    rows = []
    for name, (on_state, on_command) in under_control.items():
        run = copy.deepcopy(standing)
        run.wire.on_state, run.wire.on_command = on_state, on_command
        begin = run.wire.now()
        reason = run.stand(0.1 if name == "end of the run" else _LONGEST)
        if not reason:
            run.wire.on_state = run.wire.on_command = undisturbed
            begin = run.wire.now()
            run.plant.stop()
        rows.append(run.row(name, begin, reason))
    run = copy.deepcopy(standing)
    begin = run.wire.now()
    for _ in range(round(0.02 / run.plant.dt)):
        run.wire.advance()
    rows.append(run.row("pause of 20 ms", begin, run.stand(_LONGEST)))
    run = copy.deepcopy(standing)
    begin = run.wire.now()
    while run.wire.now() < begin + _COMMAND_TIMEOUT:
        run.wire.advance()
    rows.append(run.row("controller killed", begin, "the robot got no command for 20 ms"))
    return rows + [_start_row(name, *wires) for name, wires in _at_the_start().items()]


def _at_the_start() -> dict[str, tuple[Disturbance, Disturbance]]:
    shifted, mirrored = _ordered(_SHIFTED), _ordered(_MIRRORED)
    return {
        "another robot": (_changed(_set_machine), undisturbed),
        "states of other motors": (shifted[0], undisturbed),
        "commands to other motors": (undisturbed, shifted[1]),
        "other motors in both": shifted,
        "states of the other side": (mirrored[0], undisturbed),
        "commands to the other side": (undisturbed, mirrored[1]),
        "the other side in both": mirrored,
    }


def _start_row(name: str, on_state: Disturbance, on_command: Disturbance) -> Row:
    run = FaultRun.hanging()
    run.wire.on_state, run.wire.on_command = on_state, on_command
    reason = ""
    try:
        run.plant.start()
    except wbc.WbcError as error:
        reason = str(error)
    reason = reason or run.stand(_STANDING + _LONGEST)
    if not reason:
        run.plant.stop()
    return run.row(f"{name} (start)", 0.0, reason)
