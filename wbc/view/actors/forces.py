"""Contact forces as arrows that start at the centre of pressure."""

from __future__ import annotations

import numpy as np
from trimesh.creation import cone, cylinder

from wbc.geometry.wrench import centre_of_pressure
from wbc.runtime.record import CONTACTS
from wbc.view.actors.actor import Actor, Proportions, SceneInput, copies, hide, stretch
from wbc.view.colours import FORCE
from wbc.view.objects import drawable, see_through

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
        shaft = drawable(cylinder(radius, 1.0), material, order=10)
        tip = cone(2.6 * radius, 1.0).apply_translation((0.0, 0.0, -0.5))
        head = drawable(tip, material, order=10)
        self.nodes = copies("forces/shaft_", CONTACTS, shaft) + copies(
            "forces/head_", CONTACTS, head
        )

    def set_poses(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        hide(poses)
        for i, (placement, wrench) in enumerate(scene_input.contacts.values()):
            force = placement.rotation @ wrench[:3]
            magnitude = float(np.sqrt(force @ force))
            if not magnitude > _LEAST * self._weight:
                continue
            start = placement.act(centre_of_pressure(wrench))
            direction = force / magnitude
            length = magnitude * self._scale
            neck = start + max(length - self._head, 0.0) * direction
            stretch(poses[i], start, neck)
            stretch(poses[CONTACTS + i], neck, start + length * direction)
