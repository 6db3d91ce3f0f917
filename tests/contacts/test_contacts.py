"""The wrench cone is exact, and contacts refuse what makes no sense."""

import numpy as np
import pinocchio as pin
import pytest
from coretools import many, random_state, robot, some
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

import wbc
from wbc.contacts.surface import CONE_LABELS, wrench_cone
from wbc.errors import ContactError, FrameNotFound

lengths = st.floats(0.02, 0.3)
frictions = st.floats(0.1, 1.2)


def corner_map(X: float, Y: float) -> np.ndarray:
    """(6, 12) forces at the four corners to the wrench at the centre."""
    return np.hstack(
        [
            np.vstack((np.eye(3), pin.skew(np.array([x, y, 0.0]))))
            for x, y in ((X, Y), (X, -Y), (-X, Y), (-X, -Y))
        ]
    )


def corner_pyramids(mu: float) -> np.ndarray:
    """(16, 12) rows of the four corner friction pyramids."""
    pyramid = [[1, 0, -mu], [-1, 0, -mu], [0, 1, -mu], [0, -1, -mu]]
    return np.kron(np.eye(4), pyramid)


@many
@given(lengths, lengths, frictions, st.integers(0, 2**31))
def test_forces_in_the_corner_pyramids_give_a_wrench_in_the_cone(X, Y, mu, seed):
    rng = np.random.default_rng(seed)
    fz = rng.exponential(1.0, 4) * (rng.random(4) < 0.7)
    sides = rng.uniform(-1.0, 1.0, (4, 2))
    sides[rng.random((4, 2)) < 0.4] = rng.choice([-1.0, 1.0])
    forces = np.column_stack((mu * sides * fz[:, None], fz)).ravel()
    assert (corner_pyramids(mu) @ forces).max() <= 1e-12
    wrench = corner_map(X, Y) @ forces
    assert (wrench_cone(X, Y, mu) @ wrench).max() <= 1e-12


@many
@given(lengths, lengths, frictions, st.integers(0, 2**31))
def test_a_wrench_is_in_the_cone_exactly_when_corner_forces_can_make_it(X, Y, mu, seed):
    """Each wrench is scaled onto the cone's surface: a bit inside works, a bit outside not."""
    rng = np.random.default_rng(seed)
    side = rng.standard_normal(6) * np.array([mu, mu, 0.0, Y, X, mu * (X + Y)])
    centre = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    cone = wrench_cone(X, Y, mu)
    along = cone @ side
    if along.max() < 1e-3:
        return
    reach = np.min((-cone @ centre)[along > 1e-12] / along[along > 1e-12])

    def representable(wrench: np.ndarray) -> bool:
        found = linprog(
            np.zeros(12),
            A_ub=corner_pyramids(mu),
            b_ub=np.zeros(16),
            A_eq=corner_map(X, Y),
            b_eq=wrench,
            bounds=(None, None),
        )
        return found.status == 0

    for scale, inside in ((0.999, True), (1.001, False)):
        assert representable(centre + scale * reach * side) is inside


def test_cone_rows_have_descriptive_labels():
    X, Y, mu = 0.1, 0.05, 0.5
    cone = wrench_cone(X, Y, mu)
    assert len(CONE_LABELS) == len(cone)

    def broken(force, at=(0.0, 0.0)) -> str:
        wrench = np.concatenate((force, np.cross((*at, 0.0), force)))
        return CONE_LABELS[int(np.argmax(cone @ wrench))]

    assert broken((0.0, 0.0, 1.0), (0.2, 0.0)) == "cop front edge"
    assert broken((0.0, 0.0, 1.0), (-0.2, 0.0)) == "cop rear edge"
    assert broken((0.0, 0.0, 1.0), (0.0, 0.1)) == "cop left edge"
    assert broken((0.0, 0.0, 1.0), (0.0, -0.1)) == "cop right edge"
    assert broken((1.0, 0.0, 1.0)) == "friction +x"
    assert broken((0.0, -1.0, 1.0)) == "friction -y"
    assert "yaw torque" in CONE_LABELS[int(np.argmax(cone @ np.array([0, 0, 1, 0, 0, 0.2])))]


def test_the_pyramid_lies_within_the_friction_cone():
    contact = wbc.PointContact("left_sole", friction=0.7)
    corner = np.array([0.7 / np.sqrt(2.0), 0.7 / np.sqrt(2.0), 1.0])
    assert (contact.cone @ corner).max() == pytest.approx(0.0, abs=1e-12)
    assert np.hypot(*corner[:2]) == pytest.approx(0.7)


@some
@given(st.sampled_from(("talos", "g1")), st.integers(0, 2**31))
def test_motion_rows_bring_the_contact_frame_to_rest(name, seed):
    bot = robot(name)
    state = random_state(bot, seed)
    contact = wbc.SurfaceContact("right_sole", 0.1, 0.05, damping=17.0)
    contact.bind(bot)
    J, a = np.zeros((6, bot.nv)), np.zeros(6)
    contact.write(wbc.Kinematics(bot, state), J, a)
    acceleration = np.linalg.lstsq(J, a, rcond=None)[0]
    data = bot.model.createData()
    pin.forwardKinematics(bot.model, data, state.q, state.v, acceleration)
    frame = bot.frame_id("right_sole")
    v = pin.getFrameVelocity(bot.model, data, frame, pin.LOCAL).vector
    got = pin.getFrameClassicalAcceleration(bot.model, data, frame, pin.LOCAL).vector
    np.testing.assert_allclose(got, -17.0 * v, atol=1e-9)


def test_a_sole_contact_is_smaller_by_its_margin():
    sole = robot("talos").sole("left")
    contact = wbc.SurfaceContact.from_sole(sole, margin=0.01, friction=0.5)
    assert contact.frame == "left_sole"
    assert contact.half_length == pytest.approx(sole.half_length - 0.01)
    assert contact.half_width == pytest.approx(sole.half_width - 0.01)
    with pytest.raises(ContactError, match=r"half_length .* must be positive"):
        wbc.SurfaceContact.from_sole(sole, margin=1.0)


def test_a_changed_friction_changes_the_cone():
    contact = wbc.SurfaceContact("left_sole", 0.1, 0.05, friction=0.6)
    before = contact.cone
    assert contact.cone is before
    contact.friction = 0.3
    np.testing.assert_array_equal(contact.cone, wrench_cone(0.1, 0.05, 0.3 / np.sqrt(2.0)))


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"friction": 0.0}, r"contact 'left_sole': friction 0.0 must be positive"),
        ({"friction": np.nan}, "friction nan must be positive and finite"),
        ({"motion_weight": -1.0}, "motion_weight -1.0 must be positive.*None for exact"),
        ({"motion_weight": np.inf}, "motion_weight inf must be positive and finite"),
        ({"damping": -2.0}, "damping -2.0 must be finite and not negative"),
        ({"min_force": 5.0, "max_force": 1.0}, r"min_force \(5.0\) ≤ max_force \(1.0\)"),
        ({"min_force": -1.0}, r"0 ≤ min_force \(-1.0\)"),
        ({"half_width": 0.0}, "half_width 0.0 must be positive.*PointContact"),
    ],
)
def test_an_invalid_contact_is_refused(change, text):
    values = {"half_length": 0.1, "half_width": 0.05, **change}
    with pytest.raises(ContactError, match=text):
        wbc.SurfaceContact("left_sole", **values)


def test_a_missing_frame_lists_near_names():
    with pytest.raises(FrameNotFound, match=r"'left_sole_lnk'.*did you mean 'left_sole"):
        wbc.PointContact("left_sole_lnk").bind(robot("talos"))
