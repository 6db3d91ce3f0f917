"""Gait parameters as a function of the walking speed."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from wbc.gait.footsteps import Velocity
from wbc.gait.leg_workspace import LegWorkspace

if TYPE_CHECKING:  # which has the limits that are found with this module
    from wbc.gait.parameters import GaitParameters

FASTEST = 2.25  # x of the fastest walk: faster ones have not been shown to be reliable

_CADENCE = 0.6  # exponent of the speed with which steps become shorter in time
_DOUBLE_SUPPORT = 2.0  # the same of the double support
_GRID = 40  # speeds per usual speed: the parameters stay while the speed hardly changes
_RESERVE = 1.15  # longest step over the one that the speed asks for
_RAMP = 0.25  # change of x per usual step where x is above 1
_FAST = 0.25  # change of x from usual to fast walking
_FEEDBACK = 0.3  # share of a step's error of the speed that the next ones make up for
_MOST_FEEDBACK = 0.1  # share of the speed that this may come to


class SpeedAdaptation:
    """Steps of a gait for each speed: quicker, with less double support, and lower.

    Up to the speed of the longest step at the usual cadence, `v₁ = L_max / T`, durations are
    those of the gait. Faster, with x = v / v₁,

        T = T₁ x^−0.6,   T_double = T_double,₁ x^−2,

    so that length and frequency of the steps grow together, as they do in people (Alexander,
    Principles of Animal Locomotion, 2003), and the swing keeps most of its time: what bounds the
    speed are the speeds of the swing leg's joints. The natural frequency is that of the height at
    which the legs reach the footholds. The shorter the double support, the less far behind the
    rear foot leaves the ground: of a step's length, by the linear inverted pendulum,

        1 − ½ sinh a / (sinh a + b cosh a),   a = ω T_single / 2,   b = ω T_double / 2,

    and in proportion to this the height allows for less.

    The speed goes beyond v₁, and comes back from there, step by step. There a swing leg takes the
    knees and hips to what they can do, and each step ends with the DCM ahead of its plan, which
    makes the step longer. The integral of the error of the speed, step by step, takes that back.

    Args:
        gait: parameters of the gait at usual speeds.
        workspace: workspace of the legs.

    Attributes:
        gait: parameters of the gait at usual speeds.
        velocity: velocity of now, which `ramp` has led towards the wanted one.
    """

    def __init__(self, gait: GaitParameters, workspace: LegWorkspace) -> None:
        self.gait = gait
        self.velocity = Velocity()
        self._workspace = workspace
        self._commanded = Velocity()
        self._correction = 0.0  # of the forward velocity, m/s
        self._has_arrived = True  # at the wanted velocity, corrected
        self._index = 0
        self._adapted = gait

    def at(self, velocity: Velocity) -> GaitParameters:
        """The parameters for steps at a velocity; the same object while it hardly changes."""
        gait = self.gait
        usual = gait.max_step / gait.step_duration
        index = round(_GRID * velocity.speed / usual)
        if index != self._index:
            self._index = index
            self._adapted = self._adapt(index / _GRID) if index else gait
        return self._adapted

    def change_gait(self, gait: GaitParameters) -> GaitParameters:
        """Adapt other parameters from now on; return those of the present velocity.

        Args:
            gait: parameters of the gait at usual speeds.
        """
        self.gait = self._adapted = gait
        self._index = 0
        return self.at(self.velocity)

    def fast_share(self, velocity: Velocity) -> float:
        """0 up to the speed v₁ of the longest usual step, 1 from 1.25 times that on."""
        gait = self.gait
        x = abs(velocity.forward) * gait.step_duration / gait.max_step
        return min((x - 1.0) / _FAST, 1.0) if x > 1.0 else 0.0

    def observe_step(self, length: float, duration: float) -> None:
        """Take in a completed step.

        Args:
            length: distance forward between both feet, m.
            duration: time since the touchdown before, s.
        """
        wanted = self._commanded
        if not self._has_arrived:
            return
        if self.fast_share(wanted) == 0.0:
            self._correction = 0.0
            return
        most = _MOST_FEEDBACK * abs(wanted.forward)
        correction = self._correction + _FEEDBACK * (wanted.forward - length / duration)
        self._correction = max(-most, min(most, correction))

    def ramp(self, wanted: Velocity, dt: float, *, walking: bool) -> Velocity:
        """Lead the velocity towards the wanted one, corrected by the speed's error; return it.

        Args:
            wanted: commanded velocity.
            dt: time since the last tick, s.
            walking: whether the robot walks; standing, it has no speed yet.
        """
        if self.velocity is wanted and self._correction == 0.0:
            return wanted
        self._commanded = wanted
        gait = self.gait
        usual = gait.max_step / gait.step_duration
        now = self.velocity.forward if walking else 0.0
        change = _RAMP * usual * dt / gait.step_duration
        # Within the usual speeds it changes at once.
        least = now - change if now > usual else -max(usual, change - now)
        most = now + change if now < -usual else max(usual, now + change)
        corrected = wanted.forward
        if abs(corrected) > usual:
            most_forward, most_backward = gait.max_velocity.forward, gait.max_velocity.backward
            corrected = max(-most_backward, min(most_forward, corrected + self._correction))
        forward = max(least, min(most, corrected))
        self._has_arrived = forward == corrected
        if forward == wanted.forward:
            self.velocity = wanted
        else:
            # What the forward velocity still takes, the others cannot have yet.
            limits = gait.max_velocity
            left = math.sqrt(max(1.0 - limits.usage(forward, 0.0, 0.0) ** 2, 0.0))
            share = min(1.0, left / max(limits.usage(0.0, wanted.left, wanted.turn), 1e-9))
            self.velocity = Velocity(forward, share * wanted.left, share * wanted.turn)
        return self.velocity

    def _adapt(self, x: float) -> GaitParameters:
        gait = self.gait
        speed = x * gait.max_step / gait.step_duration
        x = max(x, 1.0)
        duration = gait.step_duration / x**_CADENCE
        double_support = gait.double_support / x**_DOUBLE_SUPPORT
        step = speed * duration
        behind = _behind(gait.omega, duration, double_support)
        trail = gait.trail * (behind / _behind(gait.omega, gait.step_duration, gait.double_support))
        return replace(
            gait,
            single_support=duration - double_support,
            double_support=double_support,
            max_step=max(gait.max_step, _RESERVE * step),
            com_height=min(gait.com_height, self._workspace.com_height(step, trail)),
            trail=trail,
        )


def _behind(omega: float, duration: float, double_support: float) -> float:
    """Return the share of a step that the rear foot is behind the CoM when it leaves the ground.

    Args:
        omega: natural frequency ω, 1/s.
        duration: single plus double support, s.
        double_support: duration of the double support, s.
    """
    a, b = 0.5 * omega * (duration - double_support), 0.5 * omega * double_support
    return 1.0 - 0.5 * math.sinh(a) / (math.sinh(a) + b * math.cosh(a))
