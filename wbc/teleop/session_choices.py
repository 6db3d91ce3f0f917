"""What another session may be started with, in place of the present one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from wbc.errors import did_you_mean, short_repr
from wbc.teleop.acknowledgement import CommandRefused
from wbc.teleop.commands import StartSessionCommand

_LARGEST_SEED = 2**31 - 1


@dataclass(frozen=True, slots=True)
class SessionChoices:
    """The robots and terrains of a session, and those of the present one.

    Attributes:
        robots: names of robots; a path of a URDF or robot data file is possible as well.
        terrains: names of terrains.
        present: what the present session was started with.
    """

    robots: tuple[str, ...]
    terrains: tuple[str, ...]
    present: StartSessionCommand

    def check(self, command: StartSessionCommand) -> None:
        """Refuse a session that cannot be started.

        Raises:
            CommandRefused: the robot or terrain is unknown, or the seed is no whole number.
        """
        robot, terrain, seed = command.robot, command.terrain, command.seed
        if robot not in self.robots and not Path(robot).is_file():
            near = did_you_mean(robot, self.robots)
            raise CommandRefused(f"no robot and no file {short_repr(robot)}{near}")
        if terrain not in self.terrains:
            near = did_you_mean(terrain, self.terrains)
            raise CommandRefused(f"no terrain {short_repr(terrain)}{near}")
        if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed <= _LARGEST_SEED:
            raise CommandRefused(
                f"seed = {short_repr(seed)}; it is a whole number from 0 to {_LARGEST_SEED}"
            )
