"""A stand-in robot in lockstep, with faults on its wire."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import wbc
from wbc.command import Command
from wbc.hardware import SafeHardware, UnitreeG1
from wbc.hardware.unitree.lockstep import Disturbance, LockstepTransport, undisturbed
from wbc.hardware.unitree.messages import LOW_STATE, MessageBuffer
from wbc.hardware.unitree.stand_in import G1StandIn
from wbc.measurement import Measurement
from wbc.robot import Robot
from wbc.runtime.report import Report


@dataclass
class HardwareRun:
    """A G1 behind its safety layer, on a wire that can be disturbed.

    Attributes:
        stand_in: the robot.
        transport: the wire.
        plant: the safety layer.
        command: the last command.
    """

    stand_in: G1StandIn
    transport: LockstepTransport
    plant: SafeHardware
    command: Command | None = None

    @classmethod
    def make(
        cls,
        *,
        on_state: Disturbance = undisturbed,
        on_command: Disturbance = undisturbed,
        machine: int = 5,
    ) -> HardwareRun:
        stand_in = G1StandIn(machine=machine)
        transport = LockstepTransport(stand_in, on_state=on_state, on_command=on_command)
        plant = SafeHardware(UnitreeG1(stand_in.robot, transport), on_transition=_ignore)
        return cls(stand_in, transport, plant)

    def run(self, duration: float, speed: float = 0.0) -> Report:
        walker = wbc.Walker(self.stand_in.robot)
        walker.velocity = (speed, 0.0, 0.0)
        return wbc.run(walker, self, duration)

    def hold(self, duration: float) -> None:
        """Repeat the last command."""
        end = self.plant.time + duration
        while self.plant.time < end:
            self.measure()
            self.step(self.command)

    # It is a plant that remembers the last command.

    @property
    def robot(self) -> Robot:
        return self.plant.robot

    @property
    def dt(self) -> float:
        return self.plant.dt

    @property
    def time(self) -> float:
        return self.plant.time

    def measure(self) -> Measurement:
        return self.plant.measure()

    def step(self, command: Command) -> None:
        self.command = command
        self.plant.step(command)


def _ignore(_: object) -> None:
    pass


def changed_state(data: bytes, change: Callable[[np.ndarray], None]) -> bytes:
    """Return a state message with changed fields and a right checksum."""
    buffer = MessageBuffer(LOW_STATE)
    assert buffer.decode(data)
    change(buffer.fields)
    return buffer.encode()


def flipped_bit(data: bytes, bit: int = 8 * 500) -> bytes:
    """Return a message with one bit flipped."""
    damaged = bytearray(data)
    damaged[bit // 8] ^= 1 << bit % 8
    return bytes(damaged)


def bitwise_checksum(body: bytes) -> int:
    """CRC-32 with the polynomial 0x04c11db7 over 32-bit words, bit by bit."""
    crc = 0xFFFF_FFFF
    for (word,) in struct.iter_unpack("<I", body[:-4]):
        for bit in range(31, -1, -1):
            top = crc >> 31
            crc = crc << 1 & 0xFFFF_FFFF
            if top ^ (word >> bit & 1):
                crc ^= 0x04C1_1DB7
    return crc
