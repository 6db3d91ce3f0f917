"""Services that need a simulator: `push` and `reset_robot`.

Both are of the type `std_srvs/Trigger`, which every ROS 2 system has, whereas a type of this
library would have to be built there first. Impulse and duration of the push are parameters
therefore.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

from wbc.messages import message_type
from wbc.robot import Robot
from wbc.ros.bridge.stamped_tick import StampedTick
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
_RESPONSE = message_type(f"{_TYPE}_Response")
_TIMEOUT = 5.0  # s within which the loop has to acknowledge a command
_FIRST_TICK = 0.5  # s within which the first tick after a reset arrives, if there are any


@dataclass(frozen=True)
class _Call:
    """A service call that waits for an outcome of its command, until a time on the monotonic clock.

    The text is the message of a successful response. The run is that of the robot at the call.
    """

    reply: ServiceReply
    outcome: CommandOutcome
    text: str
    deadline: float
    run: int


class SimulationServices:
    """Serves `push` and `reset_robot`.

    Args:
        node: node that serves them.
        client: sends the commands.
        robot: the robot.
    """

    def __init__(self, node: Node, client: CommandClient, robot: Robot) -> None:
        self._client = client
        largest = 2.0 * robot.mass  # N·s, a change of 2 m/s, after which no robot stays on its feet
        self._impulse = node.declare_parameter(
            "push_impulse",
            (0.0, round(0.1 * robot.mass, 1), 0.0),
            "impulse of a push on the torso, N·s, in the axes of odom",
            bounds=(-largest, largest),
        )
        self._duration = node.declare_parameter(
            "push_duration", 0.1, "duration of a push, s", bounds=(0.01, 2.0)
        )
        self._calls: dict[int, _Call] = {}  # by the number of the command
        self._resets: list[_Call] = []  # that are done, but not yet seen
        self._run = 0
        node.create_deferred_service(_TYPE, "push", self._push)
        node.create_deferred_service(_TYPE, "reset_robot", self._reset)
        node.create_timer(0.1, self._expire)

    def _push(self, _: Any, reply: ServiceReply) -> None:
        (x, y, z), duration = self._impulse.value, self._duration.value
        text = f"({x:g}, {y:g}, {z:g}) N·s over {duration:g} s"
        self._send(PushCommand((x, y, z), duration, "world"), reply, CommandOutcome.ACCEPTED, text)

    def _reset(self, _: Any, reply: ServiceReply) -> None:
        self._send(ResetCommand(), reply, CommandOutcome.DONE, "standing")

    def on_tick(self, tick: StampedTick) -> None:
        """Process a tick of the loop."""
        if tick.run != self._run:
            self._run = tick.run
            self._respond_to_resets()

    def _send(
        self, command: TeleopCommand, reply: ServiceReply, outcome: CommandOutcome, text: str
    ) -> None:
        try:
            number = self._client.send(command)
        except CommandRefused as error:
            reply.send(_RESPONSE(success=False, message=str(error)))
            return
        self._calls[number] = _Call(reply, outcome, text, _in(_TIMEOUT), self._run)

    def on_acknowledgement(self, acknowledgement: Acknowledgement) -> None:
        """Respond to the service call whose command is acknowledged, if its outcome is final."""
        call, outcome = self._calls.get(acknowledgement.id), acknowledgement.outcome
        if call is not None and (outcome is call.outcome or outcome is not CommandOutcome.ACCEPTED):
            success = outcome is call.outcome
            if success and outcome is CommandOutcome.DONE:
                del self._calls[acknowledgement.id]
                self._resets.append(replace(call, deadline=_in(_FIRST_TICK)))
                self._respond_to_resets()
            else:
                text = call.text if success else acknowledgement.reason
                self._respond(acknowledgement.id, success, text)

    def _respond_to_resets(self) -> None:
        """Respond to the resets that are done and that the robot's topics show.

        A reset is acknowledged before the first tick after it, which aborts every goal: also one
        that a client sent after a response that did not wait for it.
        """
        now, done, self._resets = time.monotonic(), self._resets, []
        for call in done:
            if call.run == self._run and now < call.deadline:
                self._resets.append(call)
            else:
                call.reply.send(_RESPONSE(success=True, message=call.text))

    def _expire(self) -> None:
        self._respond_to_resets()
        now = time.monotonic()
        for number in [n for n, call in self._calls.items() if now > call.deadline]:
            self._respond(number, False, f"the loop did not respond within {_TIMEOUT:g} s")

    def _respond(self, number: int, success: bool, text: str) -> None:
        self._calls.pop(number).reply.send(_RESPONSE(success=success, message=text))


def _in(duration: float) -> float:
    """Return a time on the monotonic clock, s from now."""
    return time.monotonic() + duration
