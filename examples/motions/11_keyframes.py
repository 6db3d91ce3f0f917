"""Keyframes: postures and hand positions from a file, checked first and tracked in balance."""

from pathlib import Path

import wbc
from wbc.errors import MotionError
from wbc.motions import Keyframes
from wbc.trials import run_motions

FOLDER = Path(__file__).parent / "keyframes"

robot = wbc.load("simple_humanoid")
report = run_motions(robot, [Keyframes(file=str(FOLDER / "robot_dance.csv"))])
print(report.table())

try:
    Keyframes(file=str(FOLDER / "robot_dance.csv")).check(wbc.load("g1"))
except MotionError as refusal:  # names file, line and column
    print(f"\n{refusal}")
