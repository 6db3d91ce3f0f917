"""State of the gait: phase, feet and times, as planners and stabilizer read them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

from wbc.gait.footsteps import Velocity
from wbc.gait.hop import Hop
from wbc.gait.lifted_foot import LiftedFoot
from wbc.gait.parameters import GaitParameters
from wbc.gait.phase import STAND, TRANSFER, Phase
from wbc.gait.swing_foot import SwingFoot
from wbc.geometry.planar import Feet, Placement

_ORIGIN = Placement(0j, 0.0)


class PlannedFootstep(NamedTuple):
    """A foot and the place where it is to stand."""

    side: str
    placement: Placement


@dataclass(slots=True)
class GaitCommand:
    """The command to the gait.

    Attributes:
        velocity: walking velocity.
        footsteps: given ones, the next first; they take precedence over the velocity. A
            planner removes a footstep when its swing begins.
    """

    velocity: Velocity = field(default_factory=Velocity)
    footsteps: list[PlannedFootstep] = field(default_factory=list)


@dataclass(slots=True)
class GaitState:
    """Phase and feet of the gait at this tick.

    The gait state machine writes it; planners, contact manager and stabilizer read it. Ground
    points are complex numbers x + iy in world axes.

    Attributes:
        gait: parameters of the present steps: `normal_gait` or `recovery_gait`.
        feet: soles as estimated.
        normal_gait: parameters of undisturbed walking.
        recovery_gait: parameters of the quick steps after a push.
        com: ground point below the estimated centre of mass, m.
        com_height: world height of the estimated centre of mass, m.
        com_velocity: its horizontal velocity, m/s.
        vertical_velocity: its velocity upwards, m/s.
        dcm: estimated divergent component of motion without the bias of the CoM, m; of a walking
            robot that is pushed, with what its angular momentum adds.
        dcm_offset: by how much the wanted DCM differed from the planner's at the last tick, because
            of the swing leg's angular momentum or a motion, m.
        disturbance: rate at which an unknown force moves the DCM, m/s.
        phase: part of the gait cycle.
        support: side of the foot that carries, or that the weight moves to.
        time: since the phase began, s; 0 in the tick in which it begins.
        duration: duration of the phase, s.
        hold: time at the beginning of a transfer in which the weight does not move yet, s.
        tipping: edge of its sole over which the support foot tips: direction from the sole's centre
            to it, x + iy in the sole's axes; 0 when the sole is flat on the ground.
        shortened: the phase ends before its usual time, to catch a push.
        crossing: 1 if the swing foot crosses over in front of the support foot, −1 behind it, 0 if
            it lands on its own side.
        pushed_at_rest: the present steps began out of standing, because of a push.
        starting: the transfer begins from standing on both feet.
        stopping: the transfer ends in standing on both feet.
        weight_shift: where the weight is while standing or on one leg: 0 over the right
            sole, 1 over the left. Walking starts from the middle.
        other_foot_load: largest share of the weight that the foot which does not support
            may carry while standing; infinity leaves it to the controller.
        swing: reference of the foot in the air; None when both stand.
        hop: the hop of the support foot; None: it stands, or is to stand.
        landing: placement at which the swing foot lands, with the stabilizer's adjustment.
        steps: number of touchdowns so far.
        fast_share: 0 up to the speed of the longest usual step, 1 when the robot walks fast, see
            `SpeedAdaptation.fast_share`.
        on_stairs: the given footsteps lead over stairs, so that no other foothold may be chosen and
            no quick step be made.
        ground_slope: estimated slope of the ground: its rise per metre along world x, and along y
            as the imaginary part.
        lift_off_slope: that of the sole that left the ground last.
        requested_swing: side of the foot that has to step although nobody commands a step,
            because the robot falls otherwise, or that steps although the weight moves to it; None:
            no step is needed.
        lost_foot: side of a foot that a blow knocked off the place where it stood, see
            `wbc.gait.lost_contact`; None: both are where they are to be.
    """

    gait: GaitParameters
    feet: Feet
    recovery_gait: GaitParameters
    com: complex = 0j
    com_height: float = 0.0
    com_velocity: complex = 0j
    vertical_velocity: float = 0.0
    dcm: complex = 0j
    dcm_offset: complex = 0j
    disturbance: complex = 0j
    phase: Phase = STAND
    support: str = "left"
    time: float = 0.0
    duration: float = 0.0
    hold: float = 0.0
    tipping: complex = 0j
    shortened: bool = False
    crossing: float = 0.0
    pushed_at_rest: bool = False
    starting: bool = True
    stopping: bool = False
    weight_shift: float = 0.5
    other_foot_load: float = math.inf
    swing: SwingFoot | LiftedFoot | None = None
    hop: Hop | None = None
    landing: Placement = _ORIGIN
    steps: int = 0
    fast_share: float = 0.0
    on_stairs: bool = False
    ground_slope: complex = 0j
    lift_off_slope: complex = 0j
    requested_swing: str | None = None
    lost_foot: str | None = None
    normal_gait: GaitParameters = field(init=False)

    def __post_init__(self) -> None:
        self.normal_gait = self.gait

    @property
    def limits(self) -> GaitParameters:
        """The gait whose limits hold for the landing place: a step that catches a push is wider."""
        return self.recovery_gait if self.shortened else self.gait

    @property
    def recovering(self) -> bool:
        """Whether the present steps are the quick ones after a push."""
        return self.gait is not self.normal_gait

    @property
    def is_quick(self) -> bool:
        """Whether the present step is one that catches a push."""
        return self.shortened or self.gait is not self.normal_gait

    @property
    def steps_out(self) -> bool:
        """Whether the present step is one that catches a push on a robot that stood."""
        return self.pushed_at_rest and self.is_quick

    def on_slope(self, placement: Placement) -> Placement:
        """The same placement at the height that the ground has there, from the support foot on."""
        slope = self.ground_slope
        if slope == 0j:
            return placement
        stance = self.stance
        way = placement.point - stance.point
        rise = slope.real * way.real + slope.imag * way.imag
        return placement._replace(height=stance.height + rise)

    @property
    def may_choose_side(self) -> bool:
        """Whether a push can be answered with a step of either foot: both carry, none has to go on.

        So it is at rest, on the way there, and while the weight moves out of rest.
        """
        if self.phase is TRANSFER:
            return self.stopping or (self.starting and not self.pushed_at_rest)
        return self.at_rest

    @property
    def swing_side(self) -> str:
        """Side of the foot that does not support."""
        return "right" if self.support == "left" else "left"

    @property
    def stance(self) -> Placement:
        """The placement of the support foot."""
        return self.feet.left if self.support == "left" else self.feet.right

    @property
    def other_foot(self) -> Placement:
        """The placement of the other foot."""
        return self.feet.right if self.support == "left" else self.feet.left

    @property
    def at_rest(self) -> bool:
        """Whether the robot stands, on two feet or on one."""
        return self.phase is STAND or isinstance(self.swing, LiftedFoot)

    @property
    def lifted(self) -> LiftedFoot | None:
        """The foot that is held up while the robot stands on the other one."""
        return self.swing if isinstance(self.swing, LiftedFoot) else None

    @property
    def swing_is_knocked(self) -> bool:
        """Whether a blow has thrown the foot in the air off its way."""
        return isinstance(self.swing, SwingFoot) and self.swing.knocked

    @property
    def progress(self) -> float:
        """Completed share of the swing or of the weight's transfer, 0 to 1."""
        elapsed, whole = self.time - self.hold, self.duration - self.hold
        if elapsed >= whole or whole <= 0.0:
            return 1.0
        return elapsed / whole if elapsed > 0.0 else 0.0

    @property
    def remaining(self) -> float:
        """Time to the planned end of the phase, s; 0 when overdue."""
        left = self.duration - self.time
        return left if left > 0.0 else 0.0

    @property
    def standing_point(self) -> complex:
        """Ground point between the soles at which the ZMP rests while standing, m."""
        if self.weight_shift == 0.5:
            return self.feet.middle
        left, right = self.feet.left.point, self.feet.right.point
        return right + self.weight_shift * (left - right)
