"""Divergent-component-of-motion plan over piecewise-linear ZMP, solved backward.

With the linear inverted pendulum c̈ = ω² (c − p) and ξ = c + ċ/ω, ξ̇ = ω (ξ − p). While
the ZMP p moves linearly for a time T from p₀ to p₁ with speed ṗ,

    ξ(0) = p₀ + ṗ/ω + (ξ(T) − p₁ − ṗ/ω) e^(−ωT),

so the DCM of today follows from the place where it is to end: stable, and cheap enough
to be redone every tick (Englsberger, Ott and Albu-Schäffer, Three-dimensional bipedal
walking control based on divergent component of motion, T-RO 2015).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple


class ZmpSegment(NamedTuple):
    """The ZMP moves at constant speed from `start` to `end` (ground points) in `duration` s."""

    start: complex
    end: complex
    duration: float


class DcmReference(NamedTuple):
    """Where DCM and ZMP should be now.

    Attributes:
        dcm: ξ_ref, ground point, m.
        dcm_velocity: ξ̇_ref, m/s.
        zmp: p_ref, ground point, m.
    """

    dcm: complex
    dcm_velocity: complex
    zmp: complex


def solve_dcm(
    segments: Sequence[ZmpSegment], omega: float, final: complex | None = None
) -> DcmReference:
    """The DCM that, from now, is where it should be after the last segment.

    Args:
        segments: from now on, the first one already cut to what remains of it.
        omega: 1/s.
        final: DCM after the last one; when left out, at rest on its end.
    """
    dcm = segments[-1].end if final is None else final
    for segment in reversed(segments):
        T = segment.duration
        if T <= 0.0:
            continue
        lead = (segment.end - segment.start) / (T * omega)
        dcm = segment.start + lead + (dcm - segment.end - lead) * math.exp(-omega * T)
    zmp = segments[0].start
    return DcmReference(dcm, omega * (dcm - zmp), zmp)
