"""One case of the comparison: a robot, a problem and recorded ticks, as files for every peer.

Each peer's environment imports this module, so it needs only numpy and the standard library.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

BOTH, LEFT, RIGHT = 0, 1, 2
STANCES = {BOTH: ("left", "right"), LEFT: ("left",), RIGHT: ("right",)}
SOLES = {"left": "left_sole", "right": "right_sole"}
TORSO = "torso_frame"


@dataclass(frozen=True)
class Gains:
    """Weights and gains, the same for every library; kd = 2 √kp.

    Attributes:
        com_weight: weight of the CoM's acceleration; likewise for the other tasks.
        com_kp: 1/s².
        posture_weight: the same for all joints, because TSID and placo allow no other.
        momentum_kp: 1/s.
        force_weight: weight of every contact force and moment.
        contact_damping: decay rate of a resting foot's velocity, 1/s; there is no position term.
    """

    com_weight: float = 3000.0
    com_kp: float = 40.0
    torso_weight: float = 20.0
    torso_kp: float = 80.0
    posture_weight: float = 1.0
    posture_kp: float = 60.0
    momentum_weight: float = 0.001
    momentum_kp: float = 5.0
    swing_weight: float = 300.0
    swing_kp: float = 400.0
    force_weight: float = 1e-5
    contact_damping: float = 30.0


@dataclass(frozen=True)
class Limits:
    """Limits of the actuated joints, each (na,).

    Attributes:
        torque: N·m.
        velocity: rad/s.
        lower: smallest position, rad.
        upper: largest position, rad.
        braking: deceleration by which a joint stops before its position limit, rad/s².
        horizon: time within which position and velocity limits act, s.
    """

    torque: np.ndarray
    velocity: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    braking: np.ndarray
    horizon: float


@dataclass(frozen=True)
class Ticks:
    """n recorded ticks, in world axes, linear before angular.

    Attributes:
        q: (n, nq) configurations.
        v: (n, nv) velocities.
        stance: (n,) standing feet: BOTH, LEFT or RIGHT.
        com: (n, 3) reference position, m; com_velocity and com_acceleration alike.
        torso: (n, 3, 3) reference orientation.
        torso_velocity: (n, 3) rad/s.
        swing: (n, 4, 4) reference pose of the free foot, T_world_sole; unused in double support.
        swing_velocity: (n, 6).
        swing_acceleration: (n, 6).
        posture: (na,) rad.
    """

    q: np.ndarray
    v: np.ndarray
    stance: np.ndarray
    com: np.ndarray
    com_velocity: np.ndarray
    com_acceleration: np.ndarray
    torso: np.ndarray
    torso_velocity: np.ndarray
    swing: np.ndarray
    swing_velocity: np.ndarray
    swing_acceleration: np.ndarray
    posture: np.ndarray

    def __len__(self) -> int:
        return len(self.q)

    def part(self, chosen: np.ndarray) -> Ticks:
        """Return some of the ticks, by mask or index."""
        values = {k: v if k == "posture" else v[chosen] for k, v in vars(self).items()}
        return Ticks(**values)


@dataclass(frozen=True)
class Case:
    """A robot, its problem and its ticks.

    Attributes:
        name: short name, also of the folder.
        title: title in tables.
        robot: name under which `wbc` loads it.
        urdf: the same robot as a URDF of bodies and joints only.
        joints: (na,) names in the order of q[7:].
        armature: (na,) rotor inertia at the joint, kg·m².
        half_length: of both soles' contact rectangle, m.
        half_width: likewise, m.
        friction: coefficient of the friction pyramid, |f_x| ≤ friction f_z.
        limits: limits of the joints.
        gains: weights and gains of the tasks.
        ticks: the recorded ticks.
        mass_matrix: (nv, nv) of the first tick, to check that the robots are the same.
        bias_forces: (nv,) likewise.
    """

    name: str
    title: str
    robot: str
    urdf: str
    joints: tuple[str, ...]
    armature: np.ndarray
    half_length: float
    half_width: float
    friction: float
    limits: Limits
    ticks: Ticks
    mass_matrix: np.ndarray
    bias_forces: np.ndarray
    gains: Gains = field(default_factory=Gains)

    def save(self, folder: Path) -> None:
        """Write `robot.urdf`, `case.json` and `ticks.npz`."""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "robot.urdf").write_text(self.urdf)
        plain = {k: getattr(self, k) for k in _PLAIN}
        plain["horizon"] = self.limits.horizon
        plain["gains"] = asdict(self.gains)
        (folder / "case.json").write_text(json.dumps(plain, indent=2))
        arrays = {f"ticks.{k}": v for k, v in vars(self.ticks).items()}
        arrays |= {f"limits.{k}": v for k, v in vars(self.limits).items() if k != "horizon"}
        arrays |= {k: getattr(self, k) for k in _ARRAYS}
        np.savez(folder / "ticks.npz", **arrays)

    @classmethod
    def load(cls, folder: Path) -> Case:
        """Read a case that `save` wrote."""
        plain = json.loads((folder / "case.json").read_text())
        with np.load(folder / "ticks.npz") as file:
            arrays = {k: file[k] for k in file.files}

        def group(prefix: str) -> dict[str, np.ndarray]:
            start = prefix + "."
            return {k.removeprefix(start): v for k, v in arrays.items() if k.startswith(start)}

        limits = Limits(**group("limits"), horizon=plain.pop("horizon"))
        gains = Gains(**plain.pop("gains"))
        plain["joints"] = tuple(plain["joints"])
        return cls(
            **plain,
            **{k: arrays[k] for k in _ARRAYS},
            urdf=(folder / "robot.urdf").read_text(),
            limits=limits,
            ticks=Ticks(**group("ticks")),
            gains=gains,
        )

    def check_model(self, M: np.ndarray, h: np.ndarray, joints: list[str]) -> None:
        """Refuse a peer's robot that is not the recorded one.

        Raises:
            ValueError: names, mass matrix or bias forces differ.
        """
        if tuple(joints) != self.joints:
            raise ValueError(f"joints {joints} instead of {list(self.joints)}")
        worst = max(
            float(np.abs(M - self.mass_matrix).max() / np.abs(self.mass_matrix).max()),
            float(np.abs(h - self.bias_forces).max() / np.abs(self.bias_forces).max()),
        )
        if not worst < 1e-9:
            raise ValueError(f"mass matrix or bias forces differ by {worst:.1e} of their largest")


_PLAIN = ("name", "title", "robot", "joints", "half_length", "half_width", "friction")
_ARRAYS = ("armature", "mass_matrix", "bias_forces")
