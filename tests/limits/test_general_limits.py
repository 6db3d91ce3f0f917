"""General limits: rows of one's own, in every formulation; what is no limit is refused."""

import numpy as np
import pytest
from coretools import controller, robot, standing_state
from random_cases import VerticalForce

import wbc
from wbc.command import Status
from wbc.errors import LimitError
from wbc.limits import Limit

FORMULATIONS = pytest.mark.parametrize("formulation", list(wbc.Formulation))


class ComAcceleration(Limit):
    """The CoM accelerates upwards by no more than `maximum`; switched off by None."""

    def __init__(self, maximum):
        super().__init__("CoM acceleration", 1, unit="m/s²", labels=("z",))
        self.maximum = maximum

    def write(self, kin, rows):
        if self.maximum is not None:
            rows.A[0] = kin.J_com[2]
            rows.upper[0] = self.maximum - kin.bias_com[2]


def lift(control, state, acceleration=3.0):
    """CoM acceleration upwards when the CoM task wants `acceleration`."""
    control.tasks[0].acceleration[2] = acceleration
    command = control.step(state)
    kin = wbc.Kinematics(control.robot, state)
    return float((kin.J_com @ command.acceleration + kin.bias_com)[2]), command


@FORMULATIONS
def test_a_user_defined_limit_holds_and_is_evaluated_every_tick(formulation):
    bot = robot("talos")
    limit = ComAcceleration(0.5)
    control = controller(bot, "both", formulation=formulation)
    control.set_limits((*control.limits, limit))
    state = standing_state(bot, 1)
    assert lift(control, state)[0] == pytest.approx(0.5, abs=1e-6)
    limit.maximum = 1.0
    assert lift(control, state)[0] == pytest.approx(1.0, abs=1e-6)
    limit.maximum = None  # rows that are not written do not constrain anything
    assert lift(control, state)[0] > 2.0


@FORMULATIONS
@pytest.mark.parametrize("contacts", ["both", "left", "points", "left exact, right soft"])
def test_a_limit_on_contact_forces_holds_for_any_contacts(formulation, contacts):
    bot = robot("talos")
    control = controller(bot, contacts, formulation=formulation)
    control.set_limits((*control.limits, VerticalForce(bot, 0.9)))
    state = standing_state(bot, 2)
    _, command = lift(control, state)
    assert command.status is Status.OK, command.explanation
    kin = wbc.Kinematics(bot, state)
    vertical = sum(
        kin.frame(contact.frame).rotation[2] @ command.wrenches[contact.name][:3]
        for contact in control.contacts
    )
    assert vertical == pytest.approx(0.9 * bot.weight, rel=1e-6)


@FORMULATIONS
def test_an_infeasible_limit_is_named_with_its_row_and_unit(formulation):
    bot = robot("talos")
    control = controller(bot, "both", formulation=formulation)
    limit = ComAcceleration(-30.0)  # faster down than free fall
    control.set_limits((*control.limits, limit))
    command = control.step(bot.standing())
    assert command.status is Status.INFEASIBLE
    assert "CoM acceleration [z] above its maximum by" in command.explanation
    assert "m/s²" in command.explanation


@FORMULATIONS
def test_a_limit_that_is_not_finite_gives_safe_torques_and_its_name(formulation):
    bot = robot("talos")
    control = controller(bot, "both", formulation=formulation)
    control.set_limits((*control.limits, ComAcceleration(np.nan)))
    command = control.step(bot.standing())
    assert command.status is Status.FAILED
    assert "limit 'CoM acceleration'" in command.explanation
    assert np.isfinite(command.tau).all()


@FORMULATIONS
def test_a_limit_whose_write_fails_is_named(formulation):
    class Broken(ComAcceleration):
        def write(self, kin, rows):
            rows.A[0] = np.zeros(3)

    bot = robot("talos")
    control = controller(bot, "both", formulation=formulation)
    control.set_limits([Broken(1.0)])
    with pytest.raises(LimitError, match="CoM acceleration cannot write its"):
        control.step(bot.standing())


class Speed:
    """Looks like a limit and is none."""

    def bounds(self, kin):
        return None


@pytest.mark.parametrize(
    ("limits", "text"),
    [
        (
            [Speed()],
            r"\(Speed\) is not a limit.*TorqueLimit.*AccelerationBound.*Limit",
        ),
        ([wbc.TorqueLimit], r"\(TorqueLimit\) is not a limit"),
        ([None], "not a limit"),
        (ComAcceleration(1.0), r"no sequence; write limits=\["),
        ([ComAcceleration(1.0), ComAcceleration(2.0)], "two limits are named 'CoM acceleration'"),
    ],
)
def test_an_object_that_is_no_limit_is_refused_without_changes(limits, text):
    with pytest.raises(LimitError, match=text):
        wbc.WholeBodyController(robot("talos"), limits=limits)
    control = wbc.WholeBodyController(robot("talos"))
    before = control.limits
    with pytest.raises(LimitError, match=text):
        control.set_limits(limits)
    assert control.limits is before


def test_a_torque_limit_of_another_robot_is_refused():
    with pytest.raises(LimitError, match=r"joints, 'talos' has 32.*TorqueLimit\(robot\)"):
        wbc.WholeBodyController(robot("talos"), limits=[wbc.TorqueLimit(robot("g1"))])


@pytest.mark.parametrize(
    ("options", "text"),
    [({"size": 0}, "at least one row"), ({"size": 2, "labels": ("x",)}, "1 labels for 2 rows")],
)
def test_a_limit_with_invalid_rows_is_refused(options, text):
    class Own(ComAcceleration):
        def __init__(self):
            Limit.__init__(self, "own", unit="m", **options)

    with pytest.raises(LimitError, match=text):
        Own()
