"""Gait parameters and gains of tasks as parameters of the node."""

from __future__ import annotations

import logging
from functools import partial
from typing import Literal, cast

from wbc.ros.node import Node
from wbc.teleop import (
    CommandClient,
    CommandRefused,
    GainCommand,
    GaitParameterCommand,
    TunableParameter,
)
from wbc.teleop.parameters import GAIT, TIME, VELOCITY

logger = logging.getLogger(__name__)

_PERIOD = 0.01  # s between two attempts to send
_SENT_AT_ONCE = 8  # commands: fewer than the channel holds


class TunableParameters:
    """Declares a parameter for each number that a command may set, e.g. `gait.swing_height`.

    Args:
        node: node that gets the parameters.
        client: sends the commands.
    """

    def __init__(self, node: Node, client: CommandClient) -> None:
        self._client = client
        self._waiting: dict[TunableParameter, float] = {}  # a parameter file sets many at once
        for parameter in client.capabilities.parameters:
            if parameter.group in (VELOCITY, TIME):
                continue
            unit = f", {parameter.unit}" if parameter.unit else ""
            of_task = "" if parameter.group == GAIT else f" of the task {parameter.group}"
            node.declare_parameter(
                parameter.name,
                parameter.default,
                f"{parameter.label}{of_task}{unit}",
                bounds=(parameter.low, parameter.high),
                on_change=partial(self._waiting.__setitem__, parameter),
            )
        node.create_timer(_PERIOD, self._send)

    def _send(self) -> None:
        for parameter in list(self._waiting)[:_SENT_AT_ONCE]:
            group, _, name = parameter.name.rpartition(".")
            value = self._waiting.pop(parameter)
            command = (
                GaitParameterCommand(name, value)
                if parameter.group == GAIT
                else GainCommand(group, cast(Literal["weight", "kp", "kd"], name), value)
            )
            try:
                self._client.send(command)
            except CommandRefused as error:
                logger.warning("parameter %s: %s", parameter.name, error)
