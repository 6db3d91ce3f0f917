"""What a walker tells observers: the telemetry of a tick, and the planned contacts."""

from __future__ import annotations

import numpy as np

from wbc.gait import SWING, GaitState, Planner
from wbc.telemetry import ContactPlan, Footstep, Telemetry
from wbc.walking.stabilizer import StabilizerOutput, SupportPolygon


def walking_telemetry(
    com: np.ndarray,
    state: GaitState,
    balance: StabilizerOutput,
    ground: float,
    velocity: tuple[float, float, float],
    heading: float,
) -> Telemetry:
    """Return the telemetry of a robot that walks or stands.

    Args:
        com: (3,) centre of mass, world, m; kept.
        state: phase, support and steps.
        balance: what the stabilizer decided.
        ground: height at which ground points are shown, m.
        velocity: wanted velocity, heading frame, m/s and rad/s.
        heading: rad.
    """
    dcm, reference, zmp = balance.dcm, balance.reference.dcm, balance.zmp
    rows = np.array(
        (
            (dcm.real, dcm.imag, ground),
            (reference.real, reference.imag, ground),
            (zmp.real, zmp.imag, ground),
            velocity,
        )
    )
    return Telemetry(
        com,
        rows[0],
        rows[1],
        rows[2],
        rows[3],
        heading,
        abs(dcm - reference),
        _phase(state),
        state.steps,
    )


def falling_telemetry(
    com: np.ndarray,
    steps: int,
    velocity: tuple[float, float, float],
    heading: float,
    why: str,
) -> Telemetry:
    """Return the telemetry of a robot whose fall is unavoidable; see `walking_telemetry`.

    Args:
        com: (3,) centre of mass, world, m; kept.
        steps: number of steps so far.
        velocity: wanted velocity, heading frame, m/s and rad/s.
        heading: rad.
        why: the reason.
    """
    return Telemetry(
        com,
        velocity=np.array(velocity),
        heading=heading,
        phase="falling",
        steps=steps,
        status_text=f"falling: {why}",
    )


def planned_contacts(
    state: GaitState, planner: Planner, support: SupportPolygon, ground: float
) -> ContactPlan:
    """Return the present support, the planned footsteps and the way of the swing foot.

    Args:
        state: phase, feet and swing foot.
        planner: plans the footsteps.
        support: support polygon.
        ground: height at which the support is shown, m.
    """
    swing = state.swing
    corners = [] if _flies(state) else support.corners(state)
    return ContactPlan(
        support=np.array([[p.real, p.imag, ground] for p in corners]).reshape(-1, 3),
        footsteps=tuple(
            Footstep(side, np.array([p.point.real, p.point.imag, p.height]), p.yaw)
            for side, p in planner.footsteps(state)
        ),
        swing_path=np.array(swing.path()) if swing is not None else np.empty((0, 3)),
    )


def _phase(state: GaitState) -> str:
    """Return the phase of a robot that walks or stands, one of `wbc.telemetry.PHASES`."""
    if _flies(state):
        return "flight"
    return state.support if state.phase is SWING else state.phase.value


def _flies(state: GaitState) -> bool:
    return state.hop is not None and state.hop.flies
