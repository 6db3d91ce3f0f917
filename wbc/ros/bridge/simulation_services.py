"""Services that need a simulator: `push` and `reset_robot`.

Both are `std_srvs/Trigger`, which every ROS 2 system has; a type of our own would have to be built
there first. The push's impulse and duration are therefore parameters.
"""

from __future__ import annotations

import time
from typing import Any

from wbc.messages import message_type
from wbc.robot import Robot
from wbc.ros.node import Node
from wbc.ros.services import ServiceReply
from wbc.teleop import (
    Acknowledgement,
    CommandClient,
    CommandOutcome,
    CommandRefused,
    PushCommand,
    ResetCommand,
    TeleopCommand,
)

_TYPE = "std_srvs/srv/Trigger"
_TIMEOUT = 5.0  # s for the loop to answer


class SimulationServices:
    """Serves `push` and `reset_robot`.

    Args:
        node: serves them.
        client: sends the commands.
        robot: the robot.
    """

    def __init__(self, node: Node, client: CommandClient, robot: Robot) -> None:
        self._client = client
        self._response = message_type(f"{_TYPE}_Response")
        largest = 2.0 * robot.mass  # N·s: 2 m/s, which no robot survives
        self._impulse = node.declare_parameter(
            "push_impulse",
            (0.0, round(0.1 * robot.mass, 1), 0.0),
            "impulse of a push on the torso, N·s, axes of odom",
            minimum=-largest,
            maximum=largest,
        )
        self._duration = node.declare_parameter(
            "push_duration", 0.1, "duration of a push, s", minimum=0.01, maximum=2.0
        )
        # Number of a command -> the reply that waits for its outcome, until when, and its text.
        self._waiting: dict[int, tuple[ServiceReply, CommandOutcome, float, str]] = {}
        node.create_deferred_service(_TYPE, "push", self._push)
        node.create_deferred_service(_TYPE, "reset_robot", self._reset)
        node.create_timer(0.1, self._give_up)

    def _push(self, _: Any, reply: ServiceReply) -> None:
        x, y, z = (float(part) for part in self._impulse.value)
        duration = float(self._duration.value)
        text = f"({x:g}, {y:g}, {z:g}) N·s over {duration:g} s"
        self._send(PushCommand((x, y, z), duration, "world"), reply, CommandOutcome.ACCEPTED, text)

    def _reset(self, _: Any, reply: ServiceReply) -> None:
        self._send(ResetCommand(), reply, CommandOutcome.DONE, "standing")

    def _send(
        self, command: TeleopCommand, reply: ServiceReply, outcome: CommandOutcome, text: str
    ) -> None:
        try:
            number = self._client.send(command)
        except CommandRefused as error:
            reply.send(self._response(success=False, message=str(error)))
            return
        self._waiting[number] = (reply, outcome, time.monotonic() + _TIMEOUT, text)

    def on_acknowledgement(self, acknowledgement: Acknowledgement) -> None:
        """Reply to the service call whose command this is about, if its outcome is decided."""
        if acknowledgement.id not in self._waiting:
            return
        reply, outcome, _, text = self._waiting[acknowledgement.id]
        if acknowledgement.outcome is outcome:
            reply.send(self._response(success=True, message=text))
        elif acknowledgement.outcome is CommandOutcome.ACCEPTED:
            return
        else:
            reply.send(self._response(success=False, message=acknowledgement.reason))
        del self._waiting[acknowledgement.id]

    def _give_up(self) -> None:
        now = time.monotonic()
        for number, (reply, _, deadline, _) in tuple(self._waiting.items()):
            if now > deadline:
                del self._waiting[number]
                text = f"the loop did not answer within {_TIMEOUT:g} s"
                reply.send(self._response(success=False, message=text))
