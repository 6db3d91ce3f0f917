"""Options that all verbs of `wbc ros2` have."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from wbc.ros import Network


def add_verb(verbs: Any, name: str, text: str, execute: Any) -> argparse.ArgumentParser:
    """Add a verb with the options that select the network."""
    parser: argparse.ArgumentParser = verbs.add_parser(
        name, help=text, description=f"{text[0].upper()}{text[1:]}."
    )
    parser.add_argument(
        "--domain", type=_domain, metavar="ID", help="DDS domain (default: ROS_DOMAIN_ID, or 0)"
    )
    parser.add_argument(
        "--interface",
        metavar="NAME",
        help="network interface, by name or address (default: loopback)",
    )
    parser.set_defaults(execute=execute)
    return parser


def network(options: argparse.Namespace) -> Network:
    """Return the network that options and environment select."""
    from wbc.ros import Network

    return Network.from_environment(options.domain, options.interface)


def count(text: str) -> int:
    """Parse a positive integer."""
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number, 1 or greater")
    return int(text)


def _domain(text: str) -> int:
    if not text.isdecimal() or int(text) > 232:
        raise argparse.ArgumentTypeError(f"'{text}' is not a domain id; use 0 to 232")
    return int(text)
