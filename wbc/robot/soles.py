"""Finding a robot's two soles and adding them to its model."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import pinocchio as pin

from wbc.errors import RobotDescriptionError, did_you_mean
from wbc.robot.data_file import SOLE_KEYS, RobotData
from wbc.robot.finding import Fact
from wbc.robot.foot_surface import foot_surface
from wbc.robot.sole_fitting import SoleFit, fit_sole
from wbc.robot.topology import parent_joint
from wbc.robot.urdf import Urdf

Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")


@dataclass(frozen=True, slots=True, repr=False)
class Sole:
    """A contact rectangle on a foot.

    Its frame has the origin at the rectangle's centre, z up (the normal, away
    from the ground) and x forward when the robot stands.

    Attributes:
        name: `left_sole` or `right_sole`, also the name of the model's frame.
        side: `left` or `right`.
        frame_id: of the frame in the model.
        joint_id: of the joint that moves the foot.
        placement: T_joint_sole, from sole to joint coordinates.
        half_length: along x, m.
        half_width: along y, m.
        link: name of the foot link.
    """

    name: str
    side: Side
    frame_id: int
    joint_id: int
    placement: pin.SE3
    half_length: float
    half_width: float
    link: str

    def __repr__(self) -> str:
        return f"Sole('{self.name}', {self.size_text}, on '{self.link}')"

    @property
    def size_text(self) -> str:
        """Length and width for people, e.g. `200 × 120 mm`."""
        return f"{2e3 * self.half_length:.0f} × {2e3 * self.half_width:.0f} mm"

    @property
    def corners(self) -> np.ndarray:
        """(4, 3) corners in the sole frame, counter-clockwise seen from above, m."""
        x, y = self.half_length, self.half_width
        return np.array([[x, y, 0.0], [-x, y, 0.0], [-x, -y, 0.0], [x, -y, 0.0]])


def add_soles(
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
        joint = parent_joint(model, link)
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
    left, right = (kinematics.oMi[parent_joint(model, link)].translation for link in links)
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
