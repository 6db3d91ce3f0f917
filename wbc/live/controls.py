"""The controls of the page, and the command that each of its requests gives."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from wbc.errors import MotionError, did_you_mean, short_repr
from wbc.live.uploads import ROBOT_SUFFIXES, Uploads
from wbc.motions.engine import create_motion, describe_motion
from wbc.teleop import (
    Capabilities,
    CommandRefused,
    FrameTaskCommand,
    GainCommand,
    GaitParameterCommand,
    HandTargetCommand,
    MotionCommand,
    PauseCommand,
    PullCommand,
    PushCommand,
    ResetCommand,
    StandCommand,
    StartSessionCommand,
    TeleopCommand,
    TimeScaleCommand,
    TunableParameter,
    VelocityCommand,
)
from wbc.teleop.capabilities import unknown_motion
from wbc.teleop.parameters import GAIT, TIME, VELOCITY

MAX_LENGTH = 4000  # characters of a message
_ACTIONS = (
    "push", "pull", "walk_to", "signals", "save", "motion", "pause", "stand", "reset",
    "start_session", "hand", "frame_task",
)  # fmt: skip
_SOURCES = ("page", "keyboard")
_PUSH_SHARE = 0.3  # of the largest push; the robot hardly ever survives a larger one


@dataclass(frozen=True)
class Request:
    """A message of a page: `{"control": NAME, "value": …}`, with an optional "source".

    Attributes:
        control: Name of the control.
        value: Its new value.
        source: Who uses it, "page" or "keyboard".
    """

    control: str
    value: Any
    source: str


class Controls:
    """Translates requests of pages into commands, and keeps the values of the sliders.

    Args:
        capabilities: Commands that the robot accepts.
        uploads: The files that requests may name.

    Attributes:
        values: Maps the name of each parameter to its present value.
        frame_tasks: Maps link and kind of each added task to its weight.
        max_impulse: Largest push that the page offers, N·s.
    """

    def __init__(self, capabilities: Capabilities, uploads: Uploads) -> None:
        self._capabilities, self._uploads = capabilities, uploads
        self.values = {p.name: p.default for p in capabilities.parameters}
        self.frame_tasks: dict[tuple[str, str], float] = {}
        self.max_impulse = float(f"{_PUSH_SHARE * capabilities.max_impulse:.2g}")

    def describe(self) -> dict[str, Any]:
        """Return the parameters, motions, sessions and largest push for the page, as JSON."""
        return {
            "parameters": [asdict(p) for p in self._capabilities.parameters],
            "motions": [describe_motion(motion) for motion in self._capabilities.motions],
            "max_impulse": self.max_impulse,
            "hands": self._capabilities.hands,
            "task_frames": self._capabilities.task_frames,
            "sessions": self._describe_sessions(),
        }

    def _describe_sessions(self) -> dict[str, Any] | None:
        """Return what another session may be started with; files are named without their folder."""
        choices = self._capabilities.sessions
        if choices is None:
            return None
        present = asdict(choices.present)
        if present["robot"] not in choices.robots:
            present["robot"] = Path(present["robot"]).name
        return {"robots": choices.robots, "terrains": choices.terrains, "present": present}

    def command(self, request: Request) -> TeleopCommand:
        """Return the command of a request.

        Raises:
            CommandRefused: The request is invalid; the text states the reason.
        """
        name, value = request.control, request.value
        for parameter in self._capabilities.parameters:
            if parameter.name == name:
                return self._parameter_command(parameter, value)
        match name:
            case "push":
                return _push_command(value)
            case "pull":
                return _pull_command(value)
            case "motion":
                return self._motion_command(value)
            case "pause":
                return PauseCommand(value)
            case "stand":
                return StandCommand()
            case "reset":
                return ResetCommand()
            case "frame_task":
                return _frame_task_command(value)
            case "hand":
                return _hand_command(value)
            case "start_session":
                return self._session_command(value)
        names = [*self.values, *_ACTIONS]
        raise CommandRefused(f"no control {short_repr(name)}{did_you_mean(name, names)}")

    def apply(self, command: TeleopCommand) -> dict[str, float]:
        """Update the sliders to a command; return the values that may have changed."""
        match command:
            case VelocityCommand(forward, left, turn):
                changes = dict(zip(self._velocity_names, (forward, left, turn), strict=True))
                changes = {k: float(v) for k, v in changes.items() if v != self.values[k]}
            case TimeScaleCommand(value):
                changes = {"speed": float(value)}
            case GaitParameterCommand(name, value):
                changes = {f"{GAIT}.{name}": float(value)}
            case GainCommand(task, gain, value):
                changes = {f"{task}.{gain}": float(value)}
            case _:
                return {}
        self.values.update(changes)
        return changes

    def apply_frame_task(self, command: FrameTaskCommand) -> None:
        """Note a task that is added, weighted or removed."""
        self.frame_tasks.pop((command.frame, command.kind), None)
        if command.weight > 0.0:
            self.frame_tasks[command.frame, command.kind] = command.weight

    def describe_frame_tasks(self) -> list[dict[str, Any]]:
        """Return the added tasks as JSON."""
        return [
            {"frame": frame, "kind": kind, "weight": weight}
            for (frame, kind), weight in self.frame_tasks.items()
        ]

    def zero_velocity(self) -> dict[str, float]:
        """Set the velocity sliders to zero, as the loop has done; return their values."""
        zeros = dict.fromkeys(self._velocity_names, 0.0)
        self.values.update(zeros)
        return zeros

    @property
    def _velocity_names(self) -> list[str]:
        return [p.name for p in self._capabilities.parameters if p.group == VELOCITY]

    def _parameter_command(self, parameter: TunableParameter, value: Any) -> TeleopCommand:
        group, _, field = parameter.name.partition(".")
        if parameter.group == VELOCITY:
            values = {**self.values, parameter.name: value}
            return VelocityCommand(*(values[name] for name in self._velocity_names))
        if parameter.group == TIME:
            return TimeScaleCommand(value)
        if parameter.group == GAIT:
            return GaitParameterCommand(field, value)
        return GainCommand(group, field, value)  # type: ignore[arg-type]

    def _motion_command(self, value: Any) -> MotionCommand:
        name, parameters = value, {}
        if isinstance(value, dict) and value.keys() == {"name", "parameters"}:
            name, parameters = value["name"], value["parameters"]
        for motion in self._capabilities.motions:
            if motion.name == name:
                if isinstance(parameters, dict):
                    files = {p.name: p.suffixes for p in motion.parameters() if p.suffixes}
                    named = [name for name in files if parameters.get(name, "") != ""]
                    found = {p: str(self._uploads.find(parameters[p], files[p])) for p in named}
                    parameters = {**parameters, **found}
                try:
                    return MotionCommand(create_motion(motion, parameters))
                except MotionError as error:
                    raise CommandRefused(str(error)) from error
        raise unknown_motion(name, self._capabilities.motions)

    def _session_command(self, value: Any) -> StartSessionCommand:
        """Return the start of a session; its robot is a name, or a file that a page may name."""
        if not isinstance(value, dict) or value.keys() != {"robot", "terrain", "seed"}:
            raise CommandRefused(
                f'start_session is {short_repr(value)}; it is {{"robot": name, "terrain": name, '
                '"seed": number}'
            )
        robot, choices = value["robot"], self._capabilities.sessions
        if choices is not None and robot not in choices.robots:
            present = choices.present.robot
            same = isinstance(robot, str) and Path(present).name == robot
            robot = present if same else str(self._uploads.find(robot, ROBOT_SUFFIXES))
        return StartSessionCommand(robot, value["terrain"], value["seed"])


def _push_command(value: Any) -> PushCommand:
    """Return a push of the trunk along the heading, or of a link in world axes."""
    if isinstance(value, dict) and value.keys() == {"link", "impulse"}:
        impulse = value["impulse"]
        if isinstance(impulse, list) and len(impulse) == 3:
            return PushCommand(tuple(impulse), frame="world", link=value["link"])  # type: ignore[arg-type]
    elif isinstance(value, list) and len(value) == 2:
        return PushCommand((value[0], value[1], 0.0))
    raise CommandRefused(
        f'push is {short_repr(value)}; it is [forward, left] or {{"link": name, "impulse": '
        "[x, y, z]} in N·s"
    )


def _frame_task_command(value: Any) -> FrameTaskCommand:
    """Return a task that holds a link."""
    if isinstance(value, dict) and value.keys() == {"frame", "kind", "weight"}:
        return FrameTaskCommand(value["frame"], value["kind"], value["weight"])
    raise CommandRefused(
        f'frame_task is {short_repr(value)}; it is {{"frame": link, "kind": "position" or '
        '"orientation", "weight": number, 0 to remove it}'
    )


def _hand_command(value: Any) -> HandTargetCommand:
    """Return a target of a hand, or its release."""
    if isinstance(value, dict) and value.keys() == {"side", "target"}:
        side, target = value["side"], value["target"]
        if isinstance(side, str) and target is None:
            return HandTargetCommand(side)
        if isinstance(side, str) and isinstance(target, list) and len(target) == 3:
            return HandTargetCommand(side, tuple(target))  # type: ignore[arg-type]
    raise CommandRefused(
        f'hand is {short_repr(value)}; it is {{"side": "left" or "right", "target": [x, y, z] in '
        "the world in m, or null to let go}"
    )


def _pull_command(value: Any) -> PullCommand:
    """Return a pull of a link, or the release for null."""
    if value is None:
        return PullCommand()
    if isinstance(value, dict) and value.keys() == {"link", "point", "target"} and value["link"]:
        places = value["point"], value["target"]
        if all(isinstance(place, list) and len(place) == 3 for place in places):
            return PullCommand(value["link"], tuple(places[0]), tuple(places[1]))  # type: ignore[arg-type]
    raise CommandRefused(
        f'pull is {short_repr(value)}; it is null or {{"link": name, "point": [x, y, z] in its '
        'axes, "target": [x, y, z] in the world} in m'
    )


def decode(message: str | bytes) -> Request:
    """Return the request that a message contains.

    Raises:
        CommandRefused: The message has another form; the text states the reason.
    """
    if not isinstance(message, str):
        raise CommandRefused("a message must be text in JSON")
    if len(message) > MAX_LENGTH:
        raise CommandRefused(
            f"the message has {len(message)} characters; at most {MAX_LENGTH} are allowed"
        )
    try:
        content = json.loads(message)
    except (ValueError, RecursionError):
        raise CommandRefused(f"{short_repr(message)} is not JSON") from None
    if not isinstance(content, dict) or not isinstance(content.get("control"), str):
        raise CommandRefused(
            f'{short_repr(content)}: a message must be {{"control": NAME, "value": …}}'
        )
    source = content.get("source", _SOURCES[0])
    if source not in _SOURCES:
        raise CommandRefused(f"source is {short_repr(source)}; it must be {' or '.join(_SOURCES)}")
    return Request(content["control"], content.get("value"), source)
