"""Divergent component of motion over a piecewise-linear ZMP, solved backward in time.

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
    """The desired DCM and ZMP now.

    Attributes:
        dcm: ξ_ref, ground point, m.
        dcm_velocity: ξ̇_ref, m/s.
        zmp: p_ref, ground point, m.
        cmp_offset: by how much the centroidal moment pivot, which the pendulum stands on, is off
            the ZMP: the rate of the angular momentum over the weight, m.
    """

    dcm: complex
    dcm_velocity: complex
    zmp: complex
    cmp_offset: complex = 0j


def dcm_before(
    start: complex, end: complex, duration: float, final: complex, omega: float
) -> complex:
    """ξ(0) for which the DCM is ξ(T) after one segment; see the equation above.

    Args:
        start: ZMP at the beginning p₀, ground point, m.
        end: ZMP at the end p₁, ground point, m.
        duration: T, s; not positive: the segment is skipped.
        final: ξ(T), ground point, m.
        omega: natural frequency ω, 1/s.
    """
    if duration <= 0.0:
        return final
    lead = (end - start) / (duration * omega)
    return start + lead + (final - end - lead) * math.exp(-omega * duration)


def dcm_after(segment: ZmpSegment, dcm: complex, time: float, omega: float) -> complex:
    """ξ(t) for which the DCM was ξ(0) at the beginning of a segment; see the equation above.

    Args:
        segment: the ZMP; after its end it goes on with the same speed.
        dcm: ξ(0), ground point, m.
        time: t, s.
        omega: natural frequency ω, 1/s.
    """
    start, end, duration = segment
    speed = (end - start) / duration if duration > 0.0 else 0j
    lead = speed / omega
    return start + speed * time + lead + (dcm - start - lead) * math.exp(omega * time)


def solve_dcm(
    segments: Sequence[ZmpSegment], omega: float, final: complex | None = None
) -> DcmReference:
    """DCM at the beginning of the first segment that leads to the wanted end of the last one.

    Args:
        segments: ZMP from now on, the first one already cut to what remains of it.
        omega: natural frequency ω, 1/s.
        final: DCM after the last one; at rest on its end when left out.
    """
    dcm = segments[-1].end if final is None else final
    for start, end, duration in reversed(segments):
        dcm = dcm_before(start, end, duration, dcm, omega)
    zmp = segments[0].start
    return DcmReference(dcm, omega * (dcm - zmp), zmp)
