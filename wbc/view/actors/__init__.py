"""Actors: each owns some nodes of the scene and updates their poses."""

from wbc.view.actors.actor import Actor, Proportions, SceneInput, SceneNode
from wbc.view.actors.balance import BalanceActor
from wbc.view.actors.floor import FloorActor
from wbc.view.actors.footsteps import FootstepsActor
from wbc.view.actors.forces import ForcesActor
from wbc.view.actors.robot import RobotActor
from wbc.view.actors.status_light import StatusLightActor
from wbc.view.actors.support import SupportActor
from wbc.view.actors.swing import SwingActor
from wbc.view.actors.trail import TrailActor

__all__ = [
    "Actor",
    "BalanceActor",
    "FloorActor",
    "FootstepsActor",
    "ForcesActor",
    "Proportions",
    "RobotActor",
    "SceneInput",
    "SceneNode",
    "StatusLightActor",
    "SupportActor",
    "SwingActor",
    "TrailActor",
]
