"""The MuJoCo model of a robot, built from its Pinocchio model.

MuJoCo does not read the URDF: its reader drops the floating base's inertia and
does not resolve `package://`. Everything is copied from `pin.Model` instead, so
that the controller's model and the plant's agree to rounding, and every model
mismatch in a trial is intended.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from wbc.errors import MissingExtra, PlantError
from wbc.robot import Coupling, Robot
from wbc.robot.collision_shapes import SOLE_THICKNESS, CollisionShape
from wbc.robot.joint_axes import joint_axes
from wbc.sim.cart import Cart
from wbc.sim.ground import Ground
from wbc.sim.terrain import Flat

_log = logging.getLogger(__name__)

#: Contact bits. The ground meets nothing of itself.
_GROUND_BIT = 1
_ROBOT_BIT = 2
#: Time constant and damping ratio of contacts and joint stops (MuJoCo's solref), s.
#: Stiffer than MuJoCo's 20 ms: a robot of any mass sinks about 0.1 mm into the floor.
_CONTACT_SOLREF = (0.005, 1.0)
_STOP_SOLREF = (0.005, 1.0)
#: The same of joints that one motor moves together; twice the usual time step is the least.
_COUPLING_SOLREF = (0.002, 1.0)
#: Mass and inertia of bodies that have none in the robot's model: MuJoCo demands some.
_TINY_MASS = 1e-9
_TINY_INERTIA = 1e-12
#: Half size of the box of a foot that touches the ground at a point, m.
_LEAST_HALF_SIZE = 1e-3


def import_mujoco() -> Any:
    """Import and return the `mujoco` module.

    Raises:
        MissingExtra: it is not installed.
    """
    try:
        import mujoco
    except ImportError as error:
        raise MissingExtra("mujoco", "sim") from error
    # Left alone, MuJoCo writes its warnings into a file in the working directory.
    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(_log.warning)
    return mujoco


def build_model(
    robot: Robot,
    *,
    timestep: float = 0.001,
    friction: float = 0.8,
    ground: Ground | None = None,
    shapes: Sequence[CollisionShape] = (),
    excluded_pairs: Sequence[tuple[str, str]] = (),
    cart: Cart | None = None,
) -> Any:
    """Compile a `mujoco.MjModel` with the robot's dynamics, shapes, motors and stops.

    Bodies and joints carry the Pinocchio joints' names, motors too; the sole boxes are
    geoms of the soles' names, at sites of the same name; the site "imu" is the IMU,
    with sensors "gyro" and "accelerometer".
    A motor's gear is 1 and its range the effort limit.

    Args:
        robot: robot with a free-flyer root and joints of one degree of freedom.
        timestep: time step of the physics, s.
        friction: Coulomb coefficient of soles on ground. The contact is frictional in
            two directions; a sole resists twisting and rolling through the spread of
            its corners, so torsional and rolling friction stay off.
        ground: floor and terrain; the bare floor by default.
        shapes: the shapes of the robot beside its soles. They and the soles collide with the
            ground and with each other.
        excluded_pairs: pairs of joint names whose bodies do not collide with each other, beside
            those that are joined.
        cart: an object to push; its coordinate comes after the robot's.

    Raises:
        PlantError: a joint type or an inertia that MuJoCo cannot represent.
        MissingExtra: `mujoco` is not installed.
    """
    mujoco = import_mujoco()
    spec = mujoco.MjSpec()
    spec.modelname = robot.name
    spec.compiler.degree = False
    spec.compiler.autolimits = False
    spec.compiler.alignfree = False
    spec.option.timestep = timestep
    spec.option.gravity = robot.model.gravity.linear
    _set_options(mujoco, spec.option)
    surface = {"contype": _GROUND_BIT, "conaffinity": 0, **_surface(friction)}
    (ground or Ground(Flat())).add_to(mujoco, spec, surface)
    bodies = _add_bodies(mujoco, spec, robot.model)
    for sole in robot.soles:
        above = pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.5 * SOLE_THICKNESS]))
        placement = sole.placement * above
        bodies[sole.joint_id].add_geom(
            name=sole.name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=placement.translation,
            quat=_wxyz(placement.rotation),
            size=[
                max(sole.half_length, _LEAST_HALF_SIZE),
                max(sole.half_width, _LEAST_HALF_SIZE),
                0.5 * SOLE_THICKNESS,
            ],
            mass=0.0,
            **_robot_surface(friction),
        )
        _add_site(bodies[sole.joint_id], sole.name, sole.placement)
    for index, shape in enumerate(shapes):
        _add_shape(mujoco, spec, bodies[shape.joint_id], shape, index, friction)
    if cart is not None:
        cart.add_to(mujoco, spec, surface)
    for first, second in excluded_pairs:
        spec.add_exclude(bodyname1=first, bodyname2=second)
    imu = robot.model.frames[robot.frame_id(robot.imu)]
    _add_site(bodies[imu.parentJoint], "imu", imu.placement)
    for name, kind in (("gyro", "mjSENS_GYRO"), ("accelerometer", "mjSENS_ACCELEROMETER")):
        sensor = spec.add_sensor(name=name, objname="imu")
        sensor.type = getattr(mujoco.mjtSensor, kind)
        sensor.objtype = mujoco.mjtObj.mjOBJ_SITE
    for coupling in robot.couplings:
        _add_coupling(mujoco, spec, robot, coupling)
    for name, limit in zip(robot.joint_names, robot.tau_max, strict=True):
        motor = spec.add_actuator(name=name, target=name)
        motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
        motor.set_to_motor()
        if np.isfinite(limit):
            motor.ctrllimited = motor.forcelimited = True
            motor.ctrlrange = motor.forcerange = [-limit, limit]
    try:
        return spec.compile()
    except ValueError as error:
        raise PlantError(
            f"MuJoCo refuses the model of '{robot.name}': {error}; "
            "robot.check() names links with non-physical inertias and how to cure them"
        ) from error


def _set_options(mujoco: Any, option: Any) -> None:
    option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    flags = mujoco.mjtDisableBit
    # Left on, it answers a divergence by silently starting over.
    option.disableflags |= int(flags.mjDSBL_AUTORESET)
    # All constraints act on the one robot: no need to look for sets that do not interact.
    option.disableflags |= int(flags.mjDSBL_ISLAND)


def _surface(friction: float) -> dict[str, Any]:
    return {
        "condim": 3,
        "friction": [friction, 0.0, 0.0],
        "solref": list(_CONTACT_SOLREF),
    }


def _robot_surface(friction: float) -> dict[str, Any]:
    both = _GROUND_BIT | _ROBOT_BIT
    return {"contype": _ROBOT_BIT, "conaffinity": both, **_surface(friction)}


def _add_shape(
    mujoco: Any, spec: Any, body: Any, shape: CollisionShape, index: int, friction: float
) -> None:
    kinds = mujoco.mjtGeom
    attributes = {
        "name": f"{shape.link}_{index}",
        "type": {
            "box": kinds.mjGEOM_BOX,
            "sphere": kinds.mjGEOM_SPHERE,
            "cylinder": kinds.mjGEOM_CYLINDER,
            "capsule": kinds.mjGEOM_CAPSULE,
            "hull": kinds.mjGEOM_MESH,
        }[shape.kind],
        "pos": shape.placement.translation,
        "quat": _wxyz(shape.placement.rotation),
        "mass": 0.0,
        **_robot_surface(friction),
    }
    if shape.kind == "hull":
        attributes["meshname"] = spec.add_mesh(
            name=attributes["name"], uservert=shape.vertices.ravel()
        ).name
    else:
        attributes["size"] = [*shape.size, 0.0, 0.0][:3]
    body.add_geom(**attributes)


def _add_bodies(mujoco: Any, spec: Any, model: pin.Model) -> list[Any]:
    """Add one body per Pinocchio joint; return them by joint id."""
    if model.njoints < 2 or model.joints[1].nq != 7:
        raise PlantError("the robot's model has no free-flyer root: wbc.load() adds one")
    bodies = [spec.worldbody]
    axes = joint_axes(model)
    for i in range(1, model.njoints):
        placement = model.jointPlacements[i]
        body = bodies[model.parents[i]].add_body(
            name=model.names[i],
            pos=placement.translation,
            quat=_wxyz(placement.rotation),
        )
        bodies.append(body)
        _set_inertia(body, model.inertias[i])
        if i == 1:
            body.add_freejoint(name=model.names[i])
            continue
        if model.joints[i].nq != 1 or model.joints[i].nv != 1:
            raise PlantError(
                f"joint '{model.names[i]}' is a {model.joints[i].shortname()}: the plant knows "
                "revolute and prismatic joints; give a continuous joint limits in the URDF"
            )
        axis = axes[i]
        slides = bool(axis[:3] @ axis[:3] > 0.5)
        kind = mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE
        joint = body.add_joint(name=model.names[i], type=kind)
        joint.axis = axis[:3] if slides else axis[3:]
        joint.armature = model.armature[model.joints[i].idx_v]
        low = model.lowerPositionLimit[model.joints[i].idx_q]
        high = model.upperPositionLimit[model.joints[i].idx_q]
        if np.isfinite(low) and np.isfinite(high) and low < high:
            joint.limited = True
            joint.range = [low, high]
            joint.solref_limit = list(_STOP_SOLREF)
    return bodies


def _add_coupling(mujoco: Any, spec: Any, robot: Robot, coupling: Coupling) -> None:
    equality = spec.add_equality()
    equality.type = mujoco.mjtEq.mjEQ_JOINT
    equality.objtype = mujoco.mjtObj.mjOBJ_JOINT
    equality.name1 = robot.joint_names[coupling.joint]
    equality.name2 = robot.joint_names[coupling.leader]
    equality.data[:2] = [coupling.offset, coupling.ratio]
    equality.solref = list(_COUPLING_SOLREF)


def _set_inertia(body: Any, inertia: pin.Inertia) -> None:
    body.explicitinertial = True
    if inertia.mass <= 0.0:
        body.mass = _TINY_MASS
        body.inertia = [_TINY_INERTIA] * 3
        return
    body.mass = inertia.mass
    body.ipos = inertia.lever
    I = inertia.inertia  # noqa: E741
    body.fullinertia = [I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]]


def _add_site(body: Any, name: str, placement: pin.SE3) -> None:
    body.add_site(name=name, pos=placement.translation, quat=_wxyz(placement.rotation))


def _wxyz(rotation: np.ndarray) -> np.ndarray:
    x, y, z, w = pin.Quaternion(rotation).coeffs()
    return np.array([w, x, y, z])
