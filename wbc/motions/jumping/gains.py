"""Weights, gains and times of a jump, in one place."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class JumpGains:
    """Weights, gains and times of a jump.

    Attributes:
        com_weight: weight of the CoM's acceleration on the ground; it has no effect in the air.
        height_kp: stiffness of the CoM's height, 1/s².
        sole_weight: weight of the soles' poses in the air.
        sole_kp: stiffness of the soles' poses in the air, 1/s².
        trunk_weight: weight of the orientation of torso and base.
        trunk_kp: stiffness of that orientation, 1/s².
        posture_weight: weight of the posture of arms, waist and head.
        leg_posture_weight: weight of the legs' posture: soles and CoM determine them.
        posture_kp: stiffness of the posture, 1/s².
        momentum_weight: weight of the angular momentum.
        second_contact_weight: weight of the motion of one of two soles on the ground.
        friction: Coulomb coefficient that the QP counts on.
        sole_margin: margin at the soles' edges that the QP leaves unused, m.
        zmp_margin: distance of the desired ZMP from the edge of the support polygon, m.
        dcm_gain: k of the DCM feedback, 1/s.
        braking: greatest deceleration that the limits of position and velocity count on,
            rad/s²: a leg in the air can stop faster than one that carries.
        crouch_time: least duration of the crouch, s.
        pause: time in the crouch, s.
        rise_time: least duration from the landing's crouch to standing, s.
        settle_time: longest wait for balance after that, s.
        catch_time: time after the first touchdown from which both soles count as standing, s.
        softness: share of free fall with which the landing begins: its force starts near zero.
        reach: greatest distance from below the CoM at which the soles may land, m.
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
    softness: float = 0.9
    reach: float = 0.08
