"""The model doctor: each file checks for one kind of defect; `examine` runs them all."""

from wbc.robot.doctor.examine import check_file, check_robot

__all__ = ["check_file", "check_robot"]
