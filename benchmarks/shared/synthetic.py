"""Generates URDFs of humanoids with any number of joints, for the scaling benchmark.

Each has two legs of six joints and two feet; the other joints are distributed over spine, neck,
arms of up to seven joints, and then fingers, five chains on each hand. Links are homogeneous boxes,
so that inertias are physical; the total mass is about 60 kg for any number of joints.

    python benchmarks/shared/synthetic.py 60 > humanoid.urdf
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import wbc

Vector = tuple[float, float, float]

MIN_JOINTS = 15
POSTURE = {"hip_pitch": -0.35, "knee": 0.7, "ankle_pitch": -0.35, "elbow": 1.2}
_LEG = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")
_ARM = ("shoulder_pitch", "elbow", "shoulder_roll", "shoulder_yaw", "wrist_pitch")
_ARM += ("wrist_yaw", "wrist_roll")  # in the order in which a growing robot gets them
_ALONG_ARM = ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow")
_ALONG_ARM += ("wrist_yaw", "wrist_pitch", "wrist_roll")
_AXES = {"pitch": "0 1 0", "knee": "0 1 0", "elbow": "0 -1 0", "roll": "1 0 0", "yaw": "0 0 1"}


@dataclass(frozen=True)
class Body:
    """A box and the joint that carries it.

    Attributes:
        name: of the link; the joint is called `<name>_joint`, or `joint`.
        parent: link that the joint hangs on.
        at: (3,) the joint in the parent's axes, m.
        size: (3,) edges of the box, m.
        center: (3,) its centre in the link's axes, m.
        mass: kg.
        axis: of the joint; empty for a fixed one.
        effort: torque limit, N·m.
        reach: positions, rad.
    """

    name: str
    parent: str
    at: Vector
    size: Vector
    center: Vector
    mass: float
    axis: str = ""
    effort: float = 0.0
    reach: tuple[float, float] = (-1.5, 1.5)


@dataclass(frozen=True)
class Share:
    """The number of joints of each part."""

    spine: int
    neck: int
    arm: tuple[int, int]
    finger: tuple[tuple[int, ...], tuple[int, ...]]

    @classmethod
    def of(cls, joints: int) -> Share:
        """Distribute `joints` over legs, then trunk and arms, then fingers.

        Raises:
            ValueError: The joints do not suffice for two legs and a pair of shoulders.
        """
        if joints < MIN_JOINTS:
            raise ValueError(f"{joints} joints are too few: give at least {MIN_JOINTS}")
        left = joints - 2 * len(_LEG)
        spine = min(left - 2, 1 + joints // 20)
        neck = 2 if joints >= 26 else 0
        left -= spine + neck
        arms = min(left, 2 * len(_ARM))
        left -= arms
        hands = (left - left // 2, left // 2)
        fingers = tuple(tuple(n // 5 + (k < n % 5) for k in range(5)) for n in hands)
        return cls(spine, neck, (arms - arms // 2, arms // 2), fingers)  # type: ignore[arg-type]


def urdf(joints: int, seed: int | None = None) -> str:
    """Return the URDF of a humanoid.

    Args:
        joints: Number of actuated joints, at least `MIN_JOINTS`.
        seed: Seed for varying lengths, masses and torque limits by up to 25 %; None varies
            nothing.
    """
    rng = np.random.default_rng(seed)
    vary = (lambda: rng.uniform(0.75, 1.25)) if seed is not None else (lambda: 1.0)
    share = Share.of(joints)
    bodies = [
        Body("pelvis", "", (0.0, 0.0, 0.0), (0.16, 0.26, 0.14), (0.0, 0.0, 0.0), 8.0 * vary())
    ]
    thigh, shin, width = 0.38 * vary(), 0.38 * vary(), 0.1 * vary()
    strength, weight = vary(), vary()
    for side, y in (("left", 1.0), ("right", -1.0)):
        bodies += _leg(side, y * width, thigh, shin, strength, weight)
    top = bodies[0].name
    at = (0.0, 0.0, 0.08)
    for k in range(share.spine):
        length, last = 0.3 / share.spine, k == share.spine - 1
        name = "torso" if last else f"spine_{k + 1}"
        size = (0.16, 0.3, length + (0.12 if last else 0.0))
        center = (0.0, 0.0, 0.5 * size[2])
        axis = _AXES[("yaw", "pitch", "roll")[k % 3]]
        mass = (8.0 + 8.0 * last) / (1 if last else share.spine) * vary()
        bodies.append(Body(name, top, at, size, center, mass, axis, 150.0 * vary(), (-1.0, 1.0)))
        top, at = name, (0.0, 0.0, size[2])
    for k in range(share.neck):
        name = f"neck_{k + 1}"
        axis = _AXES[("yaw", "pitch")[k % 2]]
        bodies.append(Body(name, top, at, (0.06,) * 3, (0.0, 0.0, 0.03), 0.5, axis, 20.0))
        top, at = name, (0.0, 0.0, 0.05)
    bodies.append(Body("head", top, at, (0.18, 0.16, 0.22), (0.0, 0.0, 0.13), 3.5))
    upper, lower = 0.28 * vary(), 0.25 * vary()
    for k, (side, y) in enumerate((("left", 1.0), ("right", -1.0))):
        bodies += _arm(side, y, share.arm[k], upper, lower, weight)
        bodies += _fingers(side, share.finger[k])
    text = "\n".join(_element(body) for body in bodies)
    return f'<?xml version="1.0"?>\n<robot name="synthetic_{joints}">\n{text}\n</robot>\n'


def load(joints: int, seed: int | None = None) -> wbc.Robot:
    """Return the robot of `urdf`, with bent knees and elbows in its nominal posture."""
    text = urdf(joints, seed)
    posture = {
        f"{side}_{joint}": angle
        for side in ("left", "right")
        for joint, angle in POSTURE.items()
        if f'name="{side}_{joint}"' in text
    }
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"synthetic_{joints}.urdf"
        path.write_text(text)
        return wbc.load(
            path,
            left_foot="left_foot",
            right_foot="right_foot",
            torso="torso",
            nominal_posture=posture,
            armature=0.01,
        )


def _leg(
    side: str, y: float, thigh: float, shin: float, strength: float, weight: float
) -> Iterator[Body]:
    ball, middle = (0.08, 0.08, 0.08), (0.0, 0.0, 0.0)
    knee, ankle = (0.0, 0.0, -thigh), (0.0, 0.0, -shin)
    boxes = (
        # joint, where it is in its parent, box and its centre, kg, N·m, rad
        ("hip_yaw", (0.0, y, -0.06), ball, middle, 1.2, 100.0, (-0.9, 0.9)),
        ("hip_roll", middle, ball, middle, 1.0, 160.0, (-0.8, 0.8)),
        ("hip_pitch", middle, (0.12, 0.12, thigh), _below(thigh), 4.5, 200.0, (-2.1, 0.8)),
        ("knee", knee, (0.09, 0.09, shin), _below(shin), 2.8, 220.0, (0.0, 2.4)),
        ("ankle_pitch", ankle, (0.05, 0.05, 0.05), middle, 0.5, 140.0, (-1.2, 0.9)),
        ("ankle_roll", middle, (0.22, 0.1, 0.04), (0.04, 0.0, -0.06), 1.1, 80.0, (-0.6, 0.6)),
    )
    parent = "pelvis"
    for joint, at, size, center, mass, effort, reach in boxes:
        name = f"{side}_foot" if joint == "ankle_roll" else f"{side}_{joint}_link"
        axis = _axis(joint)
        yield Body(name, parent, at, size, center, mass * weight, axis, effort * strength, reach)
        parent = name


def _arm(
    side: str, y: float, joints: int, upper: float, lower: float, weight: float
) -> Iterator[Body]:
    chosen = set(_ARM[:joints])
    parent, at, end = "torso", (0.0, 0.2 * y, 0.3), _below(2.0 * upper)
    for joint in (j for j in _ALONG_ARM if j in chosen):
        if joint == "elbow":
            at, end = end, _below(2.0 * lower)
            box, mass, effort = (0.07, 0.07, lower), 1.1, 40.0
        elif joint.startswith("shoulder"):
            # Up to three joints at one place share the upper arm's mass.
            box, mass, effort = (0.08, 0.08, upper), 0.9, 60.0
        else:
            at, end = end, (0.0, 0.0, 0.0)
            box, mass, effort = (0.05, 0.05, 0.05), 0.3, 15.0
        name = f"{side}_{joint}_link"
        center = _below(box[2])
        reach = (-2.2, 2.2)
        yield Body(name, parent, at, box, center, mass * weight, _axis(joint), effort, reach)
        parent, at = name, (0.0, 0.0, 0.0)
    palm = (0.03, 0.08, 0.09)
    yield Body(f"{side}_hand", parent, end, palm, _below(palm[2]), 0.4 * weight)


def _fingers(side: str, joints: tuple[int, ...]) -> Iterator[Body]:
    for finger, count in enumerate(joints):
        parent, at = f"{side}_hand", (0.0, 0.03 - 0.015 * finger, -0.09)
        for k in range(count):
            name = f"{side}_finger_{finger + 1}_{k + 1}"
            length = 0.12 / count
            size, center = (0.012, 0.012, length), _below(length)
            yield Body(name, parent, at, size, center, 0.06 / count, _AXES["pitch"], 1.0)
            parent, at = name, (0.0, 0.0, -length)


def _below(length: float) -> Vector:
    """Return the centre of a box of that length (m) below its joint."""
    return (0.0, 0.0, -0.5 * length)


def _axis(joint: str) -> str:
    return next(axis for word, axis in _AXES.items() if word in joint)


def _element(body: Body) -> str:
    x, y, z = body.size
    inertia = body.mass / 12.0 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    center, size = _text(body.center), _text(body.size)
    link = (
        f'  <link name="{body.name}">\n'
        f'    <collision><origin xyz="{center}"/><geometry><box size="{size}"/></geometry>'
        "</collision>\n"
        f'    <inertial><origin xyz="{center}"/><mass value="{body.mass:.6g}"/>'
        f'<inertia ixx="{inertia[0]:.6g}" iyy="{inertia[1]:.6g}" izz="{inertia[2]:.6g}"'
        ' ixy="0" ixz="0" iyz="0"/></inertial>\n  </link>'
    )
    if not body.parent:
        return link
    if body.name.endswith("_foot"):
        joint = body.name.replace("_foot", "_ankle_roll")
    else:
        joint = body.name.removesuffix("_link") if "_link" in body.name else f"{body.name}_joint"
    kind = "revolute" if body.axis else "fixed"
    limits = (
        f'<axis xyz="{body.axis}"/><limit lower="{body.reach[0]}" upper="{body.reach[1]}"'
        f' effort="{body.effort:.6g}" velocity="10"/>'
        if body.axis
        else ""
    )
    return (
        f'  <joint name="{joint}" type="{kind}"><parent link="{body.parent}"/>'
        f'<child link="{body.name}"/><origin xyz="{_text(body.at)}"/>{limits}</joint>\n{link}'
    )


def _text(vector: tuple[float, ...]) -> str:
    return " ".join(f"{x:.6g}" for x in vector)


def main() -> None:
    """Print the URDF of a humanoid."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("joints", type=int, help=f"at least {MIN_JOINTS}")
    parser.add_argument("--seed", type=int, help="vary lengths, masses and torque limits")
    args = parser.parse_args()
    print(urdf(args.joints, args.seed), end="")


if __name__ == "__main__":
    main()
