"""What the swing leg's angular momentum does to the plan of the DCM."""

from __future__ import annotations

import math

from wbc.gait import DcmReference, GaitState, Phase, Planner, SwingFoot
from wbc.gait.kernels.swing import LIFT
from wbc.gait.leg_momentum import swing_momentum
from wbc.robot import Robot


class SwingMomentum:
    """Adds the angular momentum of the swing leg to a planner's DCM.

    A foot that accelerates by a changes the angular momentum about the centre of mass, and the
    centroidal moment pivot of an upright robot is off its ZMP by

        δ = −κ a,   κ = |L̇| / (m g |a|),

    ten centimetres on a small humanoid at half a metre per second. A plan without it has either
    the ZMP at the edge of the sole or the trunk swing. The linear inverted pendulum superposes:
    to `ξ̇ = ω (ξ − p)` belongs, beside the planner's DCM, the bounded solution of
    `ξ̇_δ = ω (ξ_δ − δ)`,

        ξ_δ(t) = ω ∫ δ(s) e^(−ω(s − t)) ds   from t on,

    over the rest of the present swing and the next one. The ZMP stays the planner's (the pivot
    is that of Popovic, Goswami and Herr, Ground reference points in legged locomotion, IJRR 2005;
    the superposition that of Takenaka, Matsumoto and Yoshiike, Real time motion generation and
    control for biped robot, IROS 2009).

    It is the momentum of the planned swing: a landing place that the stabilizer moves does not
    change it. In a step that catches a push, whose place and time change at every tick, it is that
    of the foot's present motion.

    Args:
        robot: the robot.

    Attributes:
        ratio: κ, s².
    """

    def __init__(self, robot: Robot) -> None:
        self.ratio = _momentum_ratio(robot)
        self._next = 0j  # displacement of the foot in the swing after this phase, m

    def apply(self, reference: DcmReference, state: GaitState, planner: Planner) -> DcmReference:
        """Return the planner's reference with the swing leg's momentum.

        Args:
            reference: the planner's.
            state: phase, times, feet and planned landing place.
            planner: asked once per phase for the footsteps ahead.
        """
        if state.at_rest or state.stopping:
            return reference
        if state.time == 0.0:
            self._next = _next_displacement(state, planner)
        if state.shortened or state.recovering:
            return self._apply_recovery(reference, state)
        gait, swing = state.gait, state.swing
        omega = gait.omega
        wait = state.remaining + LIFT * gait.single_support
        offset = acceleration = 0j
        if isinstance(swing, SwingFoot):
            wait += gait.double_support
            duration = (1.0 - LIFT) * state.duration
            lifting = max(LIFT * state.duration - state.time, 0.0)
            s = 1.0 - min(state.remaining / duration, 1.0)
            distance = state.landing.point - swing.start.point
            offset = distance * (
                math.exp(-omega * lifting) * _discounted_acceleration(s, duration, omega)
            )
            acceleration = distance * (_acceleration(s) / (duration * duration))
        if self._next != 0j:
            offset += self._next * (
                math.exp(-omega * wait)
                * _discounted_acceleration(0.0, (1.0 - LIFT) * gait.single_support, omega)
            )
        offset *= -self.ratio
        pivot = -self.ratio * acceleration
        return DcmReference(
            reference.dcm + offset,
            reference.dcm_velocity + omega * (offset - pivot),
            reference.zmp,
            pivot,
        )

    def _apply_recovery(self, reference: DcmReference, state: GaitState) -> DcmReference:
        """Return the reference of a step that catches a push with the momentum of its swing.

        Its landing place and time change from tick to tick, so the integral begins with the foot's
        present place x and velocity v. By parts, with the mean x̄ of the quintic to the target u,

            ∫ a e^(−ωs) ds = −v + ω (u e^(−ωT) − x + x̄ (1 − e^(−ωT))),   x̄ = (x + u)/2 + v T/10.
        """
        swing = state.swing
        if not isinstance(swing, SwingFoot):
            return reference
        omega, remaining, motion = state.gait.omega, state.remaining, swing.motion
        x, y, _ = motion.position.tolist()
        v_x, v_y, *_ = motion.velocity.tolist()
        a_x, a_y, *_ = motion.acceleration.tolist()
        velocity = complex(v_x, v_y)
        left = math.exp(-omega * remaining)
        way = swing.target.point - complex(x, y)
        mean = 0.5 * way + 0.1 * remaining * velocity
        offset = self.ratio * omega * (velocity - omega * (way * left + mean * (1.0 - left)))
        pivot = -self.ratio * complex(a_x, a_y)
        return DcmReference(
            reference.dcm + offset,
            reference.dcm_velocity + omega * (offset - pivot),
            reference.zmp,
            pivot,
        )


def _next_displacement(state: GaitState, planner: Planner) -> complex:
    """How far the foot moves in the swing that follows this phase, m; 0 if none follows."""
    steps = planner.footsteps(state)
    if state.phase is Phase.SWING:
        return steps[1].placement.point - state.stance.point if len(steps) > 1 else 0j
    return steps[0].placement.point - state.other_foot.point if steps else 0j


def _acceleration(s: float) -> float:
    """Second derivative of the quintic from 0 to 1, at rest at both ends, at 0 ≤ s ≤ 1."""
    return 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)


def _discounted_acceleration(s: float, duration: float, omega: float) -> float:
    """`ω ∫ a(u) e^(−ω(u − t)) du` from now to the end of a swing over a unit distance, 1/s².

    By parts: a is a cubic polynomial, whose derivatives at the end are 0, 60, 360 and 720.

    Args:
        s: elapsed share of the swing, 0 to 1.
        duration: of the swing, s.
        omega: natural frequency ω, 1/s.
    """
    x = omega * duration
    here = (
        _acceleration(s) + (60.0 - 360.0 * s * (1.0 - s) + (720.0 * s - 360.0 + 720.0 / x) / x) / x
    )
    end = (60.0 + (360.0 + 720.0 / x) / x) / x
    return (here - math.exp(-x * (1.0 - s)) * end) / (duration * duration)


def _momentum_ratio(robot: Robot) -> float:
    """κ of a robot in its nominal posture: mean of forward and lateral acceleration, s²."""
    pitch = abs(float(swing_momentum(robot, (1.0, 0.0))[1]))
    roll = abs(float(swing_momentum(robot, (0.0, 1.0))[0]))
    return 0.5 * (pitch + roll) / robot.weight
