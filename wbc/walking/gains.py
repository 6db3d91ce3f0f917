"""Weights and gains of the walker's tasks, in one place."""

from __future__ import annotations

import math
from dataclasses import dataclass

from wbc.robot import Robot

# Height of the centre of mass, m, from which on the gains are those of large robots.
_LARGE = 0.45


@dataclass(frozen=True, slots=True)
class WalkerGains:
    """Weights and gains of the walker's tasks.

    Attributes:
        com_weight: weight of the CoM's acceleration.
        height_kp: stiffness of the CoM height, 1/s².
        swing_weight: weight of the swing foot's pose.
        swing_recovery_share: share of it in quick steps, where nothing counts as much as the place
            of the foot, but for the first one of a robot that stood, in which the trunk yields.
        swing_recovery_turn_share: share of it in quick steps that the foot's roll and yaw have: an
            ankle at its stop must not hold the leg back.
        swing_kp: stiffness of the swing foot, 1/s².
        trunk_weight: weight of torso and base orientation.
        trunk_kp: 1/s².
        trunk_recovery_share: share of the trunk's weight in quick steps.
        trunk_step_out_share: share of the trunk's weight in the swing with which a robot that stood
            catches a push: the trunk takes up momentum that would move the ZMP away from the DCM.
        torso_release_angle: angle about the vertical by which a blow has to turn the torso on its
            waist, rad, for a quick step not to turn it back; infinity: it always does.
        tipping_distance: how far the DCM has left an edge of the sole over which the support foot
            of a quick step tips, share of the CoM's height; infinity: it never tips.
        tipping_weight: weight of the orientation of a support foot that tips over an edge.
        hop_speed: vertical speed with which a robot that is pushed towards its support foot hops on
            it, share of √(g h) with the CoM's height h; 0: it never hops.
        posture_weight: weight of the posture of arms, trunk and head.
        leg_posture_weight: weight of the legs' posture without the knees: too little to pull on
            the CoM.
        knee_posture_weight: weight of the knees: a leg that is almost straight behind the robot can
            lift its foot by bending the knee or by hiking the hip, and only this tells it which.
        posture_kp: 1/s².
        momentum_weight: weight of the angular momentum.
        yaw_momentum_weight: weight of the angular momentum about the vertical, over the square of
            what the arms' joints make of it (see `arm_yaw_momentum`), s². It counts as far as the
            sole does not transmit the moment that a fast swing leg needs: then the arms swing.
        second_contact_weight: weight of the motion of a foot on the ground that is not held
            exactly: the less important one in double support, the support foot in quick steps.
        friction: Coulomb coefficient that the QP counts on.
        sole_margin: width that the QP leaves unused at the soles' edges, m.
        zmp_margin: largest distance of the commanded ZMP beyond the support polygon, m.
        ankle_share: share of the sole over which the ZMP is trusted to catch the DCM; what it
            cannot catch moves the next footstep.
        unload_from: share of the double support after which the leaving foot is unloaded.
        ground_time: smoothing of the ground's height under the robot, s.
    """

    com_weight: float = 3000.0
    height_kp: float = 40.0
    swing_weight: float = 300.0
    swing_recovery_share: float = 4.5
    swing_recovery_turn_share: float = 0.033
    swing_kp: float = 400.0
    trunk_weight: float = 20.0
    trunk_kp: float = 80.0
    trunk_recovery_share: float = 3.0
    trunk_step_out_share: float = 1.0
    torso_release_angle: float = 0.3
    tipping_distance: float = 0.17
    tipping_weight: float = 20.0
    hop_speed: float = 0.2
    posture_weight: float = 1.0
    leg_posture_weight: float = 0.02
    knee_posture_weight: float = 0.5
    posture_kp: float = 60.0
    momentum_weight: float = 0.001
    yaw_momentum_weight: float = 100.0
    second_contact_weight: float = 3000.0
    friction: float = 0.6
    sole_margin: float = 0.005
    zmp_margin: float = 0.02
    ankle_share: float = 0.5
    unload_from: float = 0.6
    ground_time: float = 0.15

    @classmethod
    def for_robot(cls, robot: Robot) -> WalkerGains:
        """Gains scaled to a robot.

        Robots whose centre of mass is at least 0.45 m high have the same gains. With height and g
        everything of a smaller one is quicker: stiffnesses, 1/s², grow with g/h, and lengths and
        times shrink with h and √(h/g) (dynamic similarity; see `GaitParameters.for_robot`).

        Args:
            robot: the robot.
        """
        scale = max(_LARGE / robot.com_height, 1.0)
        gains = cls()
        return cls(
            height_kp=scale * gains.height_kp,
            swing_kp=scale * gains.swing_kp,
            trunk_kp=scale * gains.trunk_kp,
            posture_kp=scale * gains.posture_kp,
            sole_margin=gains.sole_margin / scale,
            zmp_margin=gains.zmp_margin / scale,
            ground_time=gains.ground_time / math.sqrt(scale),
        )
