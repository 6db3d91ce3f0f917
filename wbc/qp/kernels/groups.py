"""What the kernels work on: arrays in named groups, made once per structure of the QP."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from wbc.qp.kernels.schema import integers, reals


class Tree(NamedTuple):
    """The robot's kinematic tree.

    Attributes:
        parent: body before each body; body 0 is the base, body i moves by joint i − 1.
        gravity: m/s², world axes.
        velocity: work: spatial velocity at the world's origin, world axes.
        bias: work: spatial acceleration at zero generalised acceleration.
    """

    parent: Annotated[np.ndarray, integers("bodies")]
    gravity: Annotated[np.ndarray, reals(3)]
    velocity: Annotated[np.ndarray, reals("bodies", 6)]
    bias: Annotated[np.ndarray, reals("bodies", 6)]


class Frames(NamedTuple):
    """Motions that tasks and contacts refer to. Entry 0 is the centroid: CoM, angular momentum.

    Attributes:
        body: body that carries the frame.
        in_body: placement of the frame in the axes of its body's joint.
        placement: `T_world_frame`; that of entry 0 is the base's, then the CoM's.
        jacobian: world axes.
        velocity: m/s, rad/s; world axes.
        bias: J̇ v.
    """

    body: Annotated[np.ndarray, integers("frames")]
    in_body: Annotated[np.ndarray, reals("frames", 4, 4)]
    placement: Annotated[np.ndarray, reals("frames", 4, 4)]
    jacobian: Annotated[np.ndarray, reals("frames", 6, "velocities")]
    velocity: Annotated[np.ndarray, reals("frames", 6)]
    bias: Annotated[np.ndarray, reals("frames", 6)]


class MotionTasks(NamedTuple):
    """Tasks that select components of a frame's motion.

    Attributes:
        frame: index into `Frames`.
        component: first component of the motion.
        size: number of components.
        row: first row in `DenseRows`.
        target: pose.
        velocity: reference velocity.
        acceleration: feed-forward.
        kp: 1/s², one per component.
        kd: 1/s, one per component.
    """

    frame: Annotated[np.ndarray, integers("motion_tasks")]
    component: Annotated[np.ndarray, integers("motion_tasks")]
    size: Annotated[np.ndarray, integers("motion_tasks")]
    row: Annotated[np.ndarray, integers("motion_tasks")]
    target: Annotated[np.ndarray, reals("motion_tasks", 4, 4)]
    velocity: Annotated[np.ndarray, reals("motion_tasks", 6)]
    acceleration: Annotated[np.ndarray, reals("motion_tasks", 6)]
    kp: Annotated[np.ndarray, reals("motion_tasks", 6)]
    kd: Annotated[np.ndarray, reals("motion_tasks", 6)]


class JointTasks(NamedTuple):
    """Weighted tasks on single joints.

    Attributes:
        joint: index of the joint.
        target: rad.
        velocity: reference velocity, rad/s.
        acceleration: feed-forward, rad/s².
        kp: 1/s².
        kd: 1/s.
        weight: weight in the cost.
    """

    joint: Annotated[np.ndarray, integers("joint_rows")]
    target: Annotated[np.ndarray, reals("joint_rows")]
    velocity: Annotated[np.ndarray, reals("joint_rows")]
    acceleration: Annotated[np.ndarray, reals("joint_rows")]
    kp: Annotated[np.ndarray, reals("joint_rows")]
    kd: Annotated[np.ndarray, reals("joint_rows")]
    weight: Annotated[np.ndarray, reals("joint_rows")]


class Contacts(NamedTuple):
    """Contacts; the eliminated one first.

    Attributes:
        frame: index into `Frames`; 0 when the contact writes its rows itself.
        force: first row of its force components in `jacobian`.
        size: number of its force components.
        row: first row of its motion in `DenseRows`; −1 when it is eliminated.
        cone_row: first row of its cone.
        cone_size: number of rows of its cone.
        damping: 1/s.
        min_force: least normal force, N.
        max_force: largest normal force, N.
        cone: rows of `cone f ≤ 0`.
        jacobian: contact axes.
        acceleration: what the contact's frame is to do, contact axes, m/s² and rad/s².
    """

    frame: Annotated[np.ndarray, integers("contacts")]
    force: Annotated[np.ndarray, integers("contacts")]
    size: Annotated[np.ndarray, integers("contacts")]
    row: Annotated[np.ndarray, integers("contacts")]
    cone_row: Annotated[np.ndarray, integers("contacts")]
    cone_size: Annotated[np.ndarray, integers("contacts")]
    damping: Annotated[np.ndarray, reals("contacts")]
    min_force: Annotated[np.ndarray, reals("contacts")]
    max_force: Annotated[np.ndarray, reals("contacts")]
    cone: Annotated[np.ndarray, reals("cone_rows", 6)]
    jacobian: Annotated[np.ndarray, reals("forces", "velocities")]
    acceleration: Annotated[np.ndarray, reals("forces")]


class DenseRows(NamedTuple):
    """`A v̇ = b` of dense tasks and of contacts that are not eliminated; those of the cost first.

    Attributes:
        A: rows.
        b: right side.
        root_weight: square root of the weight of the cost's rows.
    """

    A: Annotated[np.ndarray, reals("dense_rows", "velocities")]
    b: Annotated[np.ndarray, reals("dense_rows")]
    root_weight: Annotated[np.ndarray, reals("cost_rows")]


class JointBounds(NamedTuple):
    """Limits on joint accelerations, and on torques.

    Attributes:
        kind: what the bounds follow from, see `wbc.qp.parameter_update`.
        horizon: s.
        recovery: s.
        lower: rad/s², or rad for positions; not used for velocities.
        upper: rad/s², rad, or rad/s for velocities.
        braking: rad/s²; not used for accelerations.
        torque: N·m.
    """

    kind: Annotated[np.ndarray, integers("bounds")]
    horizon: Annotated[np.ndarray, reals("bounds")]
    recovery: Annotated[np.ndarray, reals("bounds")]
    lower: Annotated[np.ndarray, reals("bounds", "joints")]
    upper: Annotated[np.ndarray, reals("bounds", "joints")]
    braking: Annotated[np.ndarray, reals("bounds", "joints")]
    torque: Annotated[np.ndarray, reals("limited_torques")]


class Inequalities(NamedTuple):
    """General limits, `lower ≤ A v̇ + F f ≤ upper`.

    Attributes:
        A: coefficients of the accelerations.
        F: coefficients of the contact forces.
        lower: least value.
        upper: largest value.
    """

    A: Annotated[np.ndarray, reals("limit_rows", "velocities")]
    F: Annotated[np.ndarray, reals("limit_rows", "forces")]
    lower: Annotated[np.ndarray, reals("limit_rows")]
    upper: Annotated[np.ndarray, reals("limit_rows")]


class AffineMaps(NamedTuple):
    """The elimination, see `wbc.qp.elimination`: base, forces and torques as `· x̂`.

    Attributes:
        stance_joints: joints that move the eliminated contact; none when there is none.
        dense_columns: columns in which B may differ from zero.
        B: base acceleration, base axes.
        W: contact forces.
        T: joint torques.
        base_force: work: forces on the base.
    """

    stance_joints: Annotated[np.ndarray, integers("stance_joints")]
    dense_columns: Annotated[np.ndarray, integers("dense_columns")]
    B: Annotated[np.ndarray, reals(6, "affine")]
    W: Annotated[np.ndarray, reals("forces", "affine")]
    T: Annotated[np.ndarray, reals("joints", "affine")]
    base_force: Annotated[np.ndarray, reals(6, "affine")]


class QuadraticProgram(NamedTuple):
    """The quadratic program, see `wbc.qp.problem`.

    Attributes:
        G: weighted residuals of the cost, its rows then the eliminated forces; some rows at the
            end stay empty, to make their number a multiple of three.
        H: see `Problem`.
        g: see `Problem`.
        C: see `Problem`.
        lb: see `Problem`.
        ub: see `Problem`.
        regularisation: added to H's diagonal.
        x: the solution, copied here.
    """

    G: Annotated[np.ndarray, reals("residual_rows", "affine")]
    H: Annotated[np.ndarray, reals("unknowns", "unknowns")]
    g: Annotated[np.ndarray, reals("unknowns")]
    C: Annotated[np.ndarray, reals("constraint_rows", "unknowns")]
    lb: Annotated[np.ndarray, reals("bound_rows")]
    ub: Annotated[np.ndarray, reals("bound_rows")]
    regularisation: Annotated[np.ndarray, reals("unknowns")]
    x: Annotated[np.ndarray, reals("unknowns")]
