"""Centre of mass, divergent component of motion (DCM), DCM reference, and ZMP."""

from __future__ import annotations

import numpy as np

from wbc.view.actors.actor import Actor, Proportions, SceneInput, SceneNode, put
from wbc.view.colours import COM, DCM, ZMP
from wbc.view.objects import Y_TO_Z, cylinder, mesh, ring, see_through, sphere

#: Height of the symbols above the ground, m, which avoids intersections with uneven ground and
#: flicker against the support polygon.
_LIFT = 0.006


class BalanceActor(Actor):
    """A sphere at the centre of mass, and flat symbols on the ground for the other points."""

    def __init__(self, proportions: Proportions) -> None:
        u = proportions.unit
        ball = mesh(sphere(0.035 * u), see_through(COM, lit=True), order=9)
        shadow = mesh(cylinder(0.012 * u, 0.004), see_through(COM), Y_TO_Z, order=6)
        dcm = mesh(cylinder(0.022 * u, 0.004), see_through(DCM), Y_TO_Z, order=6)
        reference = mesh(ring(0.026 * u, 0.034 * u), see_through(DCM), order=5)
        zmp = mesh(cylinder(0.016 * u, 0.004), see_through(ZMP), Y_TO_Z, order=7)
        self.nodes = [
            SceneNode("balance/com", (ball,), smooth=True),
            SceneNode("balance/com_on_ground", (shadow,), smooth=True),
            SceneNode("balance/dcm", (dcm,), smooth=True),
            SceneNode("balance/dcm_reference", (reference,), smooth=True),
            SceneNode("balance/zmp", (zmp,), smooth=True),
        ]

    def place(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        telemetry = scene_input.snapshot.telemetry
        lift = np.array([0.0, 0.0, _LIFT])
        put(poses[0], scene_input.com)
        ground = min((sole.translation[2] for sole in scene_input.soles.values()), default=0.0)
        put(poses[1], np.array([scene_input.com[0], scene_input.com[1], ground + _LIFT]))
        put(poses[2], telemetry.dcm + lift)
        put(poses[3], telemetry.dcm_reference + lift)
        put(poses[4], telemetry.zmp + 1.5 * lift)
