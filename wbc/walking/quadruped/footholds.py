"""Footholds and DCM of a gait in which groups of feet swing in turn.

A step begins when a group of feet lands and ends when the next one does. Its centre is the mean of
the feet that stand in it; about that point the divergent component of motion moves as
ξ = u + b e^(ωt). The feet that land are placed such that the next step has the offset b that
belongs to the wanted velocity: the capture point of Pratt et al. (Humanoids 2006) with the offsets
of M. Khadiv et al., *Walking control based on step timing adaptation* (T-RO 2020), and for
short steps the neutral point v T / 2 of M. Raibert (*Legged robots that balance*, 1986).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from wbc.gait.quadruped_gait import QuadrupedGait


def group_centers(gait: QuadrupedGait, places: Mapping[str, complex]) -> tuple[complex, ...]:
    """Return the mean of the feet that stand while each group swings, body axes, m.

    Args:
        gait: the groups.
        places: side -> place of the foot, body axes, m.
    """
    centers = []
    for group in gait.groups:
        standing = [place for side, place in places.items() if side not in group]
        centers.append(sum(standing) / len(standing))
    return tuple(centers)


def dcm_offsets(
    gait: QuadrupedGait, centers: Sequence[complex], velocity: complex
) -> tuple[complex, ...]:
    """Return the DCM's offset b from the centre of each step at its beginning, body axes, m.

    Steady walking repeats itself: with the distance d = v T + u⁺ − u of the next centre from this
    one, `b e^(ωT) = d + b⁺` for every step of the cycle.

    Args:
        gait: durations and groups.
        centers: see `group_centers`.
        velocity: body axes, m/s.
    """
    count, T = len(centers), gait.step_duration
    decay = math.exp(-gait.omega * T)
    ways = [velocity * T + centers[(k + 1) % count] - centers[k] for k in range(count)]
    # b_k = decay (d_k + b_(k+1)), once around.
    around = 0j
    for way in reversed(ways):
        around = decay * (way + around)
    offset = around / (1.0 - decay**count)
    offsets = [0j] * count
    for k in reversed(range(count)):
        offset = decay * (ways[k] + offset)
        offsets[k] = offset
    return tuple(offsets)
