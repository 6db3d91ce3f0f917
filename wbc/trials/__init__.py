"""Seeded closed-loop trials in physics."""

from wbc.trials.scenario import Scenario, circle, forward, sideways, stop_and_stand, turn
from wbc.trials.trial import run_scenario

__all__ = [
    "Scenario",
    "circle",
    "forward",
    "run_scenario",
    "sideways",
    "stop_and_stand",
    "turn",
]
