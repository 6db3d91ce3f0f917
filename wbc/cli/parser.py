"""Commands are functions, whose parameters are arguments of the command line: argparse from these.

A parameter without a default is a positional argument, any other an option. Its help is its
description in the docstring; its type and default tell how it is parsed: a bool is a flag that
inverts the default, an empty tuple an option that may be repeated. Parameters that several
commands share are the fields of a dataclass, which is the type of one parameter of each command.
"""

from __future__ import annotations

import argparse
import dataclasses
import importlib
import inspect
import math
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import (
    Annotated,
    Any,
    Literal,
    NamedTuple,
    NoReturn,
    get_args,
    get_origin,
    get_type_hints,
)

from wbc.cli.argument_types import Argument, number, whole_number
from wbc.cli.exit_code import ExitCode

#: A function or a dataclass.
Function = Callable[..., Any]


#: Metavar, unless it is the name of the parameter, and parser of plain types.
_PARSERS: dict[Any, tuple[str, Callable[[str], Any]]] = {
    int: ("N", whole_number),
    float: ("X", number),
    Path: ("", Path),
}


class _HelpFormatter(argparse.RawDescriptionHelpFormatter):
    """Wraps the paragraphs of a text, except those with indented lines."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        width -= len(indent)
        paragraphs = text.strip("\n").split("\n\n")
        wrapped = [p if "\n  " in p else textwrap.fill(p, width) for p in paragraphs]
        return textwrap.indent("\n\n".join(wrapped), indent)


class DeferredCommand(NamedTuple):
    """A command whose module takes long to import: only its own use and help import it.

    Attributes:
        module: name of the module.
        function: name of the function in it.
        summary: what the command does, for the list of verbs.
    """

    module: str
    function: str
    summary: str

    def load(self) -> Function:
        """Import the module, and return the function."""
        function: Function = getattr(importlib.import_module(self.module), self.function)
        return function


class Parser(argparse.ArgumentParser):
    """An argument parser that reports errors in one line.

    Args:
        deferred: command to run, whose arguments are added when the parser is used.
        settings: see `argparse.ArgumentParser`.
    """

    def __init__(self, *, deferred: DeferredCommand | None = None, **settings: Any) -> None:
        super().__init__(**{"formatter_class": _HelpFormatter, "allow_abbrev": False, **settings})
        self._deferred = deferred

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse arguments; see `argparse.ArgumentParser.parse_known_args`."""
        if self._deferred is not None:
            set_command(self, self._deferred.load())
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        """Exit with the message; see `argparse.ArgumentParser.error`."""
        self.exit(ExitCode.BAD_INPUT, f"{self.prog}: {message} (see {self.prog} --help)\n")


#: What a verb names: a function, one in a module not yet imported, or verbs of its own.
Command = Function | DeferredCommand | Mapping[str, Function]


def set_command(parser: Parser, command: Function, **types: type) -> None:
    """Have a parser run a function with the arguments that were parsed.

    Args:
        parser: the parser.
        command: returns the exit code; None is success.
        types: types of parameters, in place of those that the function states.
    """
    parser.description = _summary(command)
    _add_arguments(parser, parser, command, types)
    parser.set_defaults(execute=lambda namespace: _call(command, namespace, types))


def set_commands(parser: Parser, commands: Mapping[str, Command]) -> None:
    """Have a parser run the function that a verb names; a verb may have verbs of its own."""
    verbs = parser.add_subparsers(title="verbs", metavar="VERB", required=True)
    for name, command in commands.items():
        if isinstance(command, Mapping):
            own = verbs.add_parser(name, help=", ".join(command))
            set_commands(own, command)
        elif isinstance(command, DeferredCommand):
            verbs.add_parser(name, help=command.summary, deferred=command)
        else:
            summary = " ".join((command.__doc__ or "").partition(".\n")[0].split())
            set_command(verbs.add_parser(name, help=summary[:1].lower() + summary[1:]), command)


class _Parameter(NamedTuple):
    """A parameter of a function, or a field of a dataclass."""

    name: str
    type: Any
    default: Any
    description: str
    destination: str  # in the namespace


def _parameters(function: Function, types: Mapping[str, type]) -> Iterator[_Parameter]:
    hints = {**get_type_hints(function, include_extras=True), **types}
    fields = getattr(function, "__dataclass_fields__", {})
    descriptions = _descriptions(function)
    for name, parameter in inspect.signature(function).parameters.items():
        kind, metadata = hints[name], fields[name].metadata if name in fields else {}
        if metadata.get("choices"):  # parameters of motions
            kind = Literal[metadata["choices"]]
        elif metadata.get("names"):
            kind = Annotated[kind, Argument(metadata["names"], number)]
        description = metadata.get("description") or descriptions.get(name, "")
        destination = f"{function.__name__}.{name}"
        yield _Parameter(name, kind, parameter.default, description, destination)


def _is_group(parameter: _Parameter) -> bool:
    """Return whether a dataclass holds further parameters."""
    return isinstance(parameter.type, type) and dataclasses.is_dataclass(parameter.type)


def _add_arguments(
    parser: Parser, section: Any, function: Function, types: Mapping[str, type]
) -> None:
    """Add the parameters of a function or dataclass to a section of the help of a parser."""
    for parameter in sorted(_parameters(function, types), key=_is_group):
        kind = parameter.type
        if _is_group(parameter):
            title = getattr(kind, "title", "")
            nested = parser.add_argument_group(title, _summary(kind)) if title else section
            _add_arguments(parser, nested, kind, {})
        elif parameter.default is inspect.Parameter.empty:
            section.add_argument(parameter.destination, **_settings(parameter))
        else:
            settings = _settings(parameter)
            section.add_argument(settings.pop("flag"), dest=parameter.destination, **settings)


def _call(function: Function, namespace: argparse.Namespace, types: Mapping[str, type]) -> Any:
    """Call a function with the values that were parsed for its parameters."""
    values = {}
    for parameter in _parameters(function, types):
        name = parameter.name
        if _is_group(parameter):
            values[name] = _call(parameter.type, namespace, {})
        elif (value := getattr(namespace, parameter.destination)) is not None:
            values[name] = tuple(value) if isinstance(value, list) else value
    return function(**values)


def _settings(parameter: _Parameter) -> dict[str, Any]:
    """Return the arguments of `add_argument`; the default stays with the function."""
    name, kind, default, text, _ = parameter
    parts = (kind, *get_args(kind))
    argument = next((p.__metadata__[0] for p in parts if hasattr(p, "__metadata__")), None)
    if argument is None:
        known = (_PARSERS[part] for part in parts if part in _PARSERS)  # also of `Path | None`
        metavar, parse = next(known, (name.upper(), str))
        argument = Argument(metavar or name.upper(), parse)
    settings: dict[str, Any] = {"metavar": argument.metavar, "type": argument.parse}
    if default is inspect.Parameter.empty:
        if get_origin(kind) is tuple or get_origin(parts[1:] and parts[1]) is tuple:
            settings["nargs"] = "*"
        return {**settings, "help": text.replace("%", "%%")}
    prefix = "--no-" if default is True else "--"
    settings["flag"] = argument.flag or prefix + name.replace("_", "-")
    if isinstance(default, bool):
        del settings["metavar"], settings["type"]
        settings.update(action="store_const", const=not default)
    elif get_origin(kind) is Literal:
        del settings["metavar"]
        settings["choices"] = get_args(kind)
    elif argument.nargs:
        settings["nargs"] = argument.nargs
    elif default == ():
        settings["action"] = "append"
        text += "; repeatable"
    elif isinstance(argument.metavar, tuple):
        settings["nargs"] = len(argument.metavar)
    if type(default) in (int, float, str) and default not in ("", math.inf, -math.inf):
        text += f" (default: {f'{default:g}' if isinstance(default, float) else default})"
    return {**settings, "help": text.replace("%", "%%")}


def _summary(function: Function) -> str:
    """Return the docstring of a function without its sections."""
    return re.split(r"\n+(?:Args|Attributes|Raises):\n", inspect.getdoc(function) or "")[0]


def _descriptions(function: Function) -> dict[str, str]:
    """Return the descriptions of parameters in the docstring of a function."""
    entries = re.findall(r"^    (\w+): (.*(?:\n     .*)*)", inspect.getdoc(function) or "", re.M)
    return {name: " ".join(text.split()).rstrip(".") for name, text in entries}
