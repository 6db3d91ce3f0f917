"""Simulation: a robot in MuJoCo, with motors, sensors, ground and pushes.

Importing this room does not import MuJoCo; making a plant does.
"""

from wbc.robot.collision_pairs import ExcludedPair
from wbc.robot.collision_shapes import CollisionShape
from wbc.sim.cart import Cart
from wbc.sim.noise import SensorNoise
from wbc.sim.plant import Mujoco
from wbc.sim.ramp import Ramp
from wbc.sim.servos import JointServos
from wbc.sim.slippery_patch import SlipperyPatch
from wbc.sim.staircase import Staircase
from wbc.sim.terrain import Flat, Terrain, Tiles
from wbc.sim.wall import Wall

__all__ = [
    "Cart",
    "CollisionShape",
    "ExcludedPair",
    "Flat",
    "JointServos",
    "Mujoco",
    "Ramp",
    "SensorNoise",
    "SlipperyPatch",
    "Staircase",
    "Terrain",
    "Tiles",
    "Wall",
]
