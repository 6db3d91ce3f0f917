"""`RobotModel`: a Pinocchio model with its names, limits and shapes; the base of all robots."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import coal
import numpy as np
import pinocchio as pin

from wbc.errors import FrameNotFound, JointNotFound
from wbc.robot.couplings import Coupling
from wbc.robot.finding import Fact, Finding
from wbc.robot.geometry import FOR_DISTANCES, VERTICES_ONLY, load_geometry
from wbc.robot.urdf import Urdf

if TYPE_CHECKING:
    from typing_extensions import Self


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class RobotModel:
    """A robot as far as its kind does not matter: a model, its names, limits and shapes.

    A robot is immutable: everything that depends on the state lives elsewhere. `copy.copy` and
    `copy.deepcopy` therefore return the same object. A pickled robot is rebuilt exactly, with
    bit-identical dynamics, and leaves out meshes that were read meanwhile.

    Attributes:
        name: the robot's name.
        model: free-flyer first, then one coordinate per joint in the order of the URDF's tree.
        base: name of the root link (a frame of the model).
        q_nominal: (nq,) nominal posture; m, unit quaternion, rad.
        urdf: the parsed description.
        respect_up_axis: whether Collada meshes mean their `<up_axis>`.
        srdf: path of the semantic description; None without one.
        package_dirs: folders in which `package://` is looked up.
        couplings: joints that one motor moves together with others.
        facts: properties that were derived from the model or stated.
        findings: defects that loading had to substitute or repair.
    """

    name: str
    model: pin.Model
    base: str
    q_nominal: np.ndarray
    urdf: Urdf
    srdf: Path | None = None
    package_dirs: tuple[Path, ...] = ()
    respect_up_axis: bool = False
    couplings: tuple[Coupling, ...] = ()
    facts: tuple[Fact, ...] = ()
    findings: tuple[Finding, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "q_nominal", _frozen(self.q_nominal))

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        # Pinocchio writes a model as text and cannot read infinity back from it.
        values["model"] = model = self.model.copy()
        limits = {name: np.array(getattr(model, name)) for name in _LIMITS}
        for name, limit in limits.items():
            setattr(model, name, np.zeros_like(limit))
        return _unpickled, (type(self), values, limits)

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

    @property
    def urdf_path(self) -> Path:
        """The path of the description."""
        return self.urdf.path

    @cached_property
    def visual_model(self) -> pin.GeometryModel:
        """The visual shapes; meshes are read on first use, missing ones left out."""
        return self.read_geometry(pin.VISUAL)

    @cached_property
    def collision_model(self) -> pin.GeometryModel:
        """The collision shapes, with trees for distances; meshes are read on first use, missing
        ones left out.
        """
        return self.read_geometry(pin.COLLISION, FOR_DISTANCES)

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

    def read_geometry(
        self, kind: pin.GeometryType, tree: coal.NODE_TYPE = VERTICES_ONLY
    ) -> pin.GeometryModel:
        """Read the visual or the collision shapes; see `wbc.robot.geometry.load_geometry`."""
        folders = self.package_dirs
        return load_geometry(self.model, self.urdf, kind, folders, self.respect_up_axis, tree)


_LIMITS = ("effortLimit", "velocityLimit", "lowerPositionLimit", "upperPositionLimit")


def _unpickled(
    kind: type[RobotModel], values: dict[str, Any], limits: dict[str, np.ndarray]
) -> RobotModel:
    for name, limit in limits.items():
        setattr(values["model"], name, limit)
    return kind(**values)


def _frozen(values: np.ndarray) -> np.ndarray:
    copy = np.array(values, dtype=float)
    copy.setflags(write=False)
    return copy
