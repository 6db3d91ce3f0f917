"""What the kernels work on: arrays in named groups, made once per structure of the QP.

Shapes: nb bodies (the base and one per joint), nv velocities, na = nv − 6 joints, n unknowns, nf
contact force components; k frames, t tasks, c contacts, j wishes for single joints, l limits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Tree(NamedTuple):
    """The robot's joints, and where gravity pulls.

    Attributes:
        parent: (nb,) body before each body; body 0 is the base, body i moves by joint i − 1.
        gravity: (3,) m/s².
        velocity: (nb, 6) work: spatial velocity at the world's origin, world axes.
        bias: (nb, 6) work: spatial acceleration at zero generalised acceleration.
    """

    parent: np.ndarray
    gravity: np.ndarray
    velocity: np.ndarray
    bias: np.ndarray


class Frames(NamedTuple):
    """Motions that tasks and contacts refer to. Entry 0 is the centroid: CoM, angular momentum.

    Attributes:
        body: (k,) body that carries the frame.
        placement: (k, 4, 4) in the world; that of entry 0 is the base's, then the CoM's.
        J: (k, 6, nv) world axes.
        velocity: (k, 6).
        bias: (k, 6) J̇ v.
    """

    body: np.ndarray
    placement: np.ndarray
    J: np.ndarray
    velocity: np.ndarray
    bias: np.ndarray


class Tasks(NamedTuple):
    """Tasks that select components of a frame's motion.

    Attributes:
        place: (t, 4) frame, first component, number of components, first row.
        target: (t, 4, 4) pose.
        reference: (t, 12) velocity, acceleration.
        gain: (t, 12) kp, kd, one per component.
    """

    place: np.ndarray
    target: np.ndarray
    reference: np.ndarray
    gain: np.ndarray


class Wishes(NamedTuple):
    """Wishes for single joint accelerations.

    Attributes:
        joint: (j,).
        target: (j,) rad.
        reference: (2, j) velocity, acceleration.
        gain: (3, j) kp, kd, weight.
    """

    joint: np.ndarray
    target: np.ndarray
    reference: np.ndarray
    gain: np.ndarray


class Contacts(NamedTuple):
    """Contacts; the eliminated one first.

    Attributes:
        place: (c, 5) frame (0: its rows are written already), first row in J, number of rows,
            first row of its motion among the rows (−1: eliminated), rows of its cone.
        number: (c, 3) damping, least and largest normal force.
        cone: (c, 16, 6).
        J: (nf, nv) contact axes.
        a: (nf,).
    """

    place: np.ndarray
    number: np.ndarray
    cone: np.ndarray
    J: np.ndarray
    a: np.ndarray


class Rows(NamedTuple):
    """`A v̇ = b` of dense tasks and of contacts that are not eliminated; those of the cost first.

    Attributes:
        cost: (1,) how many are the cost's.
        A: (r, nv).
        b: (r,).
        root: (r,) root of the weight; unused behind the cost's.
    """

    cost: np.ndarray
    A: np.ndarray
    b: np.ndarray
    root: np.ndarray


class Limits(NamedTuple):
    """Limits on joint accelerations, and torques.

    Attributes:
        kind: (l,) 0 accelerations as they stand, 1 positions, 2 velocities.
        number: (l, 2) horizon, recovery.
        joint: (l, 3, na) lower, upper, braking; velocities have no lower.
        torque: (na,), or empty.
    """

    kind: np.ndarray
    number: np.ndarray
    joint: np.ndarray
    torque: np.ndarray


class Maps(NamedTuple):
    """The elimination, see `wbc.qp.elimination`: base, forces and torques as `· x̂`.

    Attributes:
        stance: (i,) joints that move the eliminated contact, empty when there is none.
        dense: (d,) columns in which B may differ from zero.
        B: (6, n + 1).
        W: (nf, n + 1).
        T: (na, n + 1).
        S: (6, n + 1) work: forces on the base.
    """

    stance: np.ndarray
    dense: np.ndarray
    B: np.ndarray
    W: np.ndarray
    T: np.ndarray
    S: np.ndarray


class Program(NamedTuple):
    """The quadratic program, see `wbc.qp.problem`.

    Attributes:
        G: (rg, n + 1) weighted residuals of the cost, its rows then the eliminated forces;
            some rows at the end stay empty, to make their number a multiple of three.
        H, g, C, lb, ub: the program.
        small: (n,) added to H's diagonal.
    """

    G: np.ndarray
    H: np.ndarray
    g: np.ndarray
    C: np.ndarray
    lb: np.ndarray
    ub: np.ndarray
    small: np.ndarray
