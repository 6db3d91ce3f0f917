"""Task of the sole in the air: it follows the gait's swing foot."""

from __future__ import annotations

import numpy as np

from wbc.gait import LiftedFoot, SwingFoot
from wbc.kinematics import FrameKinematics, Kinematics
from wbc.tasks import FrameTask, TaskReference


class SwingTask(FrameTask):
    """Tracks the reference of a foot in the air.

    Attributes:
        foot: the reference; None: the task holds its target, as any `FrameTask`.
    """

    foot: SwingFoot | LiftedFoot | None = None

    def write_reference(self, kin: Kinematics, reference: TaskReference) -> None:
        """See `MotionTask.write_reference`."""
        if self.foot is None:
            super().write_reference(kin, reference)
            return
        motion = self.foot.motion
        reference.pose[:] = motion.pose
        reference.velocity[:] = motion.velocity
        reference.acceleration[:] = motion.acceleration

    def feedback(self, foot: SwingFoot, sole: FrameKinematics) -> np.ndarray:
        """Return what the task asks of the sole's centre to bring it back to its reference.

        Args:
            foot: the reference.
            sole: kinematics of the task's frame.

        Returns:
            (3,) `kp (x_ref − x) + kd (v_ref − v)`, world axes, m/s².
        """
        motion = foot.motion
        a: np.ndarray = self.kp[:3] * (motion.position - sole.position)
        a += self.kd[:3] * (motion.velocity[:3] - sole.velocity[:3])
        return a
