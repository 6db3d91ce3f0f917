"""Task of the sole in the air: it follows the gait's swing foot."""

from __future__ import annotations

from wbc.gait import LiftedFoot, SwingFoot
from wbc.kinematics import Kinematics
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
