"""The model doctor: each file looks for one kind of defect; `examine` puts them together."""

from wbc.robot.doctor.examine import check_file, check_robot

__all__ = ["check_file", "check_robot"]
