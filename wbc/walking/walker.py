"""The walker: gait, balance and whole-body controller put together."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from wbc.command import Command
from wbc.controller import WholeBodyController
from wbc.errors import GaitError
from wbc.estimation import Estimate
from wbc.gait import (
    DcmReference,
    Feet,
    GaitParameters,
    GaitStateMachine,
    Phase,
    Placement,
    Velocity,
)
from wbc.gait.footsteps import SIDES
from wbc.gait.leg_workspace import LegWorkspace
from wbc.gait.state_machine import PREVIEW_STEPS
from wbc.geometry.planar import ground_point, planar_rotation, wrap_angle
from wbc.kinematics import Kinematics
from wbc.qp import Solver
from wbc.robot import Robot
from wbc.state import State
from wbc.tasks import AngularMomentumTask, ComTask, PostureTask, Task
from wbc.telemetry import ContactPlan, Footstep, Telemetry
from wbc.walking.contact_manager import ContactManager, rotation_about_z
from wbc.walking.feet import foot_placements, sides_in_contact
from wbc.walking.gains import WalkerGains
from wbc.walking.reference_offset import ReferenceOffset
from wbc.walking.stabilizer import footstep_adjustment, zmp_from_dcm_error
from wbc.walking.support_polygon import SupportPolygon
from wbc.walking.trunk_tasks import TrunkTasks


class VelocityClamped(UserWarning):
    """The velocity command was beyond what the gait can do; the text says what it became."""


class Walker:
    """Walks: a velocity in, joint torques out, balance in between.

    Args:
        robot: the robot.
        dt: control period, s.
        gait: gait parameters; scaled to the robot when left out.
        gains: weights and gains of the tasks.
        solver: QP solver by name.

    Attributes:
        controller: the whole-body controller; add tasks of your own to it.
        posture: the posture task, for arms and head.
        state_machine: the gait's state machine.
        reference_offset: what a motion adds to the references of CoM and trunk; None: nothing.

    Raises:
        SolverNotFound: the solver is unknown or not installed.
    """

    def __init__(
        self,
        robot: Robot,
        dt: float = 0.002,
        *,
        gait: GaitParameters | None = None,
        gains: WalkerGains | None = None,
        solver: str | Solver | None = None,
    ) -> None:
        self.robot = robot
        self.dt = dt
        self._reach = LegWorkspace(robot)
        self.gait = gait or GaitParameters.for_robot(robot, self._reach)
        self.gains = gains = gains or WalkerGains()
        self.controller = controller = WholeBodyController(robot, dt, solver=solver)
        kp = gains.height_kp
        self.com = controller.add(
            ComTask(
                np.zeros(3),
                weight=gains.com_weight,
                kp=np.array([0.0, 0.0, kp]),
                kd=np.array([0.0, 0.0, 2.0 * np.sqrt(kp)]),
            )
        )
        self._kin = Kinematics(robot, robot.standing())
        self._trunk = TrunkTasks(controller, self._kin, gains)
        weights = np.full(robot.na, gains.posture_weight)
        for leg in robot.legs:
            weights[np.array(leg) - 6] = gains.leg_posture_weight
        weights[list(self._reach.knees)] = gains.knee_posture_weight
        self.posture = controller.add(PostureTask(robot, weight=weights, kp=gains.posture_kp))
        self.momentum = controller.add(AngularMomentumTask(weight=gains.momentum_weight))
        self._contact_manager = ContactManager(robot, controller, gains)
        self._support = SupportPolygon(robot)
        self.reference_offset: ReferenceOffset | None = None
        self._wanted = Velocity()
        self._queue: list[tuple[str, Placement]] = []
        self.reset(robot.standing())

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Wanted velocity in the heading frame: forward, left (m/s), turn left (rad/s).

        May be set at any tick. The present step goes over to it smoothly, less the nearer the
        foot is to the ground; the rest comes with the next step. Beyond the gait's limits it is
        clamped, with a `VelocityClamped` warning that says to what.
        """
        return (self._wanted.forward, self._wanted.left, self._wanted.turn)

    @velocity.setter
    def velocity(self, value: Sequence[float]) -> None:
        if len(value) != 3:
            raise GaitError(f"velocity {value!r} needs three numbers: forward, left, turn")
        wanted = Velocity(*(float(x) for x in value))
        self._wanted = wanted.clamped(self.gait)
        if self._wanted != wanted:
            got = self.velocity
            limits = self.gait.max_velocity
            warnings.warn(
                f"velocity ({wanted.forward:g} m/s, {wanted.left:g} m/s, {wanted.turn:g} rad/s) is "
                f"beyond what {self.robot.name} can do with this gait (±{limits[0]:.2f}, "
                f"±{limits[1]:.2f}, ±{limits[2]:.2f}): clamped to "
                f"({got[0]:.2f}, {got[1]:.2f}, {got[2]:.2f})",
                VelocityClamped,
                stacklevel=2,
            )

    def change_gait(self, gait: GaitParameters) -> None:
        """Go on with other gait parameters, at any tick; the wanted velocity is kept within them.

        The present step keeps its duration; everything planned from now on has the new ones.
        """
        self.gait = gait
        self.state_machine.change_gait(gait)
        self._wanted = self._wanted.clamped(gait)

    @property
    def tasks(self) -> tuple[Task, ...]:
        """Its own tasks, the swing feet's included: gains and weights may be set at any tick."""
        return (
            self.com,
            *self._trunk.tasks,
            self.posture,
            self.momentum,
            *self._contact_manager.swing_tasks,
        )

    def follow(self, footsteps: Sequence[Footstep]) -> None:
        """Walk over given footsteps, alternating sides, then stop.

        Raises:
            GaitError: an unknown side, or two steps of the same side in a row.
        """
        queue = []
        for k, step in enumerate(footsteps):
            if step.side not in SIDES:
                raise GaitError(f"footstep {k}: side '{step.side}' is neither 'left' nor 'right'")
            if k and step.side == footsteps[k - 1].side:
                raise GaitError(
                    f"footsteps {k - 1} and {k} are both '{step.side}': sides must alternate"
                )
            placement = Placement(ground_point(step.position), step.yaw, float(step.position[2]))
            queue.append((step.side, placement))
        self._queue[:] = queue

    def halt(self) -> None:
        """Stop walking soon: the steps that the plan of now counts on are still made."""
        self._wanted = Velocity()
        del self._queue[PREVIEW_STEPS - 1 :]

    def reset(self, state: State) -> None:
        """Start anew, standing, from a state with both soles on the ground.

        What is wanted of it stays: the velocity, and footsteps given by `follow`.

        Raises:
            StateError: see `State.checked`.
        """
        self._kin.update(state)
        feet = foot_placements(self._kin)
        self.state_machine = GaitStateMachine(self.gait, feet, self._queue)
        self._ground = 0.5 * (feet.left.height + feet.right.height)
        self._heading = feet.left.yaw + 0.5 * wrap_angle(feet.right.yaw - feet.left.yaw)
        self._height_now = float(self._kin.p_com[2]) - self._ground
        self._dcm = self._zmp = ground_point(self._kin.p_com)
        self._reference = DcmReference(self._dcm, 0j, self._zmp)
        self.posture.target = state.q[7:].copy()

    def step(self, estimate: Estimate) -> Command:
        """One tick.

        Args:
            estimate: state and contacts; without foot sensors contact goes by time.

        Raises:
            StateError: see `State.checked`.
        """
        kin = self._kin
        kin.update(estimate.state)
        feet = foot_placements(kin)
        state_machine = self.state_machine
        if self.reference_offset is not None:
            state_machine.weight_shift = self.reference_offset.weight_shift
        state_machine.update(self.dt, feet, self._wanted, sides_in_contact(self.robot, estimate))
        self._balance(kin, feet)
        self._keep_upright(feet)
        self._contact_manager.update(state_machine)
        return self.controller.solve(kin)

    def _balance(self, kin: Kinematics, feet: Feet) -> None:
        gait, gains, state_machine = self.gait, self.gains, self.state_machine
        omega = gait.omega
        c, v = kin.p_com, kin.v_com
        com = ground_point(c)
        self._dcm = com + ground_point(v) / omega
        if self.reference_offset is not None:
            # The QP goes on with the CoM as estimated: so it puts the ZMP where it is wanted.
            self._dcm -= self.reference_offset.com_bias * planar_rotation(self._heading)
        self._reference = self._plan(feet)
        if self.reference_offset is not None:
            standing = state_machine.phase is Phase.STAND or state_machine.lifted is not None
            self._reference = self.reference_offset.apply(
                self._reference, omega, self._heading, feet, standing
            )
        zmp = zmp_from_dcm_error(self._dcm, self._reference, omega, gait.dcm_gain)
        self._zmp = self._support.clamped(zmp, state_machine, feet, gains.zmp_margin)
        push = omega * omega * (com - self._zmp)
        self.com.acceleration[0], self.com.acceleration[1] = push.real, push.imag
        ground = self._support.height(state_machine, feet)
        blend = min(self.dt / gains.ground_time, 1.0)
        self._ground += blend * (ground - self._ground)
        height = min(gait.com_height, self._reach.com_height(self._step_length()))
        self._height_now += 0.25 * blend * (height - self._height_now)
        assert self.com.target is not None
        self.com.target[2] = self._ground + self._height_now
        if self.reference_offset is not None:
            self.com.target[2] += self.reference_offset.com[2]
            self.com.velocity[2] = self.reference_offset.com_velocity[2]
            self.com.acceleration[2] = self.reference_offset.com_acceleration[2]

    def _plan(self, feet: Feet) -> DcmReference:
        """The DCM's plan; its landing place moves when the ankles alone cannot catch the DCM."""
        state_machine, omega = self.state_machine, self.gait.omega
        if state_machine.swing is None or state_machine.swing.target_frozen:
            return state_machine.reference()
        planned = state_machine.planned_reference()
        error = (self._dcm - planned.dcm) * planar_rotation(-feet.of(state_machine.support).yaw)
        reach = self._support.reach(state_machine, self.gains.ankle_share)
        state_machine.landing.adjustment = footstep_adjustment(
            error, omega, state_machine.remaining, reach
        )
        return state_machine.reference() if state_machine.landing.adjustment else planned

    def _step_length(self) -> float:
        """Length of the steps of now, m: how far a foot is left behind."""
        if self.state_machine.phase is Phase.STAND:
            return 0.0
        velocity = self.state_machine.velocity
        return math.hypot(velocity.forward, velocity.left) * self.gait.step_duration

    def _keep_upright(self, feet: Feet) -> None:
        state_machine = self.state_machine
        left, right = feet.left.yaw, feet.right.yaw
        rate = 0.0
        if state_machine.swing is not None:
            rate = 0.5 * state_machine.swing.yaw_rate
            if state_machine.swing_side == "left":
                left = state_machine.swing.yaw
            else:
                right = state_machine.swing.yaw
        self._heading = left + 0.5 * wrap_angle(right - left)
        self._trunk.update(self._heading, rate, self.reference_offset)

    @property
    def telemetry(self) -> Telemetry:
        """What the walker sees and intends after the last tick, for observers."""
        state_machine, z = self.state_machine, self._ground
        dcm, reference, zmp = self._dcm, self._reference.dcm, self._zmp
        rows = np.array(
            (
                (dcm.real, dcm.imag, z),
                (reference.real, reference.imag, z),
                (zmp.real, zmp.imag, z),
                self.velocity,
            )
        )
        swings = state_machine.phase is Phase.SWING
        return Telemetry(
            self._kin.p_com.copy(),
            rows[0],
            rows[1],
            rows[2],
            rows[3],
            self._heading,
            abs(dcm - reference),
            state_machine.support if swings else state_machine.phase.value,
            state_machine.steps,
        )

    @property
    def contact_plan(self) -> ContactPlan:
        """Where the robot stands and will step; computed anew at each call."""
        state_machine = self.state_machine
        support = self._support.polygon(state_machine, foot_placements(self._kin))
        swing = state_machine.swing
        return ContactPlan(
            support=np.array([[p.real, p.imag, self._ground] for p in support]),
            footsteps=tuple(
                Footstep(side, np.array([p.point.real, p.point.imag, p.height]), p.yaw)
                for side, p in state_machine.preview()
            ),
            swing_path=np.array(swing.path()) if swing is not None else np.empty((0, 3)),
        )

    @property
    def kinematics(self) -> Kinematics:
        """Of the last tick."""
        return self._kin

    @property
    def heading(self) -> float:
        """Mean heading of the soles, rad."""
        return self._heading

    @property
    def feet(self) -> Feet:
        """Both soles as they were at the last tick."""
        return foot_placements(self._kin)

    @property
    def standing_frame(self) -> pin.SE3:
        """`T_world_standing`: on the ground midway between the soles, x along their heading."""
        feet = foot_placements(self._kin)
        middle = feet.middle
        height = 0.5 * (feet.left.height + feet.right.height)
        return pin.SE3(
            rotation_about_z(self._heading), np.array([middle.real, middle.imag, height])
        )

    @property
    def height(self) -> float:
        """Of the CoM over the ground as the gait wants it now, m."""
        return self._height_now

    @property
    def steps(self) -> int:
        """Touchdowns since the reset."""
        return self.state_machine.steps

    @property
    def dcm_error(self) -> float:
        """Distance of the DCM from its reference after the last tick, m."""
        return abs(self._dcm - self._reference.dcm)
