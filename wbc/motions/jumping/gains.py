"""Weights, gains and times of a jump, in one place."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class JumpGains:
    """Weights, gains and times of a jump.

    Attributes:
        com_weight: of the CoM's acceleration on the ground; in the air nothing can change it.
        height_kp: stiffness of the CoM's height, 1/s².
        sole_weight: of the soles' poses in the air.
        sole_kp: 1/s².
        trunk_weight: of torso and base orientation.
        trunk_kp: 1/s².
        posture_weight: of the posture of arms, waist and head.
        leg_posture_weight: of the legs' posture: soles and CoM determine them.
        posture_kp: 1/s².
        momentum_weight: of the angular momentum.
        second_contact_weight: of the motion of one of two soles on the ground.
        friction: Coulomb coefficient that the QP counts on.
        sole_margin: what the QP leaves unused at the soles' edges, m.
        zmp_margin: how far from the edge of the support polygon the wished ZMP stays, m.
        dcm_gain: k of the DCM feedback, 1/s.
        braking: most that the limits of position and velocity count on, rad/s²: a leg in
            the air is stopped faster than one that carries.
        crouch_time: s, at least.
        pause: in the crouch, s.
        rise_time: from the landing's crouch to standing, s, at least.
        settle_time: at most, s, that it then waits for balance before it counts as standing.
        catch_time: after the first touchdown, s; then both soles count as standing.
        soft: share of free fall with which the landing begins: its force starts near zero.
        reach: how far from below the CoM the soles may land, m, to catch its drift.
    """

    com_weight: float = 3000.0
    height_kp: float = 60.0
    sole_weight: float = 1000.0
    sole_kp: float = 400.0
    trunk_weight: float = 20.0
    trunk_kp: float = 80.0
    posture_weight: float = 1.0
    leg_posture_weight: float = 0.02
    posture_kp: float = 60.0
    momentum_weight: float = 0.01
    second_contact_weight: float = 3000.0
    friction: float = 0.6
    sole_margin: float = 0.005
    zmp_margin: float = 0.01
    dcm_gain: float = 4.0
    braking: float = 100.0
    crouch_time: float = 1.0
    pause: float = 0.3
    rise_time: float = 1.0
    settle_time: float = 2.0
    catch_time: float = 0.05
    soft: float = 0.9
    reach: float = 0.08
