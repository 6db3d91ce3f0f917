"""Height of the CoM: over the ground under the weight, and lower for long steps."""

from __future__ import annotations

from wbc.gait import STAND, SWING, GaitState, SwingFoot
from wbc.gait.leg_workspace import TRAIL, LegWorkspace

_FASTEST = 0.25  # m/s, of the ground's height: more takes the weight off the soles, or doubles it
_LATE = 0.005  # m by which a foot is too low before it touches level ground
_SLOWER = 0.25  # the height over the ground changes slower than the ground by this factor


class HeightReference:
    """Low-passed height of the ground and of the CoM over it.

    The ground is that below the weight: it goes from foot to foot with it. The height over the
    ground is that of the gait, or what the legs allow at the present length of the steps.

    Args:
        workspace: workspace of the legs.
        time_constant: time constant of the ground's height, s.
        dt: time between two updates, s.

    Attributes:
        ground: height of the ground below the weight, world, m.
        above_ground: wanted height of the CoM above the ground, m.
    """

    def __init__(self, workspace: LegWorkspace, time_constant: float, dt: float) -> None:
        self._workspace = workspace
        self._share = min(dt / time_constant, 1.0)
        self._most = _FASTEST * dt  # m
        self._step_length, self._trail = 0.0, TRAIL
        self._reachable = workspace.com_height(0.0)
        self.ground = self.above_ground = 0.0

    def reset(self, ground: float, com: float) -> None:
        """Start anew with the heights of ground and CoM in the world, m."""
        self.ground, self.above_ground = ground, com - ground

    def update(self, state: GaitState, step_length: float) -> float:
        """Move on by a period; returns the wanted height of the CoM in the world, m.

        Args:
            state: phase and feet.
            step_length: length of the present steps, m.
        """
        share, most, gait = self._share, self._most, state.gait
        change = share * (_ground_below(state) - self.ground)
        self.ground += most if change > most else -most if change < -most else change
        height, trail = gait.com_height, gait.trail
        if step_length != self._step_length or trail != self._trail:
            self._step_length, self._trail = step_length, trail
            self._reachable = self._workspace.com_height(step_length, trail)
        if height > self._reachable:
            height = self._reachable
        self.above_ground += _SLOWER * share * (height - self.above_ground)
        return self.ground + self.above_ground


def _ground_below(state: GaitState) -> float:
    """Height of the ground from which the CoM's height counts, m.

    A step down begins with the support leg, which bends while the other foot swings: otherwise
    that foot does not reach its stair. Nor does one that is late reach ground that is lower than
    was thought: its leg is straight before, and the CoM sinks with it.
    """
    support = state.stance.height
    if state.phase is SWING:
        landing = state.landing.height
        if state.remaining == 0.0 and isinstance(state.swing, SwingFoot):
            landing = min(landing, float(state.swing.motion.position[2]) + _LATE)
        rise = landing - support
        if rise >= 0.0 or state.at_rest:
            return support
        s = state.progress
        return support + rise * s * s * (3.0 - 2.0 * s)
    other = state.other_foot.height
    if state.phase is STAND:
        return 0.5 * (support + other)
    if other > support and not state.starting:
        return support
    return other + (support - other) * state.progress
