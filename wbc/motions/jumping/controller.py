"""The controller of a jump: crouch, push-off, flight, landing, rise."""

from __future__ import annotations

import math
from enum import Enum

import numpy as np

from wbc.command import Command
from wbc.estimation import Estimate
from wbc.gait import Feet
from wbc.geometry.planar import ground_point, wrap_angle
from wbc.geometry.polygon import clamp_to_polygon, convex_hull, sole_corners
from wbc.kinematics import Kinematics
from wbc.motions.jumping.flight import SoleFlightReference
from wbc.motions.jumping.gains import JumpGains
from wbc.motions.jumping.plan import JumpPlan
from wbc.motions.jumping.profile import HeightProfile, HeightState, MinimumJerk, stroke
from wbc.motions.jumping.tasks import JumpTasks
from wbc.qp import Solver
from wbc.robot import Robot
from wbc.state import State
from wbc.telemetry import ContactPlan, Telemetry
from wbc.walking.feet import sides_in_contact
from wbc.walking.ground_kinematics import GroundKinematics

_GROUND_TIME = 0.15  # s, smoothing of the ground's height under the robot
_SETTLED = 0.005  # m, of the DCM
_LEAST_STROKE = 0.03  # m, of a landing
_LEAST_FORCE = 0.1  # share of the weight: with less, the ZMP moves nothing
_BOTH = frozenset(("left", "right"))


class JumpPhase(Enum):
    """Phase of a jump."""

    CROUCH = "crouch"
    PUSH_OFF = "push-off"
    FLIGHT = "flight"
    LANDING = "landing"
    RISE = "rise"
    DONE = "stand"


class JumpController:
    """Jumps once, from standing to standing; a `ControllerOverride`.

    On the ground, height and posture follow the plan's path, and the ZMP p brings the DCM over
    the middle of the soles with the present vertical force: `c̈ = (g + z̈)/z (c − p)`. In the air
    there are no contacts: the CoM falls, the angular momentum is constant, and the soles move to
    where they will catch the CoM; trunk and arms follow the path, which has no momentum, and so
    compensate the legs. The foot sensors detect touchdown; from there the landing is planned
    again.

    Args:
        robot: the robot.
        plan: plan of the jump.
        dt: control period, s.
        gains: weights, gains and times.
        solver: QP solver by name, see `WholeBodyController`.

    Attributes:
        plan: plan of the jump.
        phase: present phase.
        dcm_error: distance of the DCM from the middle of the soles after the last tick, m.
    """

    def __init__(
        self,
        robot: Robot,
        plan: JumpPlan,
        dt: float = 0.002,
        gains: JumpGains | None = None,
        *,
        solver: str | Solver | None = None,
    ) -> None:
        self.robot = robot
        self.plan = plan
        self.dt = dt
        self._gains = gains or JumpGains()
        self._gravity = robot.gravity
        self._kin = Kinematics(robot, robot.standing())
        self._ground_kinematics = GroundKinematics(robot, self._kin)
        self._tasks = JumpTasks(robot, self._kin, dt, self._gains, solver)
        self.reset(robot.standing())

    @property
    def done(self) -> bool:
        """Whether the robot stands again."""
        return self.phase is JumpPhase.DONE

    def reset(self, state: State) -> None:
        """Start from standing, both soles on the ground.

        Raises:
            StateError: see `State.checked`.
        """
        kin, plan = self._kin, self.plan
        kin.update(state)
        feet = self._feet = self._ground_kinematics.read()[0]
        self._ground = 0.5 * (feet.left.height + feet.right.height)
        self._heading = feet.left.yaw + 0.5 * wrap_angle(feet.right.yaw - feet.left.yaw)
        self._standing = float(kin.p_com[2]) - self._ground
        self._home = state.q[7:].copy()
        self._down = _BOTH
        self._abandoned = False
        self._flight: SoleFlightReference | None = None
        self._zmp = feet.middle
        self.dcm_error = 0.0
        time = self._time_for(self._gains.crouch_time, self._standing - plan.lowest)
        self._height: HeightProfile | MinimumJerk = MinimumJerk(self._standing, plan.lowest, time)
        self._crouch = MinimumJerk(0.0, 1.0, time)
        self._enter(JumpPhase.CROUCH)

    def abandon(self) -> None:
        """Rise from the crouch without a jump; a jump that has left the crouch is finished."""
        self._abandoned = True

    def step(self, estimate: Estimate) -> Command:
        """Compute the command of one tick.

        Args:
            estimate: state and contacts; without foot sensors touchdown goes by time.

        Raises:
            StateError: see `State.checked`.
        """
        contacts = sides_in_contact(self.robot, estimate)
        kin = self._kin
        kin.update(estimate.state)
        feet = self._feet = self._ground_kinematics.read()[0]
        self._advance(kin, feet, self._touching(contacts))
        self._time += self.dt
        if self._flight is None:
            self._balance(kin, feet)
        else:
            self._tasks.stand_on(())
            self._follow(self._flight.write_reference(kin, self._time))
        return self._tasks.solve(kin)

    def _enter(self, phase: JumpPhase) -> None:
        self.phase, self._time = phase, 0.0

    def _time_for(self, least: float, way: float) -> float:
        """Return the duration of a motion below half of the take-off speed, s."""
        return max(least, 1.875 * abs(way) / (0.5 * self.plan.speed))

    def _touching(self, contacts: frozenset[str] | None) -> frozenset[str]:
        """Return the sides whose soles stand; without foot sensors it goes by time."""
        if contacts is None:
            flight = self._flight
            over = flight is None or self._time >= flight.duration
            return _BOTH if over else frozenset()
        return contacts

    def _advance(self, kin: Kinematics, feet: Feet, touching: frozenset[str]) -> None:
        """Enter the next phase if it is time."""
        gains, plan, phase, time = self._gains, self.plan, self.phase, self._time + 0.5 * self.dt
        if phase is JumpPhase.CROUCH and time > self._height.duration + gains.pause:
            if self._abandoned:
                self._rise(plan.lowest)
                return
            self._height = plan.push_off
            self._enter(JumpPhase.PUSH_OFF)
        elif phase is JumpPhase.PUSH_OFF and time > plan.push_off.duration:
            self._leave_ground(kin)
        elif self._flight is not None:
            if touching and time > 0.5 * self._flight.duration:
                self._touch_down(kin, feet, touching)
        elif phase is JumpPhase.LANDING:
            self._down = _BOTH if time > gains.catch_time else self._down | touching
            if time > self._height.duration + gains.pause:
                self._rise(self._height.at(time)[0])
        elif phase is JumpPhase.RISE:
            over = time - self._height.duration
            if over > gains.settle_time or (over > 0.0 and self.dcm_error < _SETTLED):
                self._height = MinimumJerk(self._standing, self._standing, 1.0)
                self._crouch = MinimumJerk(0.0, 0.0, 1.0)
                self._enter(JumpPhase.DONE)

    def _rise(self, lowest: float) -> None:
        time = self._time_for(self._gains.rise_time, self._standing - lowest)
        self._height = MinimumJerk(lowest, self._standing, time)
        self._crouch = MinimumJerk(1.0, 0.0, time)
        self._enter(JumpPhase.RISE)

    def _leave_ground(self, kin: Kinematics) -> None:
        soles, gains = self._tasks.soles, self._gains
        self._down = frozenset()
        self._flight = SoleFlightReference(
            self.plan, kin, soles, self._ground, 10.0 * self.dt, gains.reach
        )
        self._enter(JumpPhase.FLIGHT)

    def _touch_down(self, kin: Kinematics, feet: Feet, touching: frozenset[str]) -> None:
        self._flight = None
        self._down = touching
        self._ground = float(np.mean([feet.of(side).height for side in touching]))
        height, fall = float(kin.p_com[2]) - self._ground, min(float(kin.v_com[2]), -0.1)
        lowest = min(self.plan.lowest, height - _LEAST_STROKE)
        begin = -self._gains.softness * self._gravity
        self._height = stroke(height, fall, (lowest, 0.0, 0.0), begin)
        self._enter(JumpPhase.LANDING)

    def _balance(self, kin: Kinematics, feet: Feet) -> None:
        """Set the references of a phase on the ground."""
        gains, g, com = self._gains, self._gravity, self._tasks.com
        self._tasks.stand_on(self._down)
        height, rate, acceleration = self._height.at(self._time)
        if self._down == _BOTH:
            ground = 0.5 * (feet.left.height + feet.right.height)
            self._ground += (ground - self._ground) * min(self.dt / _GROUND_TIME, 1.0)
        here, speed, middle = ground_point(kin.p_com), ground_point(kin.v_com), feet.middle
        omega = math.sqrt(g / height)
        objective = -(omega + gains.dcm_gain) * speed - gains.dcm_gain * omega * (here - middle)
        stiffness = max(g + acceleration, _LEAST_FORCE * g) / height
        self._zmp = clamp_to_polygon(
            here - objective / stiffness, self._support(feet, -gains.zmp_margin), 0.0
        )
        push = stiffness * (here - self._zmp)
        assert com.target is not None
        com.target[2] = self._ground + height
        com.velocity[2] = rate
        com.acceleration[:] = push.real, push.imag, acceleration
        self.dcm_error = abs(here + speed / omega - middle)
        self._follow((height, rate, acceleration))

    def _support(self, feet: Feet, margin: float) -> list[complex]:
        return convex_hull(
            [
                corner
                for sole in self.robot.soles
                for corner in sole_corners(
                    feet.of(sole.side), sole.half_length + margin, sole.half_width + margin
                )
            ]
        )

    def _follow(self, height: HeightState) -> None:
        """Set trunk and posture along the path, or between it and standing."""
        path = self.plan.path
        if self.phase in (JumpPhase.PUSH_OFF, JumpPhase.FLIGHT, JumpPhase.LANDING):
            pitch, posture = path.trunk_pitch(height), path.posture(height)
        else:
            lowest = (self.plan.lowest, 0.0, 0.0)
            share = np.array(self._crouch.at(self._time))[:, None]
            pitch = share * path.trunk_pitch(lowest)[0]
            posture = share * (path.posture(lowest)[0] - self._home)
            posture[0] += self._home
        self._tasks.set_trunk_pitch(self._heading, pitch)
        self._tasks.set_posture(posture)

    @property
    def telemetry(self) -> Telemetry:
        """The telemetry of the last tick, for observers."""
        kin = self._kin
        here = ground_point(kin.p_com)
        omega = math.sqrt(self._gravity / self._standing)
        flying = self._flight is not None
        return Telemetry(
            com=kin.p_com.copy(),
            dcm=self._on_ground(here + ground_point(kin.v_com) / omega),
            dcm_reference=self._on_ground(self._feet.middle),
            zmp=np.full(3, np.nan) if flying else self._on_ground(self._zmp),
            heading=self._heading,
            dcm_error=self.dcm_error,
            phase="flight" if flying else "stand",
        )

    @property
    def contact_plan(self) -> ContactPlan:
        """The support polygon; empty in flight."""
        if self._flight is not None:
            return ContactPlan()
        corners = self._support(self._feet, 0.0)
        return ContactPlan(support=np.array([self._on_ground(p) for p in corners]))

    def _on_ground(self, p: complex) -> np.ndarray:
        return np.array([p.real, p.imag, self._ground])
