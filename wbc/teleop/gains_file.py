"""Files of gains and gait parameters, as the live page saves them."""

from __future__ import annotations

import sys
from pathlib import Path

from wbc.errors import did_you_mean
from wbc.teleop.acknowledgement import CommandRefused
from wbc.teleop.parameters import VELOCITY, set_parameter, tunable_parameters
from wbc.walking import Walker

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


def apply_gains(walker: Walker, path: Path) -> None:
    """Set the gains and gait parameters of a walker to those of a file.

    The file is TOML with one line per parameter, e.g. `"com.weight" = 2500.0`.

    Args:
        walker: the walker.
        path: path of the file.

    Raises:
        CommandRefused: the file cannot be read, or a name or value in it is invalid.
    """
    try:
        values = tomllib.loads(path.read_text("utf-8"))
    except OSError as error:
        raise CommandRefused(f"cannot read {path}: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise CommandRefused(f"{path} is not a file of gains: {error}") from error
    known = {p.name: p for p in tunable_parameters(walker, False) if p.group != VELOCITY}
    for name, value in values.items():
        if name not in known:
            raise CommandRefused(f"{path}: no parameter '{name}'{did_you_mean(name, known)}")
        parameter = known[name]
        try:
            parameter.check(value)
        except CommandRefused as error:
            raise CommandRefused(f"{path}: {error}") from None
    for name, value in values.items():
        set_parameter(walker, name, float(value))
