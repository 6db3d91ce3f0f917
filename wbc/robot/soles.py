"""`Sole`, the contact rectangle of a foot, and how the soles are added to a model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
import pinocchio as pin

from wbc.errors import RobotDescriptionError
from wbc.robot.data_file import RobotData
from wbc.robot.finding import Fact, Origin
from wbc.robot.foot_surface import FootSurface, foot_surface
from wbc.robot.joint_axes import joint_axes
from wbc.robot.sole_fitting import SoleFit, fit_point, fit_sole, is_round, resting_normal
from wbc.robot.topology import parent_joint
from wbc.robot.urdf import Urdf

Side = Literal["left", "right", "front_left", "front_right", "hind_left", "hind_right"]
SIDES: tuple[Side, ...] = ("left", "right")
#: A sole that is as many times wider than long is turned, or its meshes are.
WIDE = 1.2
QUADRUPED_SIDES: tuple[Side, ...] = ("front_left", "front_right", "hind_left", "hind_right")


@dataclass(frozen=True, slots=True, repr=False)
class Sole:
    """A contact rectangle on a foot.

    Its frame has the origin at the rectangle's centre, z up (the normal, away
    from the ground) and x forward when the robot stands.

    Attributes:
        name: name of the frame in the model: the side and `_sole`, e.g. `left_sole`, with
            `_contact` appended if the URDF has a link or joint of that name.
        side: `left` or `right`; of four feet `front_left`, `front_right`, `hind_left` or
            `hind_right`.
        frame_id: index of the frame in the model.
        joint_id: index of the joint that moves the foot.
        placement: T_joint_sole, from sole to joint coordinates.
        half_length: half the size along x, m.
        half_width: half the size along y, m.
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
        """Length and width as text, e.g. `200 × 120 mm`."""
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
    links: tuple[str, ...],
    zero: np.ndarray,
    start: np.ndarray,
) -> tuple[tuple[Sole, ...], bool, list[Fact]]:
    """Fit the soles to the shapes of the feet, and add their frames to the model.

    A flat sole depends on the shape of the foot only: the upright zero position tells which side
    is down and where forward is. A round foot, and that of a quadruped, touches the ground where
    its posture puts it. All feet are measured by their collision shapes, or all by their visual
    ones: one that lacks the former need not be unlike the others. Unless it is stated, Collada
    meshes mean their `<up_axis>`, which ROS ignores, where otherwise the soles of both feet would
    be wider than long.

    Args:
        model: the robot; gets the frames.
        urdf: the description.
        data: statements of the data file and the caller.
        folders: folders that may hold its packages.
        links: the left and the right foot, or those of a quadruped, see `QUADRUPED_SIDES`.
        zero: (nq,) the zero position with the base upright.
        start: (nq,) the stated posture, before its legs are completed.

    Returns:
        The soles in the order of the links, whether meshes mean their up axis, and facts.

    Raises:
        RobotDescriptionError: a foot has no geometry and none is stated, or is a wheel.
    """
    sides = sides_of(links)
    names = _frame_names(model, sides)
    fitting = _Fitting(model, urdf, data, folders, links, zero, start)
    respected = bool(data.respect_up_axis)
    fits = [fitting.fit(link, respected) for link in links]
    if len({kind for _, kind in fits}) > 1:
        fitting = replace(fitting, kinds=("visual", "collision"))
        fits = [fitting.fit(link, respected) for link in links]
    wide = all(fit.half_width > WIDE * fit.half_length for fit, _ in fits)
    if wide and data.respect_up_axis is None and len(links) == len(SIDES) and not data.sole:
        turned = [fitting.fit(link, True) for link in links]
        if all(fit.half_length > WIDE * fit.half_width for fit, _ in turned):
            fits, respected = turned, True
    soles, facts = [], []
    for side, link, (fit, kind) in zip(sides, links, fits, strict=True):
        origin: Origin = "derived" if kind else "stated"
        source = f"{kind} shapes, normal from the {fit.source}" if kind else fit.source
        facts.append(Fact(f"{spoken(side)} sole", _size(fit), origin, source))
        name, joint = names[side], parent_joint(model, link)
        parent = model.getFrameId(link, pin.BODY)
        frame_id = model.addFrame(pin.Frame(name, joint, parent, fit.placement, pin.OP_FRAME))
        soles.append(
            Sole(
                name, side, int(frame_id), joint, fit.placement,
                float(fit.half_length), float(fit.half_width), link,
            )
        )  # fmt: skip
    if respected:
        rule = "as their coordinates stand the soles are wider than long"
        statement = data.statement_of("respect_up_axis")
        facts.append(Fact.of("meshes", "turned by their <up_axis>", statement, rule))
    return tuple(soles), respected, facts


@dataclass(frozen=True)
class _Fitting:
    """Fits soles to feet; for the attributes see `add_soles`."""

    model: pin.Model
    urdf: Urdf
    data: RobotData
    folders: tuple[Path, ...]
    links: tuple[str, ...]
    zero: np.ndarray
    start: np.ndarray
    kinds: tuple[str, ...] = ("collision", "visual")  # of shapes, the first that a foot has

    def fit(self, link: str, respect_up_axis: bool) -> tuple[SoleFit, str]:
        """Return the sole of a foot, and the kind of its shapes; empty when it is stated."""
        model, urdf, links = self.model, self.urdf, self.links
        joint = parent_joint(model, link)
        foot = model.frames[model.getFrameId(link, pin.BODY)]
        if self.data.sole:
            return _stated(self.data, foot.placement), ""
        surface = foot_surface(urdf, model, joint, self.folders, respect_up_axis, self.kinds)
        if not len(surface.points):
            raise RobotDescriptionError(_no_surface(urdf, link, surface.missing))
        axes = np.hstack([foot.placement.rotation, np.eye(3)])
        up, forward = _directions(model, self.zero, links, joint)
        fit = fit_sole(surface, up, forward, axes)
        if not fit.flat:
            fit = fit_sole(surface, resting_normal(surface, up), forward, axes)
        if not fit.flat or len(links) > len(SIDES):
            _refuse_wheel(model, urdf, surface, link, joint)
            at_start = _directions(model, self.start, links, joint)
            # The feet of a quadruped turn with its shanks.
            on_four = len(links) > len(SIDES)
            fit = fit_point(surface, *at_start) if on_four else fit_sole(surface, *at_start, axes)
        return fit, surface.kind


def sides_of(feet: Sequence[object]) -> tuple[Side, ...]:
    """Return the sides of two or of four feet."""
    return QUADRUPED_SIDES if len(feet) == len(QUADRUPED_SIDES) else SIDES


def spoken(side: Side) -> str:
    """Return a side as it stands in a sentence, e.g. `front left`."""
    return side.replace("_", " ")


def _frame_names(model: pin.Model, sides: tuple[Side, ...]) -> dict[Side, str]:
    """Return names for the frames of the soles that the model does not have yet."""
    suffix = "_sole"
    while any(model.existFrame(side + suffix) for side in sides):
        suffix += "_contact"
    return {side: side + suffix for side in sides}


def _refuse_wheel(
    model: pin.Model, urdf: Urdf, surface: FootSurface, link: str, joint: int
) -> None:
    """Refuse a foot without a flat face that turns about its own centre without limit.

    Raises:
        RobotDescriptionError: the foot is a wheel.
    """
    name, index = model.names[joint], model.joints[joint].idx_q
    turn = model.upperPositionLimit[index] - model.lowerPositionLimit[index]
    unlimited = model.joints[joint].nq == 1 and turn > 2.0 * np.pi
    if unlimited and is_round(surface, joint_axes(model)[joint][3:]):
        raise RobotDescriptionError(
            f"{urdf.path}: the foot '{link}' is a wheel, which turns without limit about its own "
            f"centre on the joint '{name}' and rolls away from under the robot; name links that "
            f"can stand, left_foot=… and right_foot=…, or weld the wheel, fixed_joints=['{name}']"
        )


def _directions(
    model: pin.Model, q: np.ndarray, links: tuple[str, ...], joint: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return up and forward, (3,) unit vectors in a foot joint's coordinates, at `q` (nq,).

    Forward is level and has the left (front) foot on its left.
    """
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    left, right = (data.oMi[parent_joint(model, link)].translation for link in links[:2])
    across = left - right
    forward = np.cross([across[0], across[1], 0.0], [0.0, 0.0, 1.0])
    length = float(np.linalg.norm(forward))
    # Feet behind or above each other do not define it; then it is the base's x axis.
    forward = forward / length if length > 0.02 else np.array([1.0, 0.0, 0.0])
    to_joint = data.oMi[joint].rotation.T
    return to_joint @ np.array([0.0, 0.0, 1.0]), to_joint @ forward


def _stated(data: RobotData, placement: pin.SE3) -> SoleFit:
    """Return the stated rectangle, which is given in the foot link's axes."""
    x, y = data.sole.get("center", (0.0, 0.0))
    height, length, width = (float(data.sole[key]) for key in ("height", "length", "width"))
    sole = placement * pin.SE3(np.eye(3), np.array([x, y, height], dtype=float))
    return SoleFit(sole, 0.5 * length, 0.5 * width, data.source_of("sole"), flat=True)


def _size(fit: SoleFit) -> str:
    return f"{2e3 * fit.half_length:.0f} × {2e3 * fit.half_width:.0f} mm"


def _no_surface(urdf: Urdf, link: str, missing: tuple[str, ...]) -> str:
    why = f"its mesh {missing[0]} is missing" if missing else "it has no collision or visual shape"
    return (
        f"{urdf.path}: the foot '{link}' has no surface to stand on ({why}); add a <collision>, "
        "give package_dirs=…, or state [sole] height, length and width in a data file"
    )
