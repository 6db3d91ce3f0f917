"""The bundled message types: those of ROS 2 Jazzy that are used here, and `wbc_msgs`.

As in ROS there is a folder per package: `definitions/<package>/{msg,srv,action}/<Name>.<kind>`.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from wbc.errors import did_you_mean
from wbc.messages.definition import MessageDefinition, full_name, parse
from wbc.messages.errors import MessageError

_HERE = Path(__file__).parent / "definitions"
_PART = {
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
_SEPARATOR = "=" * 80


@cache
def available_types() -> tuple[str, ...]:
    """Return the full names of all message types, including the parts of services and actions."""
    names = []
    for path in sorted(_HERE.glob("*/*/*")):
        name = f"{path.parts[-3]}/{path.parts[-2]}/{path.stem}"
        suffixes: tuple[str, ...] = _PART.get(path.parts[-2], ("",))
        if path.parts[-2] == "action":
            suffixes += tuple(_ACTION)
        names += [name + suffix for suffix in suffixes]
    return tuple(names)


@cache
def get_definition(name: str) -> MessageDefinition:
    """Return the definition of a message type.

    Args:
        name: `pkg/msg/Name`, `pkg/Name`, or a part of a service or an action:
            `pkg/srv/Name_Request`, `pkg/action/Name_Goal`, `pkg/action/Name_SendGoal_Request`.

    Raises:
        MessageError: there is no such type; the message suggests similar names.
    """
    name = full_name(name)
    package, kind, short = name.split("/")
    path = _HERE / package / kind / f"{short}.msg"
    if kind == "msg" and path.is_file():
        return parse(name, path.read_text("utf-8"))
    base, _, _ = short.partition("_")
    path = _HERE / package / kind / f"{base}.{kind}"
    suffix = short[len(base) :]
    if kind in _PART and path.is_file():
        if suffix in _PART[kind]:
            parts = path.read_text("utf-8").split("---\n")
            return parse(name, parts[_PART[kind].index(suffix)])
        if kind == "action" and suffix in _ACTION:
            return parse(name, _ACTION[suffix].format(f"{package}/action/{base}"))
    raise MessageError(f"there is no message type '{name}'{did_you_mean(name, available_types())}")


def dependencies(name: str) -> tuple[MessageDefinition, ...]:
    """Return the definitions of all message types nested in a type, each once."""
    found: dict[str, MessageDefinition] = {}

    def visit(one: MessageDefinition) -> None:
        for field in one.fields:
            if field.nested and field.type not in found:
                found[field.type] = get_definition(field.type)
                visit(found[field.type])

    visit(get_definition(name))
    return tuple(found.values())


@cache
def schema_text(name: str) -> str:
    """Return a type's definition and those of all nested types, in the format `ros2msg` of mcap."""
    parts = [get_definition(name).text]
    for one in dependencies(name):
        package, _, short = one.name.split("/")
        parts.append(f"{_SEPARATOR}\nMSG: {package}/{short}\n{one.text}")
    return "\n".join(parts) + "\n"
