"""Contact forces as arrows that start at the centre of pressure."""

from __future__ import annotations

import numpy as np

from wbc.geometry.wrench import centre_of_pressure
from wbc.runtime.record import CONTACTS
from wbc.view.actors.actor import Actor, Proportions, SceneInput, SceneNode, hide, stretch
from wbc.view.colours import FORCE
from wbc.view.objects import cylinder, mesh, see_through

_RADIUS = 0.012  # m, on a robot of human size
_HEAD = 0.09  # m
#: Length of the arrow for the robot's weight, as a multiple of the CoM height.
_LENGTH = 0.6
#: Smallest force that is drawn, as a share of the weight; above the noise of an unloaded foot.
_LEAST = 0.02


class ForcesActor(Actor):
    """One arrow per loaded contact, with a length proportional to the force."""

    def __init__(self, proportions: Proportions) -> None:
        self._weight = proportions.weight
        self._scale = _LENGTH * proportions.com_height / proportions.weight
        self._head = _HEAD * proportions.unit
        radius = _RADIUS * proportions.unit
        # The arrows lie inside the leg, so they are drawn over the robot.
        material = see_through(FORCE)
        self.nodes = []
        for i in range(CONTACTS):
            shaft = mesh(cylinder(radius, 1.0), material, order=10)
            head = mesh(cylinder(2.6 * radius, 1.0, top=0.0), material, order=10)
            self.nodes += [
                SceneNode(f"forces/{i}/shaft", (shaft,)),
                SceneNode(f"forces/{i}/head", (head,)),
            ]

    def place(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        hide(poses)
        for i, (placement, wrench) in enumerate(scene_input.contacts.values()):
            force = placement.rotation @ wrench[:3]
            size = float(np.sqrt(force @ force))
            if not size > _LEAST * self._weight:
                continue
            start = placement.act(centre_of_pressure(wrench))
            way = force / size
            length = size * self._scale
            neck = start + max(length - self._head, 0.0) * way
            stretch(poses[2 * i], start, neck)
            stretch(poses[2 * i + 1], neck, start + length * way)
