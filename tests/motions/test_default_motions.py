"""Every motion with its default parameters, as a button of the live page starts it, in physics."""

from __future__ import annotations

import pytest
from cases import slow
from coretools import robot

from wbc.motions import MOTIONS, Demo, Motion, MotionPlayer
from wbc.trials import run_motions

#: Without a file of keyframes there is nothing to play, and the demo plays the others.
BUTTONS = tuple(motion for motion in MOTIONS if motion.name != "keyframes" and motion is not Demo)
ROBOTS = ("talos", "g1", "simple_humanoid")
#: Each motion on two of the robots, in turn.
CASES = [
    (name, kind)
    for i, kind in enumerate(BUTTONS)
    for k, name in enumerate(ROBOTS)
    if (i + k) % len(ROBOTS)
]


@pytest.mark.parametrize(
    ("name", "kind"),
    [slow(name, kind) for name, kind in CASES],
    ids=lambda x: x if isinstance(x, str) else x.name,
)
def test_the_default_button_of_a_motion_leaves_the_robot_standing(name, kind: type[Motion]):
    players: list[MotionPlayer] = []
    report = run_motions(
        robot(name),
        [kind()],
        seed=5,
        time_limit=60.0,
        before_tick=lambda time, player, plant: players.append(player),
    )
    assert report.survived, report.table()
    player = players[-1]
    assert player.idle
    assert player.context.at_home
    assert player.context.standing
