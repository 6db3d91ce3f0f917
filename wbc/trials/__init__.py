"""Trials: seeded closed-loop runs in simulation, with criteria for success."""

from wbc.trials.evaluator import RunEvaluator
from wbc.trials.motion_trial import MotionRunner, run_motions
from wbc.trials.scenario import Scenario, circle, forward, sideways, stop_and_stand, turn
from wbc.trials.walking_trial import run_scenario

__all__ = [
    "MotionRunner",
    "RunEvaluator",
    "Scenario",
    "circle",
    "forward",
    "run_motions",
    "run_scenario",
    "sideways",
    "stop_and_stand",
    "turn",
]
