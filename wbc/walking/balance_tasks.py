"""Tasks of a walker that stay in the QP in every phase: CoM, trunk, posture, angular momentum."""

from __future__ import annotations

import numpy as np

from wbc.controller import WholeBodyController
from wbc.gait import SWING, GaitState
from wbc.gait.leg_workspace import LegWorkspace
from wbc.gait.yaw_moment import YawMoment
from wbc.geometry.planar import wrap_angle
from wbc.kinematics import Kinematics
from wbc.tasks import AngularMomentumTask, ComTask, PostureTask, Task
from wbc.walking.gains import WalkerGains
from wbc.walking.height_reference import HeightReference
from wbc.walking.reference_offset import ReferenceOffset
from wbc.walking.stabilizer.disturbance import is_pushed
from wbc.walking.trunk_tasks import TrunkTasks
from wbc.walking.weight_share import WeightShare

_THRUST_SHARE = 20.0  # share of its weight that the CoM's height has in the thrust of a hop


class BalanceTasks:
    """Adds the tasks to the controller and sets their references in each tick.

    The CoM's horizontal acceleration is what the stabilizer commands; its height is a position
    reference.

    Args:
        controller: gets the tasks.
        kin: standing upright, heading along x.
        workspace: workspace of the legs.
        gains: weights and gains.
        dt: control period, s.

    Attributes:
        com: centre of mass.
        posture: all actuated joints.
        height: reference of the CoM's height.
    """

    def __init__(
        self,
        controller: WholeBodyController,
        kin: Kinematics,
        workspace: LegWorkspace,
        gains: WalkerGains,
        dt: float,
    ) -> None:
        robot, kp = controller.robot, gains.height_kp
        self._gains = gains
        self._com_target = np.zeros(3)
        self.com = controller.add(
            ComTask(
                self._com_target,
                weight=gains.com_weight,
                kp=np.array([0.0, 0.0, kp]),
                kd=np.array([0.0, 0.0, 2.0 * np.sqrt(kp)]),
            )
        )
        self._com_share = WeightShare((self.com,))
        self._trunk = TrunkTasks(controller, kin, gains)
        *torso, base = self._trunk.tasks
        self._torso_share, self._base_share = WeightShare(torso), WeightShare((base,))
        weights = np.full(robot.na, gains.posture_weight)
        for leg in robot.legs:
            weights[np.array(leg) - 6] = gains.leg_posture_weight
        weights[list(workspace.knees)] = gains.knee_posture_weight
        self.posture = controller.add(PostureTask(robot, weight=weights, kp=gains.posture_kp))
        self._momentum = controller.add(AngularMomentumTask(weight=gains.momentum_weight))
        self._yaw_moment = YawMoment(robot)
        # The weight counts for the arms' joints, whatever the arms' size.
        arms = self._yaw_moment.arm_momentum
        self._yaw_weight = gains.yaw_momentum_weight / arms**2 if arms > 0.0 else 0.0
        self._arm_share = 0.0
        self._hops = self._was_pushed = False
        self.height = HeightReference(workspace, gains.ground_time, dt)

    @property
    def tasks(self) -> tuple[Task, ...]:
        """The tasks in the order in which the controller has them."""
        return (self.com, *self._trunk.tasks, self.posture, self._momentum)

    def update(
        self,
        state: GaitState,
        com_acceleration: complex,
        heading: float,
        step_length: float,
        offset: ReferenceOffset | None,
    ) -> None:
        """Set the references of this tick.

        Args:
            state: phase, feet and swing foot.
            com_acceleration: horizontal acceleration of the CoM, world axes, m/s².
            heading: heading that the trunk faces, rad.
            step_length: length of the present steps, m.
            offset: offset that a motion adds; None for none.
        """
        com = self.com
        com.acceleration[0], com.acceleration[1] = com_acceleration.real, com_acceleration.imag
        height = self.height.update(state, step_length)
        if offset is not None:
            height += offset.com[2]
            com.velocity[2] = offset.com_velocity[2]
            com.acceleration[2] = offset.com_acceleration[2]
        if state.hop is not None or self._hops:
            height = self._hop(state, height)
        self._com_target[2] = height
        com.target = self._com_target
        share = 0.0
        if state.fast_share > 0.0:
            share = self._yaw_moment.beyond_sole(step_length, state.normal_gait.single_support)
        if share != self._arm_share:
            self._swing_arms(share)
        swing, pushed = state.swing, is_pushed(state)
        if pushed or self._was_pushed:
            self._hold_trunk(state, pushed)
            self._was_pushed = pushed
        self._trunk.update(heading, 0.0 if swing is None else 0.5 * swing.yaw_rate, offset)

    def _hop(self, state: GaitState, height: float) -> float:
        """Set what is wanted of the CoM's height in a hop, or no longer; return the height, m.

        Its acceleration is wanted, from where it is and how fast it moves. The thrust has little
        time, and counts more than the way of any limb.
        """
        com, hop = self.com, state.hop
        self._hops = hop is not None
        self._com_share.set((1.0, 1.0, _THRUST_SHARE) if hop and not hop.flies else 1.0)
        if hop is None:
            com.velocity[2] = com.acceleration[2] = 0.0
            return height
        com.velocity[2] = state.vertical_velocity
        com.acceleration[2] = hop.vertical_acceleration
        return state.com_height

    def _hold_trunk(self, state: GaitState, pushed: bool) -> None:
        """Set the weights of torso and base, while the robot is pushed and when it no longer is.

        In quick steps only its posture holds a torso about the vertical that a blow has turned on
        its waist: to turn it back takes more than one sole transmits by friction, and the waist
        turns much farther than the legs. Other quick steps turn it less.
        """
        share = self._trunk_weight_share(state) if pushed else 1.0
        self._base_share.set(share)
        angle = self._gains.torso_release_angle
        turned = state.is_quick and abs(self._trunk.torso_turn()) > angle
        self._torso_share.set((share, share, 0.0) if turned else share)

    def _trunk_weight_share(self, state: GaitState) -> float:
        """Return the share of its weight with which the trunk of a pushed robot is held.

        In quick steps it is held firmly: what a step leaves of the DCM's error the next one
        catches, but none rights a trunk that turns, for which the soles are too small. Of a robot
        that stood it yields in the first step, whose foot starts late and far from its place.
        """
        if state.phase is SWING and state.steps_out:
            return self._gains.trunk_step_out_share
        return self._gains.trunk_recovery_share

    def _swing_arms(self, share: float) -> None:
        """Have the arms swing against the legs, for a share of the moment that the sole lacks."""
        change = share - self._arm_share
        self._arm_share = share
        weight = self._momentum.weight.copy()
        weight[2] = max(weight[2] + change * self._yaw_weight, 0.0)
        self._momentum.weight = weight


def mean_heading(state: GaitState) -> float:
    """Return the mean heading of both feet, the swing foot's as planned, rad."""
    left, right, swing = state.feet.left.yaw, state.feet.right.yaw, state.swing
    if swing is not None:
        if state.support == "right":
            left = swing.yaw
        else:
            right = swing.yaw
    return left + 0.5 * wrap_angle(right - left)
