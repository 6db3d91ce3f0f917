"""The definitions of all message types: those of ROS 2 Jazzy in `rosbags`, and those it lacks.

The latter are in `definitions/<package>/{msg,srv,action}/<Name>.<kind>`, as in ROS.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from wbc.errors import MissingExtra

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

_DEFINITIONS = Path(__file__).parent / "definitions"
#: Suffixes of the messages that a file defines.
_PARTS = {
    "msg": ("",),
    "srv": ("_Request", "_Response"),
    "action": ("_Goal", "_Result", "_Feedback"),
}
_UUID = "unique_identifier_msgs/UUID goal_id\n"
#: Messages by which an action is sent over DDS: suffix and definition; {0} is the action's name.
_ACTION = {
    "_SendGoal_Request": _UUID + "{0}_Goal goal\n",
    "_SendGoal_Response": "bool accepted\nbuiltin_interfaces/Time stamp\n",
    "_GetResult_Request": _UUID,
    "_GetResult_Response": "int8 status\n{0}_Result result\n",
    "_FeedbackMessage": _UUID + "{0}_Feedback feedback\n",
}
#: DDS has no empty structure: ROS gives one this member.
_EMPTY = "structure_needs_at_least_one_member"


@cache
def typestore() -> Typestore:
    """Return the definitions of all message types.

    A part of a service or of an action is a message type `pkg/srv/Name_Request`,
    `pkg/action/Name_Goal`, `pkg/action/Name_SendGoal_Request`, and so on.

    Raises:
        MissingExtra: `rosbags` is not installed.
    """
    try:
        from rosbags.interfaces import Nodetype
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ImportError as error:
        raise MissingExtra("rosbags", "log", "ros2") from error
    store = get_typestore(Stores.ROS2_JAZZY)
    for path in sorted(_DEFINITIONS.glob("*/*/*")):
        package, kind = path.parts[-3:-1]
        name = f"{package}/{kind}/{path.stem}"
        parts = dict(zip(_PARTS[kind], path.read_text("utf-8").split("---\n"), strict=True))
        if kind == "action":
            parts.update({suffix: text.format(name) for suffix, text in _ACTION.items()})
        for suffix, text in parts.items():
            # With the name of a message the parser finds other messages of the package.
            found = get_types_from_msg(text, f"{package}/msg/{path.stem}")
            constants, fields = found.popitem()[1]
            nothing: Any = (_EMPTY, (Nodetype.BASE, ("uint8", 0)))
            store.fielddefs[name + suffix] = (constants, fields or [nothing])
    return store


def number_dtype(primitive: str) -> np.dtype[Any]:
    """Return the type of the numbers of a primitive type, for example of "float64"."""
    return np.dtype({"bool": "?", "char": "u1"}.get(primitive, primitive))
