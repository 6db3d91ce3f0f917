"""Options that every verb of `wbc ros2` has."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from wbc.ros import Network


def add_verb(verbs: Any, name: str, text: str, execute: Any) -> argparse.ArgumentParser:
    """Add a verb, with the options that say where it looks for others."""
    parser: argparse.ArgumentParser = verbs.add_parser(
        name, help=text, description=f"{text[0].upper()}{text[1:]}."
    )
    parser.add_argument(
        "--domain", type=_domain, metavar="ID", help="DDS domain (default: ROS_DOMAIN_ID, or 0)"
    )
    parser.add_argument(
        "--interface", metavar="NAME", help="network interface, by name or address (default: lo)"
    )
    parser.set_defaults(execute=execute)
    return parser


def network(options: argparse.Namespace) -> Network:
    """The network that options and environment ask for."""
    from wbc.ros import Network

    return Network.from_environment(options.domain, options.interface)


def count(text: str) -> int:
    """A whole number from 1 on."""
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number from 1 on")
    return int(text)


def _domain(text: str) -> int:
    if not text.isdecimal() or int(text) > 232:
        raise argparse.ArgumentTypeError(f"'{text}' is not a domain: they go from 0 to 232")
    return int(text)
