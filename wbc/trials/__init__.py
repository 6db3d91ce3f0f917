"""Seeded closed-loop trials in physics."""

from wbc.trials.judge import Judge
from wbc.trials.motion_trial import Stage, run_motions
from wbc.trials.scenario import Scenario, circle, forward, sideways, stop_and_stand, turn
from wbc.trials.trial import run_scenario

__all__ = [
    "Judge",
    "Scenario",
    "Stage",
    "circle",
    "forward",
    "run_motions",
    "run_scenario",
    "sideways",
    "stop_and_stand",
    "turn",
]
