"""Finding a robot's two soles and adding them to its model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin

from wbc.errors import RobotDescriptionError, did_you_mean
from wbc.robot.data import SOLE_KEYS, RobotData
from wbc.robot.finding import Fact
from wbc.robot.foot import foot_surface
from wbc.robot.sole import Side, Sole, SoleFit, fit_sole
from wbc.robot.trunk import moving_joint
from wbc.robot.urdf import Urdf

SIDES: tuple[Side, Side] = ("left", "right")


def make_soles(
    model: pin.Model,
    urdf: Urdf,
    data: RobotData,
    folders: tuple[Path, ...],
    q: np.ndarray,
    links: tuple[str, str],
) -> tuple[tuple[Sole, Sole], list[Fact]]:
    """Fit both soles at an upright posture `q` (nq,), and add their frames.

    Raises:
        RobotDescriptionError: a foot has no geometry and none is stated.
    """
    kinematics = model.createData()
    pin.framesForwardKinematics(model, kinematics, q)
    forward = _forward(model, kinematics, links)
    soles, facts = [], []
    for side, link in zip(SIDES, links, strict=True):
        joint = moving_joint(model, link)
        to_joint = kinematics.oMi[joint].rotation.T
        frame = model.frames[model.getFrameId(link, pin.BODY)]
        up = to_joint @ np.array([0.0, 0.0, 1.0])
        if data.sole:
            fit = _stated(data, frame.placement)
            facts.append(Fact(f"{side} sole", _size(fit), "stated", data.source))
        else:
            surface = foot_surface(urdf, model, joint, folders, data.respect_up_axis)
            if not len(surface.points):
                raise RobotDescriptionError(_no_surface(urdf, link, surface.missing))
            axes = np.hstack([frame.placement.rotation, np.eye(3)])
            fit = fit_sole(surface, up, to_joint @ forward, axes)
            source = f"{surface.kind} shapes, normal from the {fit.how}"
            facts.append(Fact(f"{side} sole", _size(fit), "derived", source))
        name = f"{side}_sole"
        if model.existFrame(name):
            raise RobotDescriptionError(
                f"{urdf.path}: it already has a frame '{name}', a name that this library gives "
                "to the sole that it finds; rename that link or joint"
            )
        parent = model.getFrameId(link, pin.BODY)
        frame_id = model.addFrame(pin.Frame(name, joint, parent, fit.placement, pin.OP_FRAME))
        soles.append(
            Sole(
                name, side, int(frame_id), joint, fit.placement,
                float(fit.half_length), float(fit.half_width), link,
            )
        )  # fmt: skip
    return (soles[0], soles[1]), facts


def _forward(model: pin.Model, kinematics: pin.Data, links: tuple[str, str]) -> np.ndarray:
    """(3,) level unit vector that has the left foot on its left."""
    left, right = (kinematics.oMi[moving_joint(model, link)].translation for link in links)
    across = left - right
    forward = np.cross([across[0], across[1], 0.0], [0.0, 0.0, 1.0])
    length = float(np.linalg.norm(forward))
    # Feet behind or upon each other tell nothing; the base's own x axis then decides.
    return forward / length if length > 0.02 else np.array([1.0, 0.0, 0.0])


def _stated(data: RobotData, placement: pin.SE3) -> SoleFit:
    """The rectangle that a data file states, in the foot link's axes."""
    for key in data.sole:
        if key not in SOLE_KEYS:
            raise RobotDescriptionError(
                f"{data.source}: the sole has no '{key}'{did_you_mean(key, SOLE_KEYS)}"
            )
    try:
        x, y = data.sole.get("center", (0.0, 0.0))
        height, length, width = (float(data.sole[k]) for k in ("height", "length", "width"))
        center = np.array([float(x), float(y), height])
    except (KeyError, TypeError, ValueError) as error:
        raise RobotDescriptionError(
            f"{data.source}: the sole needs height, length and width as numbers in m, "
            f"and center as two ({error})"
        ) from error
    if not (np.isfinite(center).all() and 0.0 <= length < np.inf and 0.0 <= width < np.inf):
        raise RobotDescriptionError(
            f"{data.source}: the sole is {length} × {width} m; sizes are finite and positive"
        )
    sole = placement * pin.SE3(np.eye(3), center)
    return SoleFit(sole, 0.5 * length, 0.5 * width, data.source)


def _size(fit: SoleFit) -> str:
    return f"{2e3 * fit.half_length:.0f} × {2e3 * fit.half_width:.0f} mm"


def _no_surface(urdf: Urdf, link: str, missing: tuple[str, ...]) -> str:
    why = f"its mesh {missing[0]} is missing" if missing else "it has no collision or visual shape"
    return (
        f"{urdf.path}: the foot '{link}' has no surface to stand on ({why}); add a <collision>, "
        "give package_dirs=…, or state [sole] height, length and width in a data file"
    )
