"""`Robot`: a Pinocchio model with what a whole-body controller needs to know about it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from wbc.errors import FrameNotFound, JointNotFound
from wbc.robot.finding import Fact, Finding
from wbc.robot.geometry import load_geometry
from wbc.robot.soles import Side, Sole
from wbc.robot.urdf import Urdf
from wbc.state import State


@dataclass(frozen=True, eq=False, repr=False)
class Robot:
    """A humanoid with a floating base and two soles; made by `load`.

    A robot is immutable: everything that depends on the state lives elsewhere. `copy.copy` and
    `copy.deepcopy` therefore return the same object. A pickled robot is rebuilt exactly, with
    bit-identical dynamics, and leaves out meshes that were read meanwhile.

    Attributes:
        name: the robot's name.
        model: free-flyer first, then one coordinate per joint in the order of
            the URDF's tree; has the frames `left_sole` and `right_sole`.
        soles: left and right.
        torso: name of the upper trunk's link (a frame of the model).
        base: name of the root link (a frame of the model).
        imu: name of the frame where the inertial unit sits.
        q_nominal: (nq,) posture to stand in, soles on z = 0, their midpoint at
            the origin, heading +x; m, unit quaternion, rad.
        legs: velocity indices (into nv) of the joints from the base to each
            sole, left and right, from the hip down.
        urdf: the parsed description.
        respect_up_axis: whether Collada meshes mean their `<up_axis>`.
        srdf: path of the semantic description; None without one.
        package_dirs: folders in which `package://` is looked up.
        facts: properties that were derived from the model or stated.
        findings: defects that loading had to substitute or repair.
    """

    name: str
    model: pin.Model
    soles: tuple[Sole, Sole]
    torso: str
    base: str
    imu: str
    q_nominal: np.ndarray
    legs: tuple[tuple[int, ...], tuple[int, ...]]
    urdf: Urdf
    srdf: Path | None = None
    package_dirs: tuple[Path, ...] = ()
    respect_up_axis: bool = False
    facts: tuple[Fact, ...] = ()
    findings: tuple[Finding, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "q_nominal", _frozen(self.q_nominal))

    def __repr__(self) -> str:
        left, right = self.soles
        return (
            f"Robot('{self.name}', {self.na} joints, {self.mass:.1f} kg, "
            f"soles {left.size_text} on '{left.link}' and '{right.link}')"
        )

    def __copy__(self) -> Robot:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Robot:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        # Pinocchio writes a model as text and cannot read infinity back from it.
        values["model"] = model = self.model.copy()
        limits = {name: np.array(getattr(model, name)) for name in _LIMITS}
        for name, limit in limits.items():
            setattr(model, name, np.zeros_like(limit))
        return _unpickled, (values, limits)

    @property
    def nq(self) -> int:
        """Size of a configuration."""
        return int(self.model.nq)

    @property
    def nv(self) -> int:
        """Size of a velocity."""
        return int(self.model.nv)

    @property
    def na(self) -> int:
        """Number of actuated joints."""
        return int(self.model.nv) - 6

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """(na,) names of the actuated joints, in the model's order."""
        return tuple(self.model.names)[2:]

    @cached_property
    def tau_max(self) -> np.ndarray:
        """(na,) effort limits, N·m or N; finite and positive (see `findings`)."""
        return _frozen(self.model.effortLimit[6:])

    @cached_property
    def v_max(self) -> np.ndarray:
        """(na,) velocity limits, rad/s or m/s; infinite where none is stated."""
        return _frozen(self.model.velocityLimit[6:])

    @cached_property
    def q_min(self) -> np.ndarray:
        """(na,) lower position limits, rad or m; -inf for a continuous joint."""
        return _frozen(self.model.lowerPositionLimit[7:])

    @cached_property
    def q_max(self) -> np.ndarray:
        """(na,) upper position limits, rad or m; inf for a continuous joint."""
        return _frozen(self.model.upperPositionLimit[7:])

    @cached_property
    def mass(self) -> float:
        """Total mass, kg."""
        return float(pin.computeTotalMass(self.model))

    @cached_property
    def gravity(self) -> float:
        """Magnitude of the model's gravitational acceleration, m/s²."""
        return float(np.linalg.norm(self.model.gravity.linear))

    @cached_property
    def weight(self) -> float:
        """Mass times gravitational acceleration, N."""
        return self.mass * self.gravity

    @cached_property
    def com_height(self) -> float:
        """Height of the centre of mass above the soles in the nominal posture, m."""
        return float(pin.centerOfMass(self.model, self.model.createData(), self.q_nominal)[2])

    @cached_property
    def leg_length(self) -> float:
        """Length of the stretched leg from its first joint to the sole, m (mean of both)."""
        lengths = []
        for sole in self.soles:
            hip = self._leg_chain(sole)
            lengths.append(
                sum(
                    float(np.linalg.norm(self.model.jointPlacements[j].translation))
                    for j in hip[1:]
                )
                + float(np.linalg.norm(sole.placement.translation))
            )
        return float(np.mean(lengths))

    @property
    def urdf_path(self) -> Path:
        """The path of the description."""
        return self.urdf.path

    @cached_property
    def visual_model(self) -> pin.GeometryModel:
        """The visual shapes; meshes are read on first use, missing ones left out."""
        return self._geometry(pin.VISUAL)

    @cached_property
    def collision_model(self) -> pin.GeometryModel:
        """The collision shapes; meshes are read on first use, missing ones left out."""
        return self._geometry(pin.COLLISION)

    def sole(self, name: str) -> Sole:
        """The sole of that name (`left_sole`, `right_sole`) or side (`left`, `right`).

        Raises:
            FrameNotFound: no sole is called so.
        """
        for sole in self.soles:
            if name in (sole.name, sole.side):
                return sole
        raise FrameNotFound(name, [sole.name for sole in self.soles], "Robot.sole")

    def leg_joints(self, side: Side) -> tuple[int, ...]:
        """Velocity indices (into nv) of the joints between base and sole, hip first."""
        return self.legs[self.soles.index(self.sole(side))]

    def joint_index(self, name: str) -> int:
        """Index of an actuated joint into (na,) vectors; add 6 for nv, 7 for nq.

        Raises:
            JointNotFound: the model has no such joint; lists near names.
        """
        try:
            return self.joint_names.index(name)
        except ValueError:
            raise JointNotFound(name, self.joint_names, f"robot '{self.name}'") from None

    def frame_id(self, name: str) -> int:
        """Index of a frame in `model.frames`.

        Raises:
            FrameNotFound: the model has no such frame; lists near names.
        """
        # A URDF may call a joint and a link the same; the link's frame is the one meant.
        for kind in (pin.BODY, pin.OP_FRAME, pin.SENSOR, pin.FIXED_JOINT, pin.JOINT):
            if self.model.existFrame(name, kind):
                return int(self.model.getFrameId(name, kind))
        names = [frame.name for frame in self.model.frames[1:]]
        raise FrameNotFound(name, names, f"robot '{self.name}'")

    def standing(self) -> State:
        """The nominal posture at rest: soles on z = 0, midpoint at the origin, heading +x."""
        return State(self.q_nominal.copy(), np.zeros(self.nv))

    def check(self) -> list[Finding]:
        """Everything that is wrong with the robot's description, worst first."""
        from wbc.robot.doctor import check_robot

        return check_robot(self)

    def _geometry(self, kind: pin.GeometryType) -> pin.GeometryModel:
        return load_geometry(self.model, self.urdf, kind, self.package_dirs, self.respect_up_axis)

    def _leg_chain(self, sole: Sole) -> list[int]:
        leg = self.legs[self.soles.index(sole)]
        return [j for j in self.model.supports[sole.joint_id] if self.model.joints[j].idx_v in leg]


_LIMITS = ("effortLimit", "velocityLimit", "lowerPositionLimit", "upperPositionLimit")


def _unpickled(values: dict[str, Any], limits: dict[str, np.ndarray]) -> Robot:
    for name, limit in limits.items():
        setattr(values["model"], name, limit)
    return Robot(**values)


def _frozen(values: np.ndarray) -> np.ndarray:
    copy = np.array(values, dtype=float)
    copy.setflags(write=False)
    return copy
