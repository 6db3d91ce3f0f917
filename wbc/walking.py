"""The walker: gait, balance and whole-body controller put together."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from wbc.balance import clamp_to_polygon, convex_hull, corners, feedback_zmp
from wbc.command import Command
from wbc.contacts import SurfaceContact
from wbc.controller import WholeBodyController
from wbc.errors import ContactError, GaitError
from wbc.gait import DcmReference, Feet, GaitParameters, Phase, Placement, Schedule, Velocity
from wbc.gait.footsteps import SIDES
from wbc.gait.planar import point, wrap, yaw_of
from wbc.gait.reach import LegReach
from wbc.gait.dcm_plan import dcm_now
from wbc.kinematics import Kinematics
from wbc.robot import Robot
from wbc.state import State
from wbc.tasks import AngularMomentumTask, ComTask, FrameTask, OrientationTask, PostureTask
from wbc.telemetry import Footstep, Telemetry


class VelocityClamped(UserWarning):
    """The velocity command was beyond what the gait can do; the text says what it became."""


@dataclass(frozen=True, slots=True)
class WalkerGains:
    """Weights and gains of the walker's tasks.

    Attributes:
        com_weight: of the CoM's acceleration.
        height_kp: stiffness of the CoM height, 1/s².
        swing_weight: of the swing foot's pose.
        swing_kp: stiffness of the swing foot, 1/s².
        trunk_weight: of torso and base orientation.
        trunk_kp: 1/s².
        posture_weight: of the posture of arms, trunk and head.
        leg_posture_weight: of the legs' posture, the knees left out: too little to pull on
            the CoM.
        knee_posture_weight: of the knees: a leg that is almost straight behind the robot can
            lift its foot by bending the knee or by hiking the hip, and only this tells it which.
        posture_kp: 1/s².
        momentum_weight: of the angular momentum.
        second_contact_weight: of the motion of the less important foot in double support.
        friction: Coulomb coefficient that the QP counts on.
        sole_margin: what the QP leaves unused at the soles' edges, m.
        zmp_margin: how far the wished ZMP may leave the support polygon, m.
        unload_from: share of the double support after which the leaving foot is unloaded.
        ground_time: smoothing of the ground's height under the robot, s.
    """

    com_weight: float = 1000.0
    height_kp: float = 40.0
    swing_weight: float = 300.0
    swing_kp: float = 400.0
    trunk_weight: float = 20.0
    trunk_kp: float = 80.0
    posture_weight: float = 0.3
    leg_posture_weight: float = 0.02
    knee_posture_weight: float = 0.5
    posture_kp: float = 60.0
    momentum_weight: float = 0.001
    second_contact_weight: float = 3000.0
    friction: float = 0.6
    sole_margin: float = 0.005
    zmp_margin: float = 0.02
    unload_from: float = 0.6
    ground_time: float = 0.15


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
        schedule: the gait's state machine.

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
        solver: str = "daqp",
    ) -> None:
        self.robot = robot
        self.dt = dt
        self.gait = gait or GaitParameters.of(robot)
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
        upright = Kinematics(robot, robot.standing())
        self._reach = LegReach(robot)
        self._trunk = []
        for frame in dict.fromkeys((robot.torso, robot.base)):
            task = OrientationTask(frame, weight=gains.trunk_weight, kp=gains.trunk_kp)
            self._trunk.append((controller.add(task), upright.frame(frame).rotation.copy()))
        weights = np.full(robot.na, gains.posture_weight)
        for leg in robot.legs:
            weights[np.array(leg) - 6] = gains.leg_posture_weight
        weights[list(self._reach.knees)] = gains.knee_posture_weight
        self.posture = controller.add(PostureTask(robot, weight=weights, kp=gains.posture_kp))
        self.momentum = controller.add(AngularMomentumTask(weight=gains.momentum_weight))
        self._swing_tasks = {
            s.side: FrameTask(s.name, weight=gains.swing_weight, kp=gains.swing_kp)
            for s in robot.soles
        }
        self._soles = {s.side: s for s in robot.soles}
        self._contacts = {}
        for sole in robot.soles:
            contact = SurfaceContact.of(sole, margin=gains.sole_margin, friction=gains.friction)
            contact.bind(robot)
            self._contacts[sole.side] = contact
        self._weight = robot.mass * 9.81
        self._wanted = Velocity()
        self._kin: Kinematics | None = None
        self.reset(robot.standing())

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Wanted velocity in the heading frame: forward, left (m/s), turn left (rad/s).

        May be set at any tick; takes effect with the next step. Beyond the gait's limits it
        is clamped, with a `VelocityClamped` warning that says to what.
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
                raise GaitError(f"footsteps {k - 1} and {k} are both '{step.side}': sides must alternate")
            placement = Placement(point(step.position), step.yaw, float(step.position[2]))
            queue.append((step.side, placement))
        self.schedule.queue[:] = queue

    def reset(self, state: State) -> None:
        """Start anew, standing, from a state with both soles on the ground.

        Raises:
            StateError: see `State.checked`.
        """
        self._kin = Kinematics(self.robot, state)
        feet = self._feet(self._kin)
        self.schedule = Schedule(self.gait, feet)
        self._ground = 0.5 * (feet.left.height + feet.right.height)
        self._heading = feet.left.yaw + 0.5 * wrap(feet.right.yaw - feet.left.yaw)
        self._height_now = float(self._kin.p_com[2]) - self._ground
        self._dcm = self._zmp = point(self._kin.p_com)
        self._reference = DcmReference(self._dcm, 0j, self._zmp)
        self.posture.target = state.q[7:].copy()

    def step(
        self, state: State, foot_wrenches: Mapping[str, np.ndarray] | None = None
    ) -> Command:
        """One tick.

        Args:
            state: estimated state.
            foot_wrenches: sole name -> (6,) wrench from the ground in sole axes, N and N·m;
                None or empty when the robot has no foot sensors: then contact goes by time.

        Raises:
            StateError: see `State.checked`.
            ContactError: a foot wrench of the wrong shape or name, or not finite.
        """
        loads = self._loads(foot_wrenches)
        assert self._kin is not None
        kin = self._kin
        kin.update(state)
        feet = self._feet(kin)
        schedule = self.schedule
        schedule.update(self.dt, feet, self._wanted, loads)
        self._balance(kin, feet)
        self._keep_upright(feet)
        self._place_contacts()
        return self.controller.solve(kin)

    def _loads(self, wrenches: Mapping[str, np.ndarray] | None) -> dict[str, float] | None:
        if not wrenches:
            return None
        loads = {}
        for sole in self.robot.soles:
            if sole.name not in wrenches:
                raise ContactError(
                    f"foot_wrenches has {sorted(wrenches)} but not '{sole.name}'; "
                    "give both soles, or None"
                )
            wrench = np.asarray(wrenches[sole.name], dtype=float)
            if wrench.shape != (6,):
                raise ContactError(
                    f"foot_wrenches['{sole.name}'] has shape {wrench.shape}, expected (6,): "
                    "force then moment in sole axes"
                )
            if not np.isfinite(wrench.sum()):
                raise ContactError(f"foot_wrenches['{sole.name}'] = {wrench} is not finite")
            loads[sole.side] = float(wrench[2]) / self._weight
        return loads

    def _feet(self, kin: Kinematics) -> Feet:
        def sole(side: str) -> Placement:
            at = kin.motion(self._soles[side].frame_id)
            return Placement(point(at.position), yaw_of(at.rotation), float(at.position[2]))

        return Feet(sole("left"), sole("right"))

    def _balance(self, kin: Kinematics, feet: Feet) -> None:
        gait, gains, schedule = self.gait, self.gains, self.schedule
        omega = gait.omega
        c, v = kin.p_com, kin.v_com
        com = point(c)
        self._dcm = com + point(v) / omega
        self._reference = dcm_now(schedule.zmp_segments(), omega)
        zmp = feedback_zmp(self._dcm, self._reference, omega, gait.dcm_gain)
        self._zmp = clamp_to_polygon(zmp, self._support(feet), gains.zmp_margin)
        push = omega * omega * (com - self._zmp)
        self.com.acceleration[0], self.com.acceleration[1] = push.real, push.imag
        ground = self._ground_height(feet)
        blend = min(self.dt / gains.ground_time, 1.0)
        self._ground += blend * (ground - self._ground)
        height = min(gait.com_height, self._reach.com_height(self._step_length()))
        self._height_now += 0.25 * blend * (height - self._height_now)
        assert self.com.target is not None
        self.com.target[2] = self._ground + self._height_now

    def _step_length(self) -> float:
        """Length of the steps of now, m: how far a foot is left behind."""
        if self.schedule.phase is Phase.STAND:
            return 0.0
        velocity = self.schedule.velocity
        return math.hypot(velocity.forward, velocity.left) * self.gait.step_duration

    def _support(self, feet: Feet) -> list[complex]:
        schedule = self.schedule

        def sole(side: str) -> list[complex]:
            s = self._soles[side]
            return corners(feet.of(side), s.half_length, s.half_width)

        if schedule.phase is Phase.SWING:
            return sole(schedule.support)
        return convex_hull(sole("left") + sole("right"))

    def _ground_height(self, feet: Feet) -> float:
        schedule = self.schedule
        support = feet.of(schedule.support).height
        if schedule.phase is Phase.SWING:
            return support
        leaving = feet.of(schedule.swing_side).height
        share = schedule.progress if schedule.phase is Phase.TRANSFER else 0.5
        return leaving + (support - leaving) * share

    def _keep_upright(self, feet: Feet) -> None:
        schedule = self.schedule
        left, right = feet.left.yaw, feet.right.yaw
        rate = 0.0
        if schedule.swing is not None:
            rate = 0.5 * schedule.swing.yaw_rate
            if schedule.swing_side == "left":
                left = schedule.swing.yaw
            else:
                right = schedule.swing.yaw
        self._heading = left + 0.5 * wrap(right - left)
        turn = _about_z(self._heading)
        for task, upright in self._trunk:
            task.target = turn @ upright
            task.velocity[2] = rate

    def _place_contacts(self) -> None:
        schedule, controller, contacts = self.schedule, self.controller, self._contacts
        support, leaving = contacts[schedule.support], contacts[schedule.swing_side]
        swing_task = self._swing_tasks[schedule.swing_side]
        for task in self._swing_tasks.values():
            wanted = schedule.swing is not None and task is swing_task
            if wanted and task not in controller.tasks:
                controller.add(task)
            elif not wanted and task in controller.tasks:
                controller.remove(task)
        support.motion_weight = None
        support.max_force = leaving.max_force = float("inf")
        if schedule.swing is not None:
            controller.contacts = (support,)
            swing = schedule.swing
            swing_task.target = pin.SE3(_about_z(swing.yaw), np.array(swing.position))
            swing_task.velocity[:3] = swing.velocity
            swing_task.velocity[5] = swing.yaw_rate
            swing_task.acceleration[:3] = swing.acceleration
            swing_task.acceleration[5] = swing.yaw_acceleration
            return
        leaving.motion_weight = self.gains.second_contact_weight
        if schedule.phase is Phase.TRANSFER and not schedule.stopping:
            start = self.gains.unload_from
            left_over = (1.0 - schedule.progress) / (1.0 - start)
            if left_over < 1.0:
                leaving.max_force = max(left_over * 0.5 * self._weight, 1.0)
        controller.contacts = (support, leaving)

    @property
    def telemetry(self) -> Telemetry:
        """What the walker sees and intends, for observers."""
        assert self._kin is not None
        feet = self._feet(self._kin)
        schedule = self.schedule
        z = self._ground

        def at(p: complex) -> np.ndarray:
            return np.array([p.real, p.imag, z])

        steps = tuple(
            Footstep(side, np.array([p.point.real, p.point.imag, p.height]), p.yaw)
            for side, p in schedule.preview()
        )
        swing = schedule.swing
        path = np.array(swing.path()) if swing is not None else np.empty((0, 3))
        phase = schedule.support if schedule.phase is Phase.SWING else schedule.phase.value
        return Telemetry(
            com=self._kin.p_com.copy(),
            dcm=at(self._dcm),
            dcm_reference=at(self._reference.dcm),
            zmp=at(self._zmp),
            support=np.array([at(p) for p in self._support(feet)]),
            footsteps=steps,
            swing_path=path,
            phase=phase,
        )

    @property
    def steps(self) -> int:
        """Touchdowns since the reset."""
        return self.schedule.steps

    @property
    def dcm_error(self) -> float:
        """Distance of the DCM from its reference after the last tick, m."""
        return abs(self._dcm - self._reference.dcm)


def _about_z(yaw: float) -> np.ndarray:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
