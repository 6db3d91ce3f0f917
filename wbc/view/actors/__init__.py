"""What is drawn: each actor owns some nodes of the scene and places them."""

from wbc.view.actors.actor import Actor, Moment, Node, Proportions
from wbc.view.actors.balance import Balance
from wbc.view.actors.body import Body
from wbc.view.actors.footsteps import Footsteps
from wbc.view.actors.forces import Forces
from wbc.view.actors.lamp import Lamp
from wbc.view.actors.stage import Stage
from wbc.view.actors.support import Support
from wbc.view.actors.swing import Swing
from wbc.view.actors.trail import Trail

__all__ = [
    "Actor",
    "Balance",
    "Body",
    "Footsteps",
    "Forces",
    "Lamp",
    "Moment",
    "Node",
    "Proportions",
    "Stage",
    "Support",
    "Swing",
    "Trail",
]
