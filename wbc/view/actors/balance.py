"""Centre of mass, divergent component of motion (DCM), DCM reference, and ZMP."""

from __future__ import annotations

import numpy as np
from trimesh.creation import annulus, cylinder

from wbc.view.actors.actor import Actor, Proportions, SceneInput, SceneNode, set_position
from wbc.view.colours import COM, DCM, ZMP
from wbc.view.objects import drawable, see_through, sphere

#: Height of the symbols above the ground, m, which avoids intersections with uneven ground and
#: flicker against the support polygon.
_LIFT = 0.006
_THICKNESS = 0.004  # m


class BalanceActor(Actor):
    """A sphere at the centre of mass, and flat symbols on the ground for the other points."""

    def __init__(self, proportions: Proportions) -> None:
        u = proportions.unit
        symbols = {
            "com": drawable(sphere(0.035 * u), see_through(COM, lit=True), order=9),
            "com_on_ground": drawable(cylinder(0.012 * u, _THICKNESS), see_through(COM), order=6),
            "dcm": drawable(cylinder(0.022 * u, _THICKNESS), see_through(DCM), order=6),
            "dcm_reference": drawable(annulus(0.026 * u, 0.034 * u, 1e-4), see_through(DCM), 5),
            "zmp": drawable(cylinder(0.016 * u, _THICKNESS), see_through(ZMP), order=7),
        }
        self.nodes = [
            SceneNode(f"balance/{name}", (symbol,), smooth=True) for name, symbol in symbols.items()
        ]

    def set_poses(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        telemetry, com = scene_input.snapshot.telemetry, scene_input.com
        lift = np.array([0.0, 0.0, _LIFT])
        ground = min((sole.translation[2] for sole in scene_input.soles.values()), default=0.0)
        points = (
            com,
            np.array([com[0], com[1], ground + _LIFT]),
            telemetry.dcm + lift,
            telemetry.dcm_reference + lift,
            telemetry.zmp + 1.5 * lift,
        )
        for pose, point in zip(poses, points, strict=True):
            set_position(pose, point)
