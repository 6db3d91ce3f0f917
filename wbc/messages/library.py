"""The message types that come along: their texts, as ROS 2 Jazzy has them, and our own.

A folder per package, as in ROS: `definitions/<package>/{msg,srv,action}/<Name>.<kind>`.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from wbc.errors import did_you_mean
from wbc.messages.definition import Definition, full_name, parse
from wbc.messages.errors import MessageError

_HERE = Path(__file__).parent / "definitions"
_PART = {
    "srv": ("_Request", "_Response"),
    "action": ("_Goal", "_Result", "_Feedback"),
}
_UUID = "unique_identifier_msgs/UUID goal_id\n"
#: What an action is made of on the wire: suffix, then the text, {0} being the action's name.
_ACTION = {
    "_SendGoal_Request": _UUID + "{0}_Goal goal\n",
    "_SendGoal_Response": "bool accepted\nbuiltin_interfaces/Time stamp\n",
    "_GetResult_Request": _UUID,
    "_GetResult_Response": "int8 status\n{0}_Result result\n",
    "_FeedbackMessage": _UUID + "{0}_Feedback feedback\n",
}
_SEPARATOR = "=" * 80


@cache
def available() -> tuple[str, ...]:
    """Full names of all types, services and actions with their parts."""
    names = []
    for path in sorted(_HERE.glob("*/*/*")):
        name = f"{path.parts[-3]}/{path.parts[-2]}/{path.stem}"
        suffixes: tuple[str, ...] = _PART.get(path.parts[-2], ("",))
        if path.parts[-2] == "action":
            suffixes += tuple(_ACTION)
        names += [name + suffix for suffix in suffixes]
    return tuple(names)


@cache
def definition(name: str) -> Definition:
    """The definition of a message type.

    Args:
        name: `pkg/msg/Name`, `pkg/Name`, or a part of a service or an action:
            `pkg/srv/Name_Request`, `pkg/action/Name_Goal`, `pkg/action/Name_SendGoal_Request`.

    Raises:
        MessageError: there is no such type; the text lists near names.
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
    raise MessageError(f"there is no message type '{name}'{did_you_mean(name, available())}")


def dependencies(name: str) -> tuple[Definition, ...]:
    """The definitions of all message types inside a type, each once, without its own."""
    found: dict[str, Definition] = {}

    def visit(one: Definition) -> None:
        for field in one.fields:
            if field.nested and field.type not in found:
                found[field.type] = definition(field.type)
                visit(found[field.type])

    visit(definition(name))
    return tuple(found.values())


@cache
def schema_text(name: str) -> str:
    """A type's text and those of all types in it, as ROS 2 writes it into mcap (`ros2msg`)."""
    parts = [definition(name).text]
    for one in dependencies(name):
        package, _, short = one.name.split("/")
        parts.append(f"{_SEPARATOR}\nMSG: {package}/{short}\n{one.text}")
    return "\n".join(parts) + "\n"
