"""Messages of which only numbers change: laid out once, then filled in place.

A joint state of 32 joints takes a fraction of the time of encoding it anew: writing it is
a copy into each view.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np

from wbc.messages.cdr import HEADER, Place, encode
from wbc.messages.errors import MessageError
from wbc.messages.message import Message

_STAMP = struct.Struct("<iI")


class Template:
    """The bytes of a message, with views of its numbers.

    Strings and the lengths of sequences stay as they are in the message that it was made
    from.

    Example:
        >>> JointState = message_type("sensor_msgs/msg/JointState")
        >>> template = Template(JointState(name=["knee"], position=[0.0]))
        >>> position = template.view("position")
        >>> position[:] = 0.3
        >>> template.stamp(1.25)
        >>> JointState.decode(template.data).position
        array([0.3])

    Args:
        message: the message as it is at first.

    Attributes:
        data: the bytes, header included; they change with the views.
        places: where its numbers lie.

    Raises:
        MessageError: a value of the message does not fit its field.
    """

    def __init__(self, message: Message) -> None:
        self.places: list[Place] = []
        first = encode(message.type_name, message, self.places)
        # The body is aligned, not the header: numpy copies faster into aligned numbers.
        lead = 8 - len(HEADER)
        memory = np.zeros(-(-(lead + len(first)) // 8), np.uint64)
        self.data = memory.view(np.uint8).data[lead : lead + len(first)]
        self.data[:] = first
        self._type_name = message.type_name
        self._stamps = [
            place.offset
            for place in self.places
            if place.path == "stamp.sec" or place.path.endswith(".stamp.sec")
        ]

    def place(self, path: str) -> Place:
        """Where the numbers of a field lie: an array, a number, or a message of numbers.

        Args:
            path: e.g. "position", "pose.pose" (seven numbers), "transforms[3].transform".

        Raises:
            MessageError: there is nothing of that name, or its numbers are not of one type
                and side by side.
        """
        found = [
            p for p in self.places if p.path == path or p.path.startswith((path + ".", path + "["))
        ]
        if not found:
            raise MessageError(
                f"{self._type_name} has no numbers '{path}'; there are: "
                + ", ".join(place.path for place in self.places[:12])
            )
        first = found[0]
        count = sum(place.count for place in found)
        last = found[-1]
        end = last.offset + last.count * last.dtype.itemsize
        if end - first.offset != count * first.dtype.itemsize or any(
            place.dtype != first.dtype for place in found
        ):
            raise MessageError(
                f"{self._type_name}: the numbers of '{path}' are not of one type and side by side; "
                "name a part of it"
            )
        return Place(path, first.offset, first.dtype, count)

    def view(self, path: str) -> np.ndarray:
        """The numbers of a field, (n,), to be written into; see `place`."""
        place = self.place(path)
        return np.frombuffer(self.data, place.dtype, place.count, place.offset)

    def stamp(self, time: float) -> None:
        """Write a time, s, into every `stamp` of the message."""
        seconds = int(time // 1)
        nanoseconds = round(1e9 * (time - seconds))
        if nanoseconds >= 1_000_000_000:
            seconds, nanoseconds = seconds + 1, nanoseconds - 1_000_000_000
        for offset in self._stamps:
            _STAMP.pack_into(self.data, offset, seconds, nanoseconds)

    def encode(self) -> bytes:
        """A copy of the bytes as they are now."""
        return bytes(self.data)

    def rows(self, count: int) -> np.ndarray[Any, np.dtype[np.uint8]]:
        """(count, n) copies of the bytes, to fill many messages at once column by column."""
        return np.tile(np.frombuffer(self.data, np.uint8), (count, 1))
