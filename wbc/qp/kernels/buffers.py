"""The memory of one structure of the QP: its sizes, its groups and how kernels read them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from wbc.qp.kernels import groups
from wbc.qp.kernels.schema import Memory, reader

_GROUPS: tuple[type, ...] = (
    groups.Tree,
    groups.Frames,
    groups.MotionTasks,
    groups.JointTasks,
    groups.Contacts,
    groups.DenseRows,
    groups.JointBounds,
    groups.Inequalities,
    groups.AffineMaps,
    groups.QuadraticProgram,
)


@dataclass(frozen=True)
class Sizes:
    """The lengths of all axes, for one structure of the QP.

    Attributes:
        joints: actuated joints, na.
        forces: contact force components, nf.
        unknowns: number of unknowns of the QP, n.
        frames: frames that tasks and contacts refer to, the centroid among them.
        motion_tasks: tasks on components of a frame's motion.
        joint_rows: rows of weighted tasks on single joints.
        contacts: contacts.
        cone_rows: rows of all contacts' force cones.
        dense_rows: rows of dense tasks and of contacts that are not eliminated.
        cost_rows: how many of them are in the cost.
        residual_rows: rows of the cost's residual, a multiple of three.
        bounds: limits on joint accelerations.
        limited_torques: joints whose torque is limited.
        limit_rows: rows of general limits.
        stance_joints: joints that move the eliminated contact.
        dense_columns: columns of the base's map that may differ from zero.
        constraint_rows: rows of C.
    """

    joints: int
    forces: int
    unknowns: int
    frames: int
    motion_tasks: int
    joint_rows: int
    contacts: int
    cone_rows: int
    dense_rows: int
    cost_rows: int
    residual_rows: int
    bounds: int
    limited_torques: int
    limit_rows: int
    stance_joints: int
    dense_columns: int
    constraint_rows: int

    @cached_property
    def bodies(self) -> int:
        """The base and one body per joint."""
        return self.joints + 1

    @cached_property
    def velocities(self) -> int:
        """Size of the generalised velocity, nv."""
        return self.joints + 6

    @cached_property
    def affine(self) -> int:
        """Size of x̂ = (x, 1)."""
        return self.unknowns + 1

    @cached_property
    def bound_rows(self) -> int:
        """Size of lb and ub."""
        return self.joints + self.constraint_rows


class Buffers:
    """All groups of one structure of the QP.

    Args:
        sizes: lengths of all axes.

    Attributes:
        arrays: see `Memory`.
    """

    def __init__(self, sizes: Sizes) -> None:
        memory = Memory(_GROUPS, sizes)
        self.arrays = memory.arrays
        self.tree = memory.group(groups.Tree)
        self.frames = memory.group(groups.Frames)
        self.motion_tasks = memory.group(groups.MotionTasks)
        self.joint_tasks = memory.group(groups.JointTasks)
        self.contacts = memory.group(groups.Contacts)
        self.rows = memory.group(groups.DenseRows)
        self.bounds = memory.group(groups.JointBounds)
        self.inequalities = memory.group(groups.Inequalities)
        self.maps = memory.group(groups.AffineMaps)
        self.program = memory.group(groups.QuadraticProgram)


read_tree = reader(_GROUPS, groups.Tree)
read_frames = reader(_GROUPS, groups.Frames)
read_motion_tasks = reader(_GROUPS, groups.MotionTasks)
read_joint_tasks = reader(_GROUPS, groups.JointTasks)
read_contacts = reader(_GROUPS, groups.Contacts)
read_rows = reader(_GROUPS, groups.DenseRows)
read_bounds = reader(_GROUPS, groups.JointBounds)
read_inequalities = reader(_GROUPS, groups.Inequalities)
read_maps = reader(_GROUPS, groups.AffineMaps)
read_program = reader(_GROUPS, groups.QuadraticProgram)
