"""The tour: waypoints, punches and arms that somebody else moves, for 90 s.

The protocol is that of the public teleop-walking-benchmark (https://github.com/rhoyn/
teleop-walking-benchmark), which scored 34 published walking policies of Unitree's G1 by it; the
documentation lists what differs here.
"""

from wbc.trials.tour.arms import ArmMotion, TourController
from wbc.trials.tour.run import TourResult, run_tour, simulate_tour
from wbc.trials.tour.schedule import Punch, Tour, TourParameters, draw_direction, draw_tour
from wbc.trials.tour.table import PUBLISHED, PublishedResult, summary

__all__ = [
    "PUBLISHED",
    "ArmMotion",
    "PublishedResult",
    "Punch",
    "Tour",
    "TourController",
    "TourParameters",
    "TourResult",
    "draw_direction",
    "draw_tour",
    "run_tour",
    "simulate_tour",
    "summary",
]
