"""Contacts of one's own: cones of any number of rows, forces of three to six components."""

import numpy as np
import pytest
from coretools import controller, robot, standing_state
from random_cases import SixteenSidedSole

import wbc
from wbc.command import Status
from wbc.errors import ContactError

FORMULATIONS = pytest.mark.parametrize("formulation", list(wbc.Formulation))


class LineContact(wbc.Contact):
    """An edge along the frame's y axis: a force and a moment about x, four components."""

    motion_size = 4
    half_length = 0.05

    def make_cone(self, mu):
        sides = [[1, 0, -mu, 0], [-1, 0, -mu, 0], [0, 1, -mu, 0], [0, -1, -mu, 0]]
        ends = [[0, 0, -self.half_length, 1], [0, 0, -self.half_length, -1]]
        return np.array(sides + ends, dtype=float)

    @property
    def cone_labels(self):
        return ("+x", "-x", "+y", "-y", "left end", "right end")


def soles(kind, bot):
    return [kind(s.name, s.half_length, s.half_width, friction=0.3) for s in bot.soles]


@FORMULATIONS
def test_a_user_defined_cone_may_have_more_than_sixteen_rows(formulation):
    bot = robot("talos")
    state = standing_state(bot, 4)
    control = controller(bot, soles(SixteenSidedSole, bot), formulation=formulation)
    control.tasks[0].acceleration[:] = (5.0, 5.0, 0.0)
    command = control.step(state)
    assert command.status is Status.OK, command.explanation
    values = [c.cone @ command.wrenches[c.name] for c in control.contacts]
    assert max(v.max() for v in values) < 1e-6
    assert any((v[16:] > -1e-6).any() for v in values)  # the rows beyond the sixteenth count
    names = [b.name for b in control.problem.blocks for _ in range(b.start, b.stop)]
    assert names.count("left_sole cone") == 32


def test_contacts_of_three_to_six_components_have_one_optimum_in_all_formulations():
    bot = robot("talos")
    state = standing_state(bot, 6)
    left = bot.soles[0]
    commands = []
    for formulation in wbc.Formulation:
        contacts = [
            wbc.SurfaceContact(left.name, left.half_length, left.half_width),
            LineContact("right_sole"),
        ]
        control = controller(bot, contacts, formulation=formulation)
        commands.append(control.step(state))
        assert commands[-1].status is Status.OK, commands[-1].explanation
        np.testing.assert_array_equal(commands[-1].wrenches["right_sole"][4:], 0.0)
    for other in commands[1:]:
        np.testing.assert_allclose(commands[0].acceleration, other.acceleration, atol=1e-6)
        np.testing.assert_allclose(
            commands[0].wrenches["right_sole"], other.wrenches["right_sole"], atol=1e-4
        )


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"motion_size": 2}, "motion_size 2 must be from 3"),
        ({"make_cone": lambda self, mu: np.zeros((6, 3))}, r"shape \(6, 3\); it must be .*4"),
        ({"make_cone": lambda self, mu: np.full((6, 4), np.nan)}, "must be finite"),
        ({"cone_labels": ("one",)}, "1 cone_labels for 6 rows"),
    ],
)
def test_a_contact_of_inconsistent_sizes_is_refused(change, text):
    kind = type("Bad", (LineContact,), change)
    control = wbc.WholeBodyController(robot("talos"))
    with pytest.raises(ContactError, match=text):
        control.set_contacts([kind("left_sole")])
    assert control.contacts == ()


def test_a_cone_whose_number_of_rows_changes_is_refused():
    class Changing(SixteenSidedSole):
        def make_cone(self, mu):
            return super().make_cone(mu)[: 32 if mu > 0.2 else 20]

        @property
        def cone_labels(self):
            return super().cone_labels[: len(self.cone)]

    bot = robot("talos")
    contacts = soles(Changing, bot)
    control = controller(bot, contacts, formulation=wbc.Formulation.COMPILED)
    control.step(bot.standing())
    contacts[0].friction = 0.1
    with pytest.raises(ContactError, match="its cone had 32 rows and has 20"):
        control.step(bot.standing())
