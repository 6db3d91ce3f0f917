"""The walker: gait, stabilizer and whole-body controller put together."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from wbc.command import Command
from wbc.controller import WholeBodyController
from wbc.estimation import Estimate
from wbc.gait import (
    DcmReference,
    Feet,
    GaitCommand,
    GaitParameters,
    GaitState,
    GaitStateMachine,
    Placement,
    Planner,
    Velocity,
)
from wbc.gait.footsteps import SIDES, lateral_sign
from wbc.gait.leg_workspace import LegWorkspace
from wbc.gait.planners import PREVIEW_STEPS, resolve_planner
from wbc.gait.speed_adaptation import SpeedAdaptation
from wbc.geometry.planar import rotation_about_z
from wbc.kinematics import Kinematics
from wbc.qp import Solver
from wbc.robot import Robot, checked_robot
from wbc.robot.posture import has_soles
from wbc.state import State
from wbc.tasks import Task
from wbc.telemetry import ContactPlan, Footstep, Telemetry
from wbc.walking.balance_tasks import BalanceTasks, mean_heading
from wbc.walking.command_checks import clamp_velocity, parse_footsteps, parse_velocity
from wbc.walking.contact_manager import ContactManager
from wbc.walking.falling import FallController, FallDetector
from wbc.walking.feet import ground_reaction, sides_in_contact
from wbc.walking.gains import WalkerGains
from wbc.walking.ground_kinematics import GroundKinematics
from wbc.walking.ground_slope import GroundSlope
from wbc.walking.hand_contacts import HandContacts
from wbc.walking.knocked_foot import KnockedFoot
from wbc.walking.reference_offset import ReferenceOffset
from wbc.walking.stabilizer import Stabilizer, StabilizerOutput
from wbc.walking.swing_momentum import SwingMomentum
from wbc.walking.walker_telemetry import (
    falling_telemetry,
    planned_contacts,
    walking_telemetry,
)

_IN_PLACE = Velocity(forward=1e-9)  # m/s, of a robot that has to step to stay


class Walker:
    """Walks on two legs: a velocity in, joint torques out, balance in between.

    A robot with point feet cannot stand still: without a velocity it steps in place.

    Args:
        robot: the robot.
        dt: control period, s.
        gait: gait parameters; scaled to the robot when left out.
        recovery_gait: parameters of the quick steps that catch a push; scaled to the robot and
            its gait when left out. The gait itself means no quick steps.
        gains: weights and gains of the tasks; scaled to the robot when left out.
        planner: plans footsteps and DCM: a name for `wbc.gait.make_planner`, or an object of one's
            own; the analytic `DcmPlanner` when left out.
        solver: QP solver, by name or as an object.

    Attributes:
        controller: the whole-body controller; add tasks of your own to it.
        com: the task of the centre of mass.
        posture: the posture task, for arms and head.
        planner: plans footsteps and DCM.
        stabilizer: DCM feedback, step adjustment, bias of the CoM.
        state_machine: phases of the gait.
        reference_offset: offset that a motion adds to CoM and trunk; None for none.
        hand_contacts: hands that push against the environment, or carry something.

    Raises:
        SolverNotFound: the solver is unknown or not installed.
        PlannerNotFound: the planner is unknown.
    """

    def __init__(
        self,
        robot: Robot,
        dt: float = 0.002,
        *,
        gait: GaitParameters | None = None,
        recovery_gait: GaitParameters | None = None,
        gains: WalkerGains | None = None,
        planner: str | Planner | None = None,
        solver: str | Solver | None = None,
    ) -> None:
        self.robot = checked_robot(robot, "Walker")
        self.dt = dt
        self._workspace = workspace = LegWorkspace(robot)
        self.gait = gait or GaitParameters.for_robot(robot)
        self._scales_recovery = recovery_gait is None
        self.recovery_gait = recovery_gait or GaitParameters.for_recovery(robot, self.gait)
        self.gains = gains = gains or WalkerGains.for_robot(robot)
        self.controller = controller = WholeBodyController(robot, dt, solver=solver)
        self._kin = Kinematics(robot, robot.standing())
        self._ground = GroundKinematics(robot, self._kin)
        self._ground_slope = GroundSlope(dt)
        self._tasks = BalanceTasks(controller, self._kin, workspace, gains, dt)
        self.com, self.posture = self._tasks.com, self._tasks.posture
        self.hand_contacts = HandContacts(robot)
        self._contact_manager = ContactManager(robot, controller, gains, self.hand_contacts)
        self.stabilizer = Stabilizer(robot, gains, dt)
        self.planner = resolve_planner(planner, robot)
        self._swing_momentum = SwingMomentum(robot)
        self._knocked_foot = KnockedFoot(
            robot,
            self._contact_manager.swing_tasks,
            self.stabilizer.push_recovery.foot_acceleration,
        )
        self.reference_offset: ReferenceOffset | None = None
        self._take_off_speed = gains.hop_speed * math.sqrt(robot.gravity * robot.com_height)
        self._fall_detector = FallDetector(robot, dt)
        self._fall_controller = FallController(robot, dt, workspace.knees)
        self._falling_why = ""
        self._rest = Velocity() if has_soles(robot.soles) else _IN_PLACE
        self._command = GaitCommand(self._rest)
        self.reset(robot.standing())

    def __repr__(self) -> str:
        state, velocity = self.gait_state, self._command.velocity
        return (
            f"Walker({self.robot.name}, {type(self.planner).__name__}, "
            f"phase {state.phase.name}, support {state.support}, {state.steps} steps, "
            f"velocity ({velocity.forward:g} m/s, {velocity.left:g} m/s, "
            f"{velocity.turn:g} rad/s), dt {self.dt:g} s)"
        )

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Wanted velocity in the heading frame: forward, left (m/s), turn left (rad/s).

        May be set at any tick. The present step goes over to it smoothly, less the nearer the
        foot is to the ground; the rest comes with the next step. Beyond the gait's limits it is
        clamped, with a `VelocityClamped` warning that says to what.

        Raises:
            GaitError: it is not three finite numbers.
        """
        velocity = self._command.velocity
        if velocity is _IN_PLACE:
            return (0.0, 0.0, 0.0)
        return (velocity.forward, velocity.left, velocity.turn)

    @velocity.setter
    def velocity(self, value: Sequence[float]) -> None:
        wanted = parse_velocity(value)
        if wanted.is_zero:
            wanted = self._rest
        if wanted is _IN_PLACE:
            self._command.velocity = wanted
            return
        self._command.velocity = clamp_velocity(wanted, self.gait.max_velocity, self.robot.name)

    def change_gait(self, gait: GaitParameters) -> None:
        """Go on with other gait parameters, at any tick; the wanted velocity is kept within them.

        The present step keeps its duration; everything planned from now on has the new ones.

        Args:
            gait: parameters at usual speeds; faster steps are adapted from them.
        """
        if self._scales_recovery:
            self.recovery_gait = GaitParameters.for_recovery(self.robot, gait)
        elif self.recovery_gait is self.gait:  # no quick steps
            self.recovery_gait = gait
        self.gait = gait
        self.state_machine.change_gait(gait, self.recovery_gait)
        self._command.velocity = self._command.velocity.clamped(gait)

    @property
    def tasks(self) -> tuple[Task, ...]:
        """Its own tasks, the swing feet's included: gains and weights may be set at any tick."""
        return (*self._tasks.tasks, *self._contact_manager.swing_tasks)

    def follow(self, footsteps: Sequence[Footstep]) -> None:
        """Walk over given footsteps, alternating sides, then stop.

        Raises:
            GaitError: an unknown side, two steps of the same side in a row, a number that is
                not finite, or a step beyond the reach of the one before it.
        """
        self._command.footsteps[:] = parse_footsteps(footsteps, self.gait_state)

    def halt(self) -> None:
        """Stop walking soon: the steps that the present plan counts on are still made."""
        self._command.velocity = self._rest
        del self._command.footsteps[PREVIEW_STEPS - 1 :]

    def reset(self, state: State) -> None:
        """Start anew, standing, from a state with both soles on the ground.

        What is wanted of it stays: the velocity, and footsteps given by `follow`. Only this ends
        the state of falling.

        Raises:
            StateError: see `State.validated`.
        """
        self.stabilizer.reset()
        self._fall_detector.reset()
        self._fall_controller.reset()
        self._falling_why = ""
        self.resume(state)

    def resume(self, state: State) -> None:
        """Take over from another controller: `reset`, but for what the stabilizer has learned.

        Raises:
            StateError: see `State.validated`.
        """
        self._kin.update(state)
        self.stabilizer.resume()
        feet, com = self._ground.read()
        adaptation = SpeedAdaptation(self.gait, self._workspace)
        self.state_machine = GaitStateMachine(
            self.gait, feet, self.planner, self.recovery_gait, adaptation
        )
        self._ground_slope.reset()
        self.hand_contacts.clear()
        ground = 0.5 * (feet.left.height + feet.right.height)
        self._tasks.height.reset(ground, com.height)
        self._heading = mean_heading(self.gait_state)
        at_rest = DcmReference(com.point, 0j, com.point)
        landing = self.gait_state.landing
        self._balance = StabilizerOutput(at_rest.dcm, at_rest, at_rest.zmp, 0j, landing)
        self.posture.target = state.q[7:].copy()

    def step(self, estimate: Estimate) -> Command:
        """One tick.

        When a fall is unavoidable (see `FallDetector`), the walker gives up walking, standing and
        everything else: from then on, until `reset`, its joints only yield (`FallController`).

        Args:
            estimate: state, contacts and foot wrenches; without foot sensors, contact goes by
                time.

        Raises:
            StateError: see `State.validated`.
        """
        kin, ground, dt = self._kin, self._ground, self.dt
        kin.update(estimate.state)
        if self._falling_why:
            return self._fall_controller.command(estimate.state)
        feet, com = ground.read()
        machine, stabilizer = self.state_machine, self.stabilizer
        state = machine.state
        if self.reference_offset is not None:
            state.weight_shift = self.reference_offset.weight_shift
        wrenches = estimate.foot_wrenches
        reaction = ground_reaction(self.robot, feet, wrenches) if state.at_rest else None
        state.ground_slope = self._ground_slope.update(state, ground.slopes)
        state.lift_off_slope = ground.slopes[SIDES.index(state.swing_side)]
        hands = self.hand_contacts
        if hands.contacts:
            hands.update(kin, 0.5 * (feet.left.height + feet.right.height))
            if not hands.known:
                reaction = None
        stabilizer.support.extension = hands.extension
        stabilizer.observe(state, com, reaction, self._heading, hands.offset)
        tilt = ground.tilt
        self._falling_why = self._fall_detector.update(
            tilt, state.dcm, com.height, ground.base, (feet.left, feet.right)
        )
        if self._falling_why:
            return self._fall_controller.command(estimate.state)
        contacts = sides_in_contact(self.robot, estimate)
        if not hands.contacts and stabilizer.has_to_hop(state, contacts, tilt[0]):
            machine.hop(self._take_off_speed)
        machine.update(dt, feet, self._command, contacts)
        self._knocked_foot.update(state, kin, ground.speeds, contacts)
        balance = self._balance = stabilizer.update(state, self._reference)
        machine.move_swing(dt, balance.landing)
        self._heading = mean_heading(state)
        step_length, offset = machine.step_length, self.reference_offset
        self._tasks.update(state, balance.com_acceleration, self._heading, step_length, offset)
        self._contact_manager.update(state, contacts, ground.speeds)
        return self.controller.solve(kin)

    def _reference(self, landing: Placement | None) -> DcmReference:
        """The planner's reference for a landing place, with what swing leg and motion add."""
        state, planner = self.state_machine.state, self.planner
        offset = self.reference_offset
        planned = planner.reference(state, landing)
        reference = self._swing_momentum.apply(planned, state, planner)
        if offset is not None:
            reference = offset.apply(reference, state, self._heading)
        if self.hand_contacts.contacts:
            reference = self.hand_contacts.apply(reference)
        state.dcm_offset = reference.dcm - planned.dcm
        return reference

    @property
    def telemetry(self) -> Telemetry:
        """The telemetry of the last tick, for observers."""
        com, state, velocity = self._kin.p_com.copy(), self.gait_state, self.velocity
        if self._falling_why:
            return falling_telemetry(com, state.steps, velocity, self._heading, self._falling_why)
        ground = self._tasks.height.ground
        return walking_telemetry(com, state, self._balance, ground, velocity, self._heading)

    @property
    def contact_plan(self) -> ContactPlan:
        """The present support and the planned footsteps; computed anew at each call."""
        if self._falling_why:
            return ContactPlan()
        support, ground = self.stabilizer.support, self._tasks.height.ground
        return planned_contacts(self.gait_state, self.planner, support, ground)

    @property
    def falling_why(self) -> str:
        """Why a fall is unavoidable; empty as long as the robot keeps its balance."""
        return self._falling_why

    @property
    def kinematics(self) -> Kinematics:
        """The kinematics of the last tick."""
        return self._kin

    @property
    def gait_state(self) -> GaitState:
        """Phase, feet and times of the gait."""
        return self.state_machine.state

    @property
    def gait_cycle(self) -> float:
        """Duration of a step of each foot, s."""
        return 2.0 * self.gait.step_duration

    @property
    def heading(self) -> float:
        """Mean heading of the soles, rad."""
        return self._heading

    @property
    def feet(self) -> Feet:
        """Both soles as they were at the last tick."""
        return self.gait_state.feet

    @property
    def standing_frame(self) -> pin.SE3:
        """`T_world_standing`: on the ground midway between the soles, x along their heading."""
        feet = self.feet
        middle = feet.middle
        height = 0.5 * (feet.left.height + feet.right.height)
        origin = np.array([middle.real, middle.imag, height])
        return pin.SE3(rotation_about_z(self._heading), origin)

    @property
    def stopping_place(self) -> Placement:
        """Where the robot would stand, midway between its feet, if the present step closed them.

        It stays where it is during a step, without the sway of the gait: a velocity of the way from
        here over the duration of a step leads there in that step (see `WaypointFollower.for_gait`).
        """
        state = self.gait_state
        if state.at_rest or state.stopping:
            return Placement(state.feet.middle, self._heading)
        beside = -0.5 * lateral_sign(state.support) * state.normal_gait.step_width
        return state.stance.compose(Placement(complex(0.0, beside), 0.0))

    @property
    def height(self) -> float:
        """Wanted height of the CoM over the ground at this tick, m."""
        return self._tasks.height.above_ground

    @property
    def steps(self) -> int:
        """Touchdowns since the reset."""
        return self.gait_state.steps

    @property
    def about_to_recover(self) -> bool:
        """Whether the robot, at rest, steps from the next tick on, because a push asks for it."""
        state = self.gait_state
        return state.requested_swing is not None and state.at_rest

    @property
    def dcm_error(self) -> float:
        """Distance of the DCM from its reference after the last tick, m."""
        return abs(self._balance.dcm - self._balance.reference.dcm)
