"""A cart that the robot can push: an object with a mass and friction of its own."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from wbc.errors import PlantError

_THICKNESS = 0.02  # m, of the panel that is pushed
_CLEARANCE = 0.3  # m under the panel: room for the feet

_UNITS = {
    "distance": " (m)",
    "mass": " (kg)",
    "rolling_resistance": " (N)",
    "damping": " (N·s/m)",
    "height": " (m)",
    "width": " (m)",
    "friction": "",
}


@dataclass(frozen=True, slots=True)
class Cart:
    """A cart on a rail, with an upright panel in front of the robot; it moves straight ahead.

    Attributes:
        distance: from the middle of the soles at the start to the panel, m.
        mass: kg.
        rolling_resistance: force that has to be overcome before it moves, N.
        damping: force per speed, N·s/m.
        height: of the panel's top above the floor, m.
        width: m.
        friction: Coulomb coefficient between hands and panel.

    Raises:
        PlantError: an attribute that is not positive and finite.
    """

    distance: float = 0.3
    mass: float = 15.0
    rolling_resistance: float = 15.0
    damping: float = 20.0
    height: float = 1.4
    width: float = 1.0
    friction: float = 0.8

    def __post_init__(self) -> None:
        for name, unit in _UNITS.items():
            value = getattr(self, name)
            if not 0.0 < value < math.inf:
                raise PlantError(f"Cart: {name} is {value}, it must be positive and finite{unit}")

    def boxes(self, moved: float = 0.0) -> np.ndarray:
        """Return the panel of a cart that has moved by some metres, as `Terrain.boxes` does."""
        z, half_height = 0.5 * (self.height + _CLEARANCE), 0.5 * (self.height - _CLEARANCE)
        x = self.distance + 0.5 * _THICKNESS + moved
        return np.array([[x, 0.0, z, 0.5 * _THICKNESS, 0.5 * self.width, half_height]])

    def add_to(self, mujoco: Any, spec: Any, surface: dict[str, Any]) -> None:
        """Add the cart to a `mujoco.MjSpec`; `surface` holds geom attributes.

        Its joint is called "cart". The body "cart_base" is to be placed where the robot starts.
        """
        base = spec.worldbody.add_body(name="cart_base", mocap=True)
        box = self.boxes()[0]
        body = base.add_body(name="cart", pos=[box[0], 0.0, 0.0])
        joint = body.add_joint(name="cart", type=mujoco.mjtJoint.mjJNT_SLIDE)
        joint.axis = [1.0, 0.0, 0.0]
        joint.damping[0] = self.damping
        joint.frictionloss = self.rolling_resistance
        body.add_geom(
            name="cart",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=[0.0, 0.0, box[2]],
            size=box[3:],
            mass=self.mass,
            **surface | {"friction": [self.friction, 0.0, 0.0], "priority": 1},
        )
