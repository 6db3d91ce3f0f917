"""From an exception of the loader to a finding."""

from __future__ import annotations

import re

from wbc.robot.finding import Finding

# A message begins with the file it is about, which the finding's subject names already.
FILE = re.compile(r"^\S+\.(urdf|srdf|toml|xml|xacro)(: |, )")


def finding_from(error: Exception, subject: str, code: str) -> Finding:
    """The loader's refusal as a finding; its messages read `file: what; cure`."""
    what, _, cure = FILE.sub("", str(error)).partition("; ")
    return Finding(
        "error",
        subject,
        what,
        "the robot cannot be loaded",
        cure or "correct the description",
        code,
    )
