"""What the swing leg's angular momentum does to the plan of the DCM."""

from __future__ import annotations

import math

import numpy as np

from wbc.gait import SWING, DcmReference, GaitState, Planner, SwingFoot
from wbc.gait.limb_momentum import swing_momentum
from wbc.gait.swing_foot import lift_share
from wbc.robot import Robot
from wbc.walking.kernels.swing_momentum import swing_acceleration

_GROUND_SHARE = 0.5  # of the momentum of a step that catches a push; the trunk takes the rest


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
        if state.is_quick:
            return self._apply_recovery(reference, state)
        gait, swing = state.gait, state.swing
        gap, distance = 0.0, 0j
        if isinstance(swing, SwingFoot):
            gap, distance = gait.double_support, state.landing.point - swing.start.point
        offset, pivot = swing_acceleration(
            state.time,
            state.duration,
            gap,
            gait.single_support,
            lift_share(state.fast_share),
            gait.omega,
            self.ratio,
            distance,
            self._next,
        )
        return _moved(reference, offset, pivot, gait.omega)

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
        ratio = (_GROUND_SHARE if state.steps_out else 1.0) * self.ratio
        offset = ratio * omega * (velocity - omega * (way * left + mean * (1.0 - left)))
        return _moved(reference, offset, -ratio * complex(a_x, a_y), omega)


def _moved(reference: DcmReference, offset: complex, pivot: complex, omega: float) -> DcmReference:
    """Return a reference whose DCM is moved by an offset, and its pivot off its ZMP, m."""
    dcm, velocity, zmp, _ = reference
    return DcmReference(dcm + offset, velocity + omega * (offset - pivot), zmp, pivot)


def _next_displacement(state: GaitState, planner: Planner) -> complex:
    """How far the foot moves in the swing that follows this phase, m; 0 if none follows."""
    steps = planner.footsteps(state)
    if state.phase is SWING:
        return steps[1].placement.point - state.stance.point if len(steps) > 1 else 0j
    return steps[0].placement.point - state.other_foot.point if steps else 0j


def _momentum_ratio(robot: Robot) -> float:
    """κ of a robot in its nominal posture: mean of forward and lateral acceleration, s²."""
    momentum = np.abs(swing_momentum(robot))
    return 0.5 * float(momentum[1, 0] + momentum[0, 1]) / robot.weight
