"""The result of one trial: a row of the table of results."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace

from wbc.trials.recorder import RunOutcome, TrialMetrics
from wbc.trials.trial import Trial, UndisturbedRun

UNDISTURBED = "none"  # `TrialResult.disturbance` of an undisturbed run


@dataclass(frozen=True, slots=True)
class TrialResult:
    """The result of a trial, or of the undisturbed run that it was forked from.

    Attributes:
        key: identifies the trial by all that decides its result.
        robot: name or path.
        controller: name of the controller.
        velocity_forward: commanded, m/s; likewise to the left, and turning in rad/s.
        condition: name of the condition.
        seed: seed of sensor noise and terrain.
        disturbance: kind of the disturbance; "none" for an undisturbed run.
        phase: when it began, as a share of a gait cycle; None for an undisturbed run, likewise the
            next two.
        direction_deg: degrees counter-clockwise from the robot's heading.
        size: in the unit of the disturbance.
        survived: whether the robot did not fall.
        fell_at_s: time of the fall after the disturbance, or after the beginning of the
            undisturbed run, s; None without a fall.
        reason: why the robot counts as fallen, or the error that ended the trial; else empty.
        crashed: whether an error of the controller ended the trial.

    The other columns are those of `TrialMetrics`; None if they cannot be computed.
    """

    key: str
    robot: str
    controller: str
    velocity_forward: float
    velocity_left: float
    velocity_turn: float
    condition: str
    seed: int
    disturbance: str
    phase: float | None
    direction_deg: float | None
    size: float | None
    survived: bool
    fell_at_s: float | None
    reason: str
    crashed: bool = False
    duration_s: float | None = None
    steps: int | None = None
    distance_m: float | None = None
    dcm_error_peak_m: float | None = None
    torque_peak: float | None = None
    torque_rms_nm: float | None = None
    joint_velocity_peak: float | None = None
    position_error_rms_m: float | None = None
    velocity_error_rms_m_s: float | None = None
    tilt_error_rms_rad: float | None = None
    mechanical_power_w: float | None = None
    cost_of_transport: float | None = None
    landing_force_peak: float | None = None
    qp_failures: int | None = None
    falling_at_s: float | None = None

    @classmethod
    def of_run(
        cls, run: UndisturbedRun, outcome: RunOutcome, metrics: TrialMetrics | None
    ) -> TrialResult:
        """Return the result of an undisturbed run; the figures are those after the warm-up."""
        return cls._of(run, run.key, UNDISTURBED, (None, None, None), outcome, metrics)

    @classmethod
    def of_trial(
        cls, trial: Trial, outcome: RunOutcome, metrics: TrialMetrics | None
    ) -> TrialResult:
        """Return the result of a trial."""
        when = (float(trial.phase), trial.direction, trial.size)
        return cls._of(trial.run, trial.key, trial.disturbance.kind, when, outcome, metrics)

    @classmethod
    def _of(
        cls,
        run: UndisturbedRun,
        key: str,
        disturbance: str,
        when: tuple[float | None, float | None, float | None],
        outcome: RunOutcome,
        metrics: TrialMetrics | None,
    ) -> TrialResult:
        return cls(
            key,
            run.robot,
            run.controller.name,
            *run.velocity,
            run.condition.name,
            run.seed,
            disturbance,
            *when,
            outcome.survived,
            outcome.fell_at_s,
            outcome.reason,
            outcome.crashed,
            **({} if metrics is None else asdict(metrics)),
        )

    def renamed(self, controller: str, condition: str) -> TrialResult:
        """Return the same result with other names of controller and condition."""
        if (self.controller, self.condition) == (controller, condition):
            return self
        return replace(self, controller=controller, condition=condition)
