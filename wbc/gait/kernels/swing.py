"""One step of the swing foot's reference; see `wbc.gait.swing_foot`."""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import argument_types, kernel, subkernel

# Shares of the swing's duration.
LIFT = 0.05  # at its start: straight up, so that a toe clears the edge it stands at
APEX = 0.5  # when the apex is reached, and the sole has the slope of the ground where it lands
_TURN = 0.1  # when the sole begins to turn from the slope that it left
_LATE_ACCELERATION = 6.0  # m/s², downwards, of a foot that is late
_LATE_SPEED = 0.4  # m/s, at the most


@subkernel
def _step_quintic(
    x: float, v: float, a: float, target: float, end_velocity: float, remaining: float, dt: float
) -> tuple[float, float, float]:
    """Move one step along the quintic from a state to a target, which may change at each step.

    Relative to a point that reaches the target with constant velocity, the remaining distance is
    `(1 − s)³ P(s)` with `P = p₀ + p₁ s + p₂ s²`: the coordinate arrives exactly.

    Args:
        x: position now.
        v: velocity now, 1/s.
        a: acceleration now, 1/s².
        target: position after the remaining time.
        end_velocity: velocity there; the acceleration is 0.
        remaining: time until then, s.
        dt: step, s.

    Returns:
        Position, velocity and acceleration after dt.
    """
    if remaining <= dt:
        return target, end_velocity, 0.0
    T, s = remaining, dt / remaining
    u = 1.0 - s
    p0 = x + end_velocity * T - target
    w = (v - end_velocity) * T
    p1 = w + 3.0 * p0
    p2 = 0.5 * T * T * a + 3.0 * (w + p0 + p0)
    P, dP = p0 + s * (p1 + s * p2), p1 + 2.0 * s * p2
    return (
        target - end_velocity * (T - dt) + u * u * u * P,
        end_velocity + u * u * (u * dP - 3.0 * P) / T,
        u * (2.0 * u * u * p2 - 6.0 * (u * dP - P)) / (T * T),
    )


@kernel(argument_types(np.zeros((4, 4)), *(1.0,) * 3))
def tilt(pose: np.ndarray, yaw: float, slope_x: float, slope_y: float) -> None:
    """Write the rotation of a sole on a slope into a (4, 4) pose; see `advance_swing`."""
    c, s = math.cos(yaw), math.sin(yaw)
    along = slope_x * c + slope_y * s
    n = 1.0 / math.sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
    x = 1.0 / math.sqrt(1.0 + along * along)
    pose[0, 0], pose[1, 0], pose[2, 0] = x * c, x * s, x * along
    pose[0, 2], pose[1, 2], pose[2, 2] = -n * slope_x, -n * slope_y, n
    pose[0, 1] = pose[1, 2] * pose[2, 0] - pose[2, 2] * pose[1, 0]
    pose[1, 1] = pose[2, 2] * pose[0, 0] - pose[0, 2] * pose[2, 0]
    pose[2, 1] = pose[0, 2] * pose[1, 0] - pose[1, 2] * pose[0, 0]


_VECTOR = np.zeros(6)


@kernel(argument_types(np.zeros((4, 4)), _VECTOR, _VECTOR, *(1.0,) * 17))
def advance_swing(
    pose: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    yaw: float,
    time: float,
    duration: float,
    dt: float,
    x: float,
    y: float,
    height: float,
    end_yaw: float,
    apex: float,
    touchdown_speed: float,
    start_slope_x: float,
    start_slope_y: float,
    slope_x: float,
    slope_y: float,
    lift: float,
    arrival: float,
    fall: float,
) -> float:
    """Move a swing foot on by dt towards a landing place; return its heading, rad.

    Args:
        pose: (4, 4) of the sole in the world, moved on.
        velocity: (6,) world axes, moved on, m/s and rad/s.
        acceleration: (6,) world axes, replaced, m/s² and rad/s².
        yaw: heading of the sole, rad.
        time: since lift-off, s.
        duration: duration of the swing, s.
        dt: s.
        x, y, height: centre of the sole where it lands, world, m.
        end_yaw: heading of the sole there, rad.
        apex: height of the apex, world, m.
        touchdown_speed: downward, m/s.
        start_slope_x, start_slope_y: slope of the sole at lift-off, rise per metre along x, y.
        slope_x, slope_y: the same where it lands.
        lift: share of the duration in which the foot goes straight up.
        arrival: share of the duration after which it goes straight down.
        fall: time that it takes from the apex to the ground, s; infinite: it goes down at once.
    """
    remaining = duration - time
    if time + dt > lift * duration:
        until = arrival * duration - time
        for i, goal in enumerate((x, y)):
            pose[i, 3], velocity[i], acceleration[i] = _step_quintic(
                pose[i, 3], velocity[i], acceleration[i], goal, 0.0, until, dt
            )
        goal = yaw + ((end_yaw - yaw + math.pi) % (2.0 * math.pi) - math.pi)
        yaw, velocity[5], acceleration[5] = _step_quintic(
            yaw, velocity[5], acceleration[5], goal, 0.0, until, dt
        )
    # The sole turns from slope to slope while it is well above the ground.
    s = min(max((time + dt) / duration - _TURN, 0.0) / (APEX - _TURN), 1.0)
    share = s * s * (3.0 - 2.0 * s)
    rate = 6.0 * s * (1.0 - s) / (duration * (APEX - _TURN))
    d_x, d_y = slope_x - start_slope_x, slope_y - start_slope_y
    tilt(pose, yaw, start_slope_x + share * d_x, start_slope_y + share * d_y)
    velocity[3], velocity[4] = rate * d_y, -rate * d_x
    if remaining > 0.0:
        goal, speed, left = height, -touchdown_speed, remaining
        if remaining > fall:
            goal, speed, left = apex, 0.0, remaining - fall
        pose[2, 3], velocity[2], acceleration[2] = _step_quintic(
            pose[2, 3], velocity[2], acceleration[2], goal, speed, left, dt
        )
    else:
        fast = velocity[2] <= -_LATE_SPEED
        acceleration[2] = 0.0 if fast else -_LATE_ACCELERATION
        velocity[2] += acceleration[2] * dt
        pose[2, 3] += velocity[2] * dt
    return yaw
