"""`QuadrupedWalker`: gait, balance and whole-body controller of a robot on four feet."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pinocchio as pin

from wbc.command import Command
from wbc.controller import WholeBodyController
from wbc.estimation import Estimate
from wbc.gait import STAND, SWING, Placement, Velocity
from wbc.gait.quadruped_gait import QuadrupedGait, foot_places
from wbc.geometry.planar import planar_rotation, rotation_about_z, wrap_angle, yaw_of
from wbc.geometry.polygon import clamp_to_polygon, convex_hull
from wbc.kinematics import Kinematics
from wbc.qp import Solver
from wbc.robot import Robot, checked_robot
from wbc.robot.attitude import base_height, tilt
from wbc.robot.posture import find_knee
from wbc.state import State
from wbc.tasks import Task
from wbc.telemetry import ContactPlan, Footstep, Telemetry
from wbc.walking.command_checks import clamp_velocity, parse_velocity
from wbc.walking.falling import FallController, FallDetector
from wbc.walking.gains import WalkerGains
from wbc.walking.quadruped.footholds import dcm_offsets, group_centers
from wbc.walking.quadruped.quadruped_tasks import QuadrupedTasks
from wbc.walking.quadruped.step_sequence import StepSequence
from wbc.walking.reference_offset import ReferenceOffset
from wbc.walking.walker_telemetry import falling_telemetry

_ACCELERATION = 0.15  # of the wanted velocity, over gravity; of turning, over g/h
_TOPPLES = 0.5  # share of the way from the middle to the edge at which a standing robot steps
_SETTLED = 0.25  # the same, within which it stops stepping
_GROUND_TIME = 0.25  # smoothing of the ground's height, times √(h / g)


class QuadrupedWalker:
    """Stands and trots on four point feet: a velocity in, joint torques out.

    Feet swing in groups, two diagonal ones in a trot. What stands then is a line, which cannot push
    the robot to all sides, so that balance is a matter of where the next feet land. With the
    divergent component of motion ξ = c + ċ/ω, which moves as ξ̇ = ω (ξ − z) about the ZMP z, and
    the centre u of the feet that stand, they land around

        u⁺ = u + (ξ − u) e^(ω t) − b⁺,

    t before the end of the step, where b⁺ belongs to the wanted velocity (`dcm_offsets`). On the
    ground, the feet move the ZMP as far as they reach towards z = z* + (1 + k/ω) (ξ − ξ*). At rest
    all feet stand, and a push that moves ξ half the way to the edge starts a trot.

    `wbc.Walker` plans for a support foot and a swing foot with soles; what both have in common
    (swing feet, gains, trunk, estimator) they share.

    Args:
        robot: the robot.
        dt: control period, s.
        gait: groups, timing and geometry; a trot that is scaled to the robot when left out.
        gains: weights and gains of the tasks; scaled to the robot when left out.
        solver: QP solver, by name or as an object.

    Attributes:
        controller: the whole-body controller; add tasks of your own to it.
        reference_offset: offset that is added to CoM and trunk; None for none.

    Raises:
        GaitError: the robot has no four feet, or cannot step.
        SolverNotFound: the solver is unknown or not installed.
    """

    def __init__(
        self,
        robot: Robot,
        dt: float = 0.002,
        *,
        gait: QuadrupedGait | None = None,
        gains: WalkerGains | None = None,
        solver: str | Solver | None = None,
    ) -> None:
        self.robot, self.dt = checked_robot(robot, "QuadrupedWalker"), dt
        self.gait = gait or QuadrupedGait.for_robot(robot)
        self.gains = gains or WalkerGains.for_robot(robot)
        self.controller = WholeBodyController(robot, dt, solver=solver)
        self._kin = Kinematics(robot, robot.standing())
        self._tasks = QuadrupedTasks(self.controller, self._kin, self.gains)
        self._places = foot_places(robot)
        self._centers = group_centers(self.gait, self._places)
        self._frames = {sole.side: sole.frame_id for sole in robot.soles}
        self._sides = {sole.name: sole.side for sole in robot.soles}
        corners = convex_hull(self._places.values())
        edges = zip(corners, [*corners[1:], corners[0]], strict=True)
        self._to_edge = min(abs((a.conjugate() * b).imag) / abs(b - a) for a, b in edges)
        self._fall_detector = FallDetector(robot, dt)
        self._fall_controller = FallController(robot, dt, _knees(robot))
        base = self._kin.frame(robot.base).rotation
        self._base_yaw = yaw_of(base)
        self._command = Velocity()
        self.reference_offset: ReferenceOffset | None = None
        self.reset(robot.standing())

    def __repr__(self) -> str:
        v = self._command
        return (
            f"QuadrupedWalker({self.robot.name}, phase {self._sequence.phase.name}, "
            f"{self.steps} steps, velocity ({v.forward:g} m/s, {v.left:g} m/s, {v.turn:g} rad/s), "
            f"dt {self.dt:g} s)"
        )

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Wanted velocity in the heading frame: forward, left (m/s), turn left (rad/s).

        May be set at any tick. Beyond the gait's limits it is clamped, with a `VelocityClamped`
        warning that says to what.

        Raises:
            GaitError: it is not three finite numbers.
        """
        return (self._command.forward, self._command.left, self._command.turn)

    @velocity.setter
    def velocity(self, value: Sequence[float]) -> None:
        wanted = parse_velocity(value)
        self._command = clamp_velocity(wanted, self.gait.max_velocity, self.robot.name)

    def reset(self, state: State) -> None:
        """Start anew, standing, from a state with all feet on the ground; the velocity stays.

        Only this ends the state of falling.

        Raises:
            StateError: see `State.validated`.
        """
        self._fall_detector.reset()
        self._fall_controller.reset()
        self._falling_why = ""
        self._kin.update(state)
        self._sequence = StepSequence(self.gait)
        self._walked = Velocity()
        self._feet = self._read_feet()
        base = self._kin.frame(self.robot.base).rotation
        self._heading = wrap_angle(yaw_of(base) - self._base_yaw)
        self._ground = sum(foot.height for foot in self._feet.values()) / len(self._feet)
        com = self._kin.p_com
        point = complex(float(com[0]), float(com[1]))
        self._dcm = self._reference = self._zmp = point
        self._settled = 0
        self._tasks.update_feet({}, {})
        self._tasks.posture.target = state.q[7:].copy()

    def step(self, estimate: Estimate) -> Command:
        """Return the command of one tick.

        When a fall is unavoidable (see `FallDetector`), the joints only yield from then on, until
        `reset` (`FallController`).

        Args:
            estimate: state, contacts and foot wrenches; without foot sensors, contact goes by time.

        Raises:
            StateError: see `WholeBodyController.step`.
        """
        kin, gait, sequence = self._kin, self.gait, self._sequence
        kin.update(estimate.state)
        if self._falling_why:
            return self._fall_controller.command(estimate.state)
        feet = self._feet = self._read_feet()
        (x, y, z), (vx, vy, _) = kin.p_com.tolist(), kin.v_com.tolist()
        com, com_velocity = complex(x, y), complex(vx, vy)
        self._dcm = com + com_velocity / gait.omega
        leaning = tilt(self.robot, estimate.state)
        placed = tuple(feet.values())
        self._falling_why = self._fall_detector.update(
            leaning, self._dcm, z, base_height(estimate.state), placed
        )
        if self._falling_why:
            return self._fall_controller.command(estimate.state)
        self._accelerate()
        contacts = None
        if estimate.loads is not None:
            contacts = [self._sides[name] for name in estimate.contacts]
        sequence.update(self.dt, feet, contacts, self._walks())
        standing = [foot for side, foot in feet.items() if side not in sequence.swings]
        ground = sum(foot.height for foot in standing) / len(standing)
        self._ground += min(self.dt * gait.omega / _GROUND_TIME, 1.0) * (ground - self._ground)
        acceleration = self._balance(com, [foot.point for foot in standing])
        if sequence.swings:
            self._place_feet(com + com_velocity * sequence.time_left, ground)
        self._tasks.update_balance(
            acceleration,
            self._ground + gait.com_height,
            self._heading,
            self._walked.turn,
            self.reference_offset,
        )
        self._tasks.update_feet(sequence.swings, self._max_forces())
        return self.controller.solve(kin)

    def _read_feet(self) -> dict[str, Placement]:
        feet: dict[str, Placement] = {}
        kin = self._kin
        for side, frame in self._frames.items():
            x, y, z = kin.frame(frame).translation.tolist()
            feet[side] = Placement(complex(x, y), 0.0, z)
        return feet

    def _accelerate(self) -> None:
        """Bring the velocity that is walked nearer to the command, and turn the heading."""
        gait, now, goal = self.gait, self._walked, self._command
        most = _ACCELERATION * gait.gravity * self.dt
        turn = most / gait.com_height
        self._walked = Velocity(
            now.forward + min(max(goal.forward - now.forward, -most), most),
            now.left + min(max(goal.left - now.left, -most), most),
            now.turn + min(max(goal.turn - now.turn, -turn), turn),
        )
        self._heading = wrap_angle(self._heading + self._walked.turn * self.dt)

    def _walks(self) -> bool:
        """Return whether there is to be another step, because of the velocity or of a push."""
        if not (self._walked.is_zero and self._command.is_zero):
            self._settled = self._sequence.steps
            return True
        off = abs(self._dcm - self._middle())
        if self._sequence.phase is STAND:
            self._settled = self._sequence.steps
            return off > _TOPPLES * self._to_edge
        # Every foot makes a step at rest before the robot stands.
        if off > _SETTLED * self._to_edge:
            self._settled = self._sequence.steps
        return self._sequence.steps - self._settled <= len(self.gait.groups)

    def _middle(self) -> complex:
        """Return where the centre of mass rests: the middle of the feet, and a motion's offset."""
        middle = sum(foot.point for foot in self._feet.values()) / len(self._feet)
        return middle + self._offset_of_com()[0]

    def _offset_of_com(self) -> tuple[complex, complex]:
        """Return by how much a motion moves the references of DCM and ZMP, m."""
        if self.reference_offset is None:
            return 0j, 0j
        c, v, a = self.reference_offset.planar(self._heading)
        omega = self.gait.omega
        return c + v / omega, c - a / (omega * omega)

    def _balance(self, com: complex, support: Sequence[complex]) -> complex:
        """Return the acceleration of the CoM that brings the DCM to its reference, m/s²."""
        gait, sequence = self.gait, self._sequence
        omega = gait.omega
        if sequence.phase is STAND:
            offset = self._offset_of_com()
            middle = self._middle() - offset[0]
            self._reference, wanted = middle + offset[0], middle + offset[1]
        else:
            wanted = self._center()
            offset_now = self._offsets()[sequence.group] * math.exp(omega * sequence.step_time)
            self._reference = wanted + offset_now * planar_rotation(self._heading)
        zmp = wanted + (1.0 + gait.dcm_gain / omega) * (self._dcm - self._reference)
        self._zmp = clamp_to_polygon(zmp, convex_hull(support), 0.0)
        return omega * omega * (com - self._zmp)

    def _offsets(self) -> tuple[complex, ...]:
        return dcm_offsets(
            self.gait, self._centers, complex(self._walked.forward, self._walked.left)
        )

    def _center(self) -> complex:
        """Return the mean of the feet that stand in this step, m."""
        group = self.gait.groups[self._sequence.group]
        points = [foot.point for side, foot in self._feet.items() if side not in group]
        return sum(points) / len(points)

    def _place_feet(self, com: complex, ground: float) -> None:
        """Move the feet in the air on towards their footholds.

        Args:
            com: where the CoM will be at the end of the step, m.
            ground: height of the ground, m.
        """
        gait, sequence, walked = self.gait, self._sequence, self._walked
        left, following = sequence.time_left, sequence.next_group
        center = self._center()
        dcm = center + (self._dcm - center) * math.exp(gait.omega * left)
        offset = self._offsets()[following]
        landing = self._heading + walked.turn * left
        # The feet are placed for the heading in the middle of the next step.
        heading = landing + 0.5 * walked.turn * gait.step_duration
        turned = planar_rotation(heading)
        body = dcm - offset * planar_rotation(landing) - self._centers[following] * turned
        way = body - com
        if abs(way) > gait.max_step:
            body = com + way * (gait.max_step / abs(way))
        for side, swing in sequence.swings.items():
            place = Placement(body + self._places[side] * turned, heading, ground)
            swing.advance(self.dt, place)

    def _max_forces(self) -> Mapping[str, float]:
        load = self._sequence.leaving_load
        if load >= 1.0:
            return {}
        group = self.gait.groups[self._sequence.group]
        return dict.fromkeys(group, max(0.5 * load * self.robot.weight, 1.0))

    @property
    def tasks(self) -> tuple[Task, ...]:
        """Its own tasks: gains and weights may be set at any tick."""
        return self._tasks.tasks

    @property
    def gait_cycle(self) -> float:
        """Duration of a step of each foot, s."""
        return self.gait.cycle

    @property
    def heading(self) -> float:
        """Heading of the robot as it is wanted, rad."""
        return self._heading

    @property
    def steps(self) -> int:
        """Steps since the reset; a step of a trot is that of two feet."""
        return self._sequence.steps

    @property
    def falling_why(self) -> str:
        """Why a fall is unavoidable; empty as long as the robot keeps its balance."""
        return self._falling_why

    @property
    def kinematics(self) -> Kinematics:
        """The kinematics of the last tick."""
        return self._kin

    @property
    def standing_frame(self) -> pin.SE3:
        """`T_world_standing`: on the ground in the middle of the feet, x along the heading."""
        middle = self._middle() - self._offset_of_com()[0]
        origin = np.array([middle.real, middle.imag, self._ground])
        return pin.SE3(rotation_about_z(self._heading), origin)

    @property
    def telemetry(self) -> Telemetry:
        """The telemetry of the last tick, for observers."""
        if self._falling_why:
            com, why = self._kin.p_com.copy(), self._falling_why
            return falling_telemetry(com, self.steps, self.velocity, self._heading, why)
        ground, sequence = self._ground, self._sequence
        dcm, reference, zmp = (
            np.array([point.real, point.imag, ground])
            for point in (self._dcm, self._reference, self._zmp)
        )
        phase = sequence.phase.value
        if sequence.phase is SWING:
            phase = "right" if "front_left" in sequence.swings else "left"
        return Telemetry(
            self._kin.p_com.copy(),
            dcm,
            reference,
            zmp,
            np.array(self.velocity),
            self._heading,
            abs(self._dcm - self._reference),
            phase,
            sequence.steps,
        )

    @property
    def contact_plan(self) -> ContactPlan:
        """The present support, the footholds of the feet in the air, and the way of one of them."""
        if self._falling_why:
            return ContactPlan()
        swings = self._sequence.swings
        points = [foot.point for side, foot in self._feet.items() if side not in swings]
        footsteps = []
        for side, swing in swings.items():
            point, yaw, height = swing.target
            footsteps.append(Footstep(side, np.array([point.real, point.imag, height]), yaw))
        path = next((swing.path() for swing in swings.values()), [])
        return ContactPlan(
            np.array([[p.real, p.imag, self._ground] for p in convex_hull(points)]),
            tuple(footsteps),
            np.array(path) if path else np.empty((0, 3)),
        )


def _knees(robot: Robot) -> list[int]:
    """Return the indices of the knees among the actuated joints."""
    knees = (
        find_knee(robot.model, robot.q_nominal, sole.joint_id, sole.placement.translation, leg)
        for sole, leg in zip(robot.soles, robot.legs, strict=True)
    )
    return [knee - 6 for knee in knees if knee is not None]
