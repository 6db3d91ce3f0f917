"""The messages of Unitree's low-level interface for humanoids (`unitree_hg`), and their checksum.

In memory a message has the layout of the maker's C structure, over which its checksum goes. On the
wire it is CDR (XCDR1, little-endian), which aligns numbers but not structures: the first motor
comes two bytes earlier there, and all that follows its mode four bytes. Padding is zero in the
structure and may hold anything on the wire. Layout and checksum follow the maker's SDK
(`unitree_sdk2`, BSD-3).
"""

from __future__ import annotations

import zlib
from functools import cache
from typing import Any

import numpy as np

MOTORS = 35  #: in a message; a G1 uses the first 29

COMMAND_TOPIC, STATE_TOPIC = "rt/lowcmd", "rt/lowstate"

_MOTOR_COMMAND = np.dtype(
    [
        ("mode", "u1"), ("q", "<f4"), ("dq", "<f4"), ("tau", "<f4"), ("kp", "<f4"), ("kd", "<f4"),
        ("reserve", "<u4"),
    ],
    align=True,
)  # fmt: skip
_MOTOR_STATE = np.dtype(
    [
        ("mode", "u1"), ("q", "<f4"), ("dq", "<f4"), ("ddq", "<f4"), ("tau_est", "<f4"),
        ("temperature", "<i2", 2), ("vol", "<f4"), ("sensor", "<u4", 2), ("motorstate", "<u4"),
        ("reserve", "<u4", 4),
    ],
    align=True,
)  # fmt: skip
_IMU_STATE = np.dtype(
    [
        ("quaternion", "<f4", 4), ("gyroscope", "<f4", 3), ("accelerometer", "<f4", 3),
        ("rpy", "<f4", 3), ("temperature", "<i2"),
    ],
    align=True,
)  # fmt: skip
#: `unitree_hg::msg::dds_::LowCmd_`.
LOW_COMMAND = np.dtype(
    [
        ("mode_pr", "u1"), ("mode_machine", "u1"), ("motor_cmd", _MOTOR_COMMAND, MOTORS),
        ("reserve", "<u4", 4), ("crc", "<u4"),
    ],
    align=True,
)  # fmt: skip
#: `unitree_hg::msg::dds_::LowState_`.
LOW_STATE = np.dtype(
    [
        ("version", "<u4", 2), ("mode_pr", "u1"), ("mode_machine", "u1"), ("tick", "<u4"),
        ("imu_state", _IMU_STATE), ("motor_state", _MOTOR_STATE, MOTORS),
        ("wireless_remote", "u1", 40), ("reserve", "<u4", 4), ("crc", "<u4"),
    ],
    align=True,
)  # fmt: skip

_HEADER = b"\x00\x01\x00\x00"  # of CDR: XCDR1, little-endian
_REVERSED_BITS = bytes(int(f"{i:08b}"[::-1], 2) for i in range(256))


def checksum(body: bytes | bytearray | memoryview) -> int:
    """Return the CRC-32 of a message's words, most significant bit first.

    The polynomial is 0x04c11db7, the initial value 0xffffffff, without reflection and final
    inversion (CRC-32/MPEG-2), over the little-endian 32-bit words before the last one.

    Args:
        body: the message without its CDR header; its last word holds the checksum.
    """
    words = np.frombuffer(body, "<u4")[:-1].astype(">u4").tobytes()
    # zlib computes the reflected CRC with a final inversion.
    reflected = zlib.crc32(words.translate(_REVERSED_BITS)) ^ 0xFFFF_FFFF
    return int(f"{reflected:032b}"[::-1], 2)


@cache
def _meaning(dtype: np.dtype[Any]) -> np.ndarray:
    """Return 1 for each byte of a record that belongs to a field, and 0 for padding."""
    mask = np.zeros(dtype.itemsize, np.uint8)
    if dtype.fields is None:
        if dtype.subdtype is not None:
            element, shape = dtype.subdtype
            return np.tile(_meaning(element), int(np.prod(shape)))
        mask[:] = 1
        return mask
    for field, offset in ((entry[0], entry[1]) for entry in dtype.fields.values()):
        mask[offset : offset + field.itemsize] = _meaning(field)
    return mask


class MessageBuffer:
    """One message in preallocated memory.

    Args:
        dtype: `LOW_COMMAND` or `LOW_STATE`.
    """

    def __init__(self, dtype: np.dtype[Any]) -> None:
        self._dtype = dtype
        self._body = np.zeros(dtype.itemsize, np.uint8)
        assert dtype.fields is not None
        motors = "motor_cmd" if dtype is LOW_COMMAND else "motor_state"
        self._first_motor = int(dtype.fields[motors][1])

    @property
    def fields(self) -> np.ndarray:
        """The fields of the message, a view of its memory, (1,) of the type."""
        fields: np.ndarray = self._body.view(self._dtype)
        return fields

    def encode(self) -> bytes:
        """Write the checksum and return the message on the wire, CDR header included."""
        self.fields["crc"] = checksum(self._body.data)
        body, at = self._body.tobytes(), self._first_motor
        return b"".join((_HEADER, body[: at - 2], body[at : at + 2], body[at + 4 :]))

    def decode(self, data: bytes) -> bool:
        """Take in a received message; return whether its size and checksum are right."""
        body = self._body_of(data)
        if body is None or checksum(body.data) != int.from_bytes(data[-4:], "little"):
            return False
        self._body[:] = body
        return True

    def decode_without_checksum(self, data: bytes) -> bool:
        """Take in a received message whose checksum is 0, which stands for none as in UDP.

        Returns:
            Whether its size is right and its checksum 0.
        """
        body = self._body_of(data)
        if body is None or any(data[-4:]):
            return False
        self._body[:] = body
        return True

    def _body_of(self, data: bytes) -> np.ndarray | None:
        """Return the bytes of the structure of a message; None if its size is wrong."""
        if len(data) != self._body.size or data[1] not in (1, 7):  # little-endian
            return None
        at = self._first_motor + 2  # on the wire, where the CDR header takes 4 bytes
        structure = b"".join((data[4:at], b"\0\0", data[at : at + 2], b"\0\0", data[at + 2 :]))
        body: np.ndarray = np.frombuffer(structure, np.uint8) * _meaning(self._dtype)
        return body


@cache
def dds_type(name: str) -> Any:
    """Return the class of DDS samples of a message, which carry its bytes.

    Args:
        name: `LowCmd_` or `LowState_`.

    Raises:
        MissingExtra: `cyclonedds` is not installed.
    """
    from wbc.ros.dds_types import import_cyclonedds, struct_of_bytes

    import_cyclonedds()
    from cyclonedds.idl import make_idl_struct
    from cyclonedds.idl.types import array, float32, int16, uint8, uint32

    def struct(short: str, **fields: Any) -> Any:
        return make_idl_struct(short, f"unitree_hg.msg.dds_.{short}", fields, dataclassify=False)

    if name == "LowCmd_":
        motor = struct(
            "MotorCmd_", mode=uint8, q=float32, dq=float32, tau=float32, kp=float32, kd=float32,
            reserve=uint32,
        )  # fmt: skip
        whole = struct(
            "LowCmd_", mode_pr=uint8, mode_machine=uint8, motor_cmd=array[motor, MOTORS],
            reserve=array[uint32, 4], crc=uint32,
        )  # fmt: skip
    else:
        imu = struct(
            "IMUState_", quaternion=array[float32, 4], gyroscope=array[float32, 3],
            accelerometer=array[float32, 3], rpy=array[float32, 3], temperature=int16,
        )  # fmt: skip
        motor = struct(
            "MotorState_", mode=uint8, q=float32, dq=float32, ddq=float32, tau_est=float32,
            temperature=array[int16, 2], vol=float32, sensor=array[uint32, 2], motorstate=uint32,
            reserve=array[uint32, 4],
        )  # fmt: skip
        whole = struct(
            "LowState_", version=array[uint32, 2], mode_pr=uint8, mode_machine=uint8, tick=uint32,
            imu_state=imu, motor_state=array[motor, MOTORS], wireless_remote=array[uint8, 40],
            reserve=array[uint32, 4], crc=uint32,
        )  # fmt: skip
    return struct_of_bytes(whole)
