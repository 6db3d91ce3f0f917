"""A process that damps a robot's joints when its controller's process has gone, even by SIGKILL.

`wbc.hardware.unitree.connect` starts it as `python -m wbc.hardware.unitree.guard`; see
`wbc.process.child`.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

from wbc.errors import WbcError
from wbc.hardware.unitree.transport import DdsTransport
from wbc.process import ParentConnection
from wbc.ros.network import Network

_PERIOD = 0.002  # s
_DAMPING_TIME = 1.0  # s for which the joints are commanded to damp
_WAIT = 10.0  # s, any time: the wait ends as soon as the parent has gone


@dataclass(frozen=True)
class GuardConfig:
    """Configuration of the process.

    Attributes:
        network: DDS domain and network interface.
    """

    network: Network


@dataclass(frozen=True)
class DampingMessage:
    """The command that damps the joints of this robot.

    Attributes:
        data: its bytes.
    """

    data: bytes


def main() -> None:
    """Wait until the parent has gone, and send the last damping message for a second."""
    parent = ParentConnection()
    try:
        transport = DdsTransport(parent.config.network)
    except WbcError as error:
        parent.reply({"error": str(error)})
        return
    messages: list[DampingMessage] = []
    parent.listen(messages.append)
    parent.reply({"ready": True})
    while not parent.gone:
        parent.wait(_WAIT)
    end = time.monotonic() + _DAMPING_TIME
    while messages and time.monotonic() < end:
        transport.send(messages[-1].data)
        time.sleep(_PERIOD)
    transport.close()


if __name__ == "__main__":
    main()
