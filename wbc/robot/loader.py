"""`load`: from a name or a path to a `Robot`, step by step."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import pinocchio as pin

from wbc.errors import RobotDescriptionError, did_you_mean
from wbc.robot.couplings import couple, read_couplings, share_efforts
from wbc.robot.data_file import RobotData
from wbc.robot.description import read_description
from wbc.robot.feet import checked_foot_link, find_feet, foot_pairs
from wbc.robot.finding import Fact, Finding, Origin
from wbc.robot.inertia import add_placeholder_masses, check_mass_matrix, repair_model
from wbc.robot.limits import set_armature, set_limits
from wbc.robot.model import build_model
from wbc.robot.packages import search_folders
from wbc.robot.posture import (
    Posture,
    bent_quadruped,
    centered_quadruped,
    com_offset,
    nominal_posture,
    stand_base_up,
    starting_posture,
    zero_posture,
)
from wbc.robot.registry import find_robot
from wbc.robot.robot import Robot
from wbc.robot.soles import QUADRUPED_SIDES, add_soles, sides_of, spoken
from wbc.robot.srdf import find_srdf
from wbc.robot.topology import (
    find_torso,
    front_to_hind,
    leg_joints,
    link_of,
    lowest_pair,
    parent_joint,
)
from wbc.robot.urdf import Urdf


def load(
    name_or_path: str | Path,
    *,
    left_foot: str | None = None,
    right_foot: str | None = None,
    feet: Sequence[str] | None = None,
    nominal_posture: Mapping[str, float] | None = None,
    srdf: str | Path | None = None,
    group_state: str | None = None,
    armature: float | Mapping[str, float] | None = None,
    effort_limits: Mapping[str, float] | None = None,
    velocity_limits: Mapping[str, float] | None = None,
    sole: Mapping[str, Any] | None = None,
    fixed_joints: Collection[str] | None = None,
    package_dirs: Collection[str | Path] | None = None,
    torso: str | None = None,
    imu: str | None = None,
    respect_up_axis: bool | None = None,
    name: str | None = None,
) -> Robot:
    """Load a robot.

    The keyword arguments state what the description leaves open; they take precedence over the
    robot's data file, whose keys have the same names (`docs/robots.md`). Limits and package
    folders are added to those of the file; every other argument replaces the file's value.

    Args:
        name_or_path: a robot with a data file (`available()`), a URDF of
            example-robot-data by name (`examples()`), or the path of a URDF or
            of a robot data file.
        left_foot: link that carries the left sole; by default guessed from the names of
            the links if they leave no doubt.
        right_foot: link that carries the right sole.
        feet: links of the four feet of a quadruped: front left, front right, hind left, hind
            right; by default guessed from the names of the links.
        nominal_posture: posture to stand in, joint name to position, rad or m. Leg joints left
            out are derived such that the soles are flat; others stay at zero.
        srdf: semantic description with a posture to stand in; by default the one beside the
            URDF. It hides the data file's `nominal_posture`.
        group_state: name of the SRDF's `group_state`, or of the MJCF file's keyframe, to stand in;
            by default the first of `half_sitting`, `standing` and similar names.
        armature: rotor inertia at the joints, kg·m² (kg for sliding joints), one for all or by
            joint name, with `default` for the others.
        effort_limits: joint name to effort limit, N·m or N, in place of the URDF's.
        velocity_limits: joint name to velocity limit, rad/s or m/s, in place of the URDF's.
        sole: `height` of the sole plane in the foot links, `length`, `width` and, if
            not zero, `center` (x, y) of its rectangle, m, in the foot links' axes; for
            feet that have no shape.
        fixed_joints: joints to weld at zero, by name or pattern (`*Finger*`).
        package_dirs: folders that hold packages, for `package://`.
        torso: link of the upper trunk; by default the link from which the arms branch.
        imu: frame of the inertial unit; by default the base link.
        respect_up_axis: whether the Collada meshes mean their `<up_axis>`, which ROS ignores; when
            left out, they do if the soles would be wider than long otherwise.
        name: the robot's name; by default the data file's, or the URDF's `<robot name=…>`.

    Raises:
        RobotNotFound: no such name and no such file.
        RobotDescriptionError: an argument cannot be what it is for, or the description is
            malformed or makes no usable model; the text names the key, link, joint or line,
            and the cure.
    """
    data = find_robot(name_or_path).with_arguments(
        left_foot=left_foot,
        right_foot=right_foot,
        feet=feet,
        nominal_posture=nominal_posture,
        srdf=srdf,
        group_state=group_state,
        armature=armature,
        effort_limits=effort_limits,
        velocity_limits=velocity_limits,
        sole=sole,
        fixed_joints=fixed_joints,
        package_dirs=package_dirs,
        torso=torso,
        imu=imu,
        respect_up_axis=respect_up_axis,
        name=name,
    )
    return build_robot(data)


def build_robot(data: RobotData) -> Robot:
    """Build the robot that the data describe.

    Raises:
        RobotDescriptionError: the description is malformed or unusable.
    """
    urdf, data = read_description(data.urdf), data.without_fixed_joints()
    folders = search_folders(data.urdf, data.package_dirs)
    model = build_model(urdf, known_joints(data, urdf))
    name = data.name or (urdf.element.get("name") or "").strip() or urdf.path.stem
    model.name = name
    base = link_of(model, urdf, 1)
    facts = [Fact("base", base, "derived", "root of the tree")]
    # Before any repair, which would hide a massless link.
    check_mass_matrix(model, pin.neutral(model), str(urdf.path))
    findings = repaired(model, urdf)
    add_placeholder_masses(model)

    links, rule = feet_links(data, urdf, model)
    for side, link in zip(sides_of(links), links, strict=True):
        statement = data.statement_of("feet" if len(links) > 2 else f"{side}_foot")
        facts.append(Fact.of(f"{spoken(side)} foot", link, statement, rule))
    feet = tuple(parent_joint(model, link) for link in links)
    for link, joint in zip(links, feet, strict=True):
        if joint == 1:
            raise RobotDescriptionError(
                f"{urdf.path}: the foot '{link}' is moved by no joint, it is part of the base "
                f"'{base}'; state links that move, left_foot=… and right_foot=…, or weld fewer "
                "joints"
            )
    for k, joint in enumerate(feet):
        if joint in feet[:k]:
            raise RobotDescriptionError(
                f"{urdf.path}: the feet '{links[feet.index(joint)]}' and '{links[k]}' are moved by "
                "the same joint; state links that move apart"
            )
    legs = leg_joints(model, feet)
    findings += set_limits(model, data, legs)

    set_armature(model, data)
    couplings = read_couplings(urdf, model)
    share_efforts(model, couplings)
    zero, start = zero_posture(model), starting_posture(model, data, urdf, legs)
    couple(zero, couplings)
    couple(start.q, couplings)
    stand_base_up(model, zero, feet)
    stand_base_up(model, start.q, feet)
    if len(feet) > 2 and not start.how:
        start = bent_quadruped(model, start, links, legs, couplings)
    if len(feet) > 2:
        start = centered_quadruped(model, start, links, legs, couplings)
    soles, respect_up_axis, sole_facts = add_soles(model, urdf, data, folders, links, zero, start.q)
    posture = nominal_posture(model, start, soles, legs, couplings)
    torso = _frame(model, data, "torso", data.torso) or find_torso(model, urdf, legs)
    imu = _frame(model, data, "imu", data.imu) or base
    armature = float(model.armature.max())
    facts += [
        *sole_facts,
        _posture_fact(model, posture),
        Fact.of("torso", torso, data.statement_of("torso"), "the link where the limbs branch"),
        Fact.of("imu", imu, data.statement_of("imu"), "the base link"),
        Fact.of(
            "armature",
            f"{armature:g} kg·m²" if armature else "none",
            data.statement_of("armature"),
            "none stated",
        ),
    ]
    return Robot(
        name=name,
        model=model,
        soles=soles,
        torso=torso,
        base=base,
        imu=imu,
        q_nominal=posture.q,
        legs=legs,
        urdf=urdf,
        srdf=data.srdf or find_srdf(data.urdf),
        package_dirs=folders,
        respect_up_axis=respect_up_axis,
        couplings=couplings,
        facts=tuple(facts),
        findings=tuple(findings),
    )


def _posture_fact(model: pin.Model, posture: Posture) -> Fact:
    offset = 1e3 * com_offset(model, posture.q)
    value = (
        f"{posture.how}; centre of mass ({offset[0]:+.0f}, {offset[1]:+.0f}) mm "
        "from the soles' midpoint"
    )
    origin: Origin = "stated" if posture.stated else "derived"
    return Fact("nominal posture", value, origin, posture.source)


def repaired(model: pin.Model, urdf: Urdf) -> list[Finding]:
    return [
        Finding(
            "warning",
            link_of(model, urdf, joint),
            "its body has an inertia that no rigid body can have",
            "the nearest physical inertia is used instead",
            "correct the <inertia>: positive principal moments, none above the sum of the others",
            "non-physical-inertia",
        )
        for joint in repair_model(model)
    ]


def feet_links(data: RobotData, urdf: Urdf, model: pin.Model) -> tuple[tuple[str, ...], str]:
    """Return the (left, right) foot links, stated or guessed, and the rule of the guess.

    Those of a quadruped are four, in the order of `QUADRUPED_SIDES`.

    Raises:
        RobotDescriptionError: a stated link does not exist, only one is stated, or neither the
            names nor the places of the links tell which are the feet.
    """
    if data.feet:
        stated_feet = zip(QUADRUPED_SIDES, data.feet, strict=True)
        return tuple(checked_foot_link(urdf, link, side) for side, link in stated_feet), "stated"
    if data.left_foot is not None and data.right_foot is not None:
        left = checked_foot_link(urdf, data.left_foot, "left")
        return (left, checked_foot_link(urdf, data.right_foot, "right")), "stated"
    if data.left_foot is not None or data.right_foot is not None:
        stated, missing = ("left", "right") if data.left_foot is not None else ("right", "left")
        raise RobotDescriptionError(
            f"{urdf.path}: {stated}_foot is stated but {missing}_foot is not; state both, "
            f"left_foot=… and right_foot=…{did_you_mean('foot', urdf.links, 6)}"
        )
    guess = find_feet(urdf)
    if guess is not None:
        return guess, "its name"
    several = foot_pairs(urdf)
    if len(several) == 2:
        return front_to_hind(model, several), "its name"
    if len(several) > 2:
        names = ", ".join(f"'{name}'" for pair in several for name in pair)
        raise RobotDescriptionError(
            f"{urdf.path}: the links {names} may all be feet, and the library stands and walks on "
            "two or four; state them, left_foot=… and right_foot=…, or feet=…"
        )
    joints = lowest_pair(model)
    if joints is not None:
        left, right = (link_of(model, urdf, joint) for joint in joints)
        return (left, right), "the end of a leg: the links' names do not tell"
    raise RobotDescriptionError(
        f"{urdf.path}: neither the names of the links nor their places tell which are the left "
        "and the right foot; state both, left_foot=… and right_foot=… (a robot needs two feet)"
        f"{did_you_mean('foot', urdf.links, 6)}"
    )


def _frame(model: pin.Model, data: RobotData, what: str, name: str | None) -> str | None:
    if name is not None and not model.existFrame(name):
        names = [frame.name for frame in model.frames]
        raise RobotDescriptionError(
            f"{data.source_of(what)}: {what} is '{name}', but the model has no such frame"
            f"{did_you_mean(name, names)}"
        )
    return name


def known_joints(data: RobotData, urdf: Urdf) -> tuple[str, ...]:
    """The stated patterns of joints to weld, each of which must mean something."""
    names = [joint.name for joint in urdf.joints]
    for pattern in data.fixed_joints:
        if not any(fnmatchcase(name, pattern) for name in names):
            raise RobotDescriptionError(
                f"{data.source_of('fixed_joints')}: fixed_joints names '{pattern}', which is no "
                f"joint of {urdf.path.name}{did_you_mean(pattern.strip('*?'), names)}"
            )
    return data.fixed_joints
