"""Properties of a robot with their origin (`Fact`), and defects of its description (`Finding`)."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

Severity = Literal["error", "warning", "note"]
Origin = Literal["derived", "stated"]

SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")

# A message of the loader begins with its file, which a finding's subject names already.
_FILE = re.compile(r"^\S+\.(urdf|srdf|toml|xml|xacro)(: |, )")


@dataclass(frozen=True, slots=True, repr=False)
class Fact:
    """A property of a robot that the loader derived or that was stated.

    Attributes:
        name: name of the property, for example `left_sole`.
        value: the value as a reader wants to see it, with its unit.
        origin: `derived` from the model, or `stated` by the data file or the caller.
        source: origin of the fact (a file, an argument, a rule).
    """

    name: str
    value: str
    origin: Origin
    source: str

    @classmethod
    def of(cls, name: str, value: str, stated_in: str | None, rule: str) -> Fact:
        """A fact stated in the file or argument `stated_in`, or derived by `rule` if None."""
        return (
            cls(name, value, "stated", stated_in)
            if stated_in
            else cls(name, value, "derived", rule)
        )

    def __repr__(self) -> str:
        return f"Fact({self.name!r}, {self.value!r}, {self.origin})"

    def __str__(self) -> str:
        return f"{self.name}: {self.value} ({self.origin}, {self.source})"


@dataclass(frozen=True, slots=True, repr=False)
class Finding:
    """One defect of a robot description.

    Attributes:
        severity: `error` (the robot cannot be controlled), `warning` (it can,
            with a substitute or a loss that is named) or `note`.
        subject: the link, joint or file that it is about.
        what: description of the defect.
        consequence: consequence of the defect.
        cure: remedy.
        code: identifier of the kind of defect, stable for programs.
    """

    severity: Severity
    subject: str
    what: str
    consequence: str
    cure: str
    code: str = ""

    @classmethod
    def from_error(cls, error: Exception, subject: str, code: str) -> Finding:
        """An exception of the loader as a finding; its text reads `file: what; cure`."""
        what, _, cure = _FILE.sub("", str(error)).partition("; ")
        consequence = "the robot cannot be loaded"
        return cls("error", subject, what, consequence, cure or "correct the description", code)

    def __repr__(self) -> str:
        return f"Finding({self.severity}, {self.subject!r}, {self.code!r})"

    def __str__(self) -> str:
        end = "" if self.cure.endswith(("?", "…")) else "."
        return (
            f"{self.severity}: {self.subject}: {self.what}; {self.consequence}. "
            f"Cure: {self.cure}{end}"
        )
