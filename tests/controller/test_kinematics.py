"""`Kinematics` agrees with Pinocchio's standard calls and with finite differences."""

import numpy as np
import pinocchio as pin
import pytest
from coretools import ROBOTS, few, random_state, robot, robots, seeds, some
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.errors import FrameNotFound, StateError

WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
LOCAL = pin.ReferenceFrame.LOCAL


def frame_names(model: pin.Model) -> list[str]:
    return [f.name for f in model.frames[1:] if f.type in (pin.BODY, pin.OP_FRAME)]


def moved(model: pin.Model, state: wbc.State, dt: float) -> wbc.State:
    """The state after dt at constant generalised velocity."""
    return wbc.State(pin.integrate(model, state.q, dt * state.v), state.v)


@some
@given(robots, seeds)
def test_dynamics_and_centroidal_quantities_equal_pinocchios(name, seed):
    bot = robot(name)
    model, state = bot.model, random_state(bot, seed)
    kin = wbc.Kinematics(bot, state)
    data = model.createData()
    pin.computeAllTerms(model, data, state.q, state.v)
    np.testing.assert_allclose(kin.mass_matrix, data.M, atol=1e-10)
    np.testing.assert_allclose(kin.bias_forces, data.nle, atol=1e-9)
    p_com = pin.centerOfMass(model, data, state.q, state.v)
    np.testing.assert_allclose(kin.p_com, p_com, atol=1e-12)
    np.testing.assert_allclose(kin.v_com, data.vcom[0], atol=1e-12)
    np.testing.assert_allclose(
        kin.J_com, pin.jacobianCenterOfMass(model, data, state.q), atol=1e-12
    )
    pin.ccrba(model, data, state.q, state.v)
    np.testing.assert_allclose(kin.J_angular, data.Ag[3:], atol=1e-10)
    np.testing.assert_allclose(kin.centroidal_momentum, data.hg.vector, atol=1e-10)
    np.testing.assert_allclose(kin.angular_momentum, data.hg.angular, atol=1e-10)
    pin.computeCentroidalMomentumTimeVariation(model, data, state.q, state.v, np.zeros(model.nv))
    np.testing.assert_allclose(kin.bias_com * kin.mass, data.dhg.linear, atol=1e-8)
    np.testing.assert_allclose(kin.bias_angular, data.dhg.angular, atol=1e-8)
    assert kin.mass == pytest.approx(bot.mass)


@some
@given(robots, seeds, st.integers(0, 10**6))
def test_frames_equal_pinocchios(name, seed, pick):
    bot = robot(name)
    model, state = bot.model, random_state(bot, seed)
    names = frame_names(model)
    frame = names[pick % len(names)]
    kin = wbc.Kinematics(bot, state)
    data = model.createData()
    pin.forwardKinematics(model, data, state.q, state.v, np.zeros(model.nv))
    pin.computeJointJacobians(model, data, state.q)
    pin.updateFramePlacements(model, data)
    fid = bot.frame_id(frame)
    np.testing.assert_allclose(kin.frame(frame).homogeneous, data.oMf[fid].homogeneous, atol=1e-12)
    for at, axes in ((kin.motion(frame), WORLD), (kin.motion_local(frame), LOCAL)):
        np.testing.assert_allclose(
            at.jacobian, pin.getFrameJacobian(model, data, fid, axes), atol=1e-12
        )
        velocity = pin.getFrameVelocity(model, data, fid, axes).vector
        np.testing.assert_allclose(at.velocity, velocity, atol=1e-12)
        bias = pin.getFrameClassicalAcceleration(model, data, fid, axes).vector
        np.testing.assert_allclose(at.bias, bias, atol=1e-11)
    np.testing.assert_array_equal(kin.jacobian(frame), kin.motion(frame).jacobian)


@few
@given(robots, seeds)
def test_jacobians_are_derivatives_of_com_and_frame_position(name, seed):
    bot = robot(name)
    state = random_state(bot, seed)
    kin = wbc.Kinematics(bot, state)
    dt = 1e-6
    after = wbc.Kinematics(bot, moved(bot.model, state, dt))
    before = wbc.Kinematics(bot, moved(bot.model, state, -dt))
    v_com = (after.p_com - before.p_com) / (2 * dt)
    np.testing.assert_allclose(kin.J_com @ state.v, v_com, atol=1e-7)
    sole = [k.frame("left_sole") for k in (before, after)]
    v = (sole[1].translation - sole[0].translation) / (2 * dt)
    np.testing.assert_allclose((kin.jacobian("left_sole") @ state.v)[:3], v, atol=1e-7)
    w = pin.log3(sole[1].rotation @ sole[0].rotation.T) / (2 * dt)
    np.testing.assert_allclose((kin.jacobian("left_sole") @ state.v)[3:], w, atol=1e-7)


@few
@given(robots, seeds)
def test_bias_accelerations_are_derivatives_at_zero_acceleration(name, seed):
    bot = robot(name)
    state = random_state(bot, seed)
    kin = wbc.Kinematics(bot, state)
    dt = 1e-5
    after = wbc.Kinematics(bot, moved(bot.model, state, dt))
    before = wbc.Kinematics(bot, moved(bot.model, state, -dt))

    def rate(of) -> np.ndarray:
        return (of(after) - of(before)) / (2 * dt)

    np.testing.assert_allclose(kin.bias_com, rate(lambda k: k.v_com), atol=1e-5)
    np.testing.assert_allclose(kin.bias_angular, rate(lambda k: k.angular_momentum), atol=1e-4)
    bias = rate(lambda k: k.motion("right_sole").velocity)
    np.testing.assert_allclose(kin.motion("right_sole").bias, bias, atol=1e-4)


@pytest.mark.parametrize("name", ROBOTS)
def test_an_updated_workspace_equals_a_fresh_one(name):
    bot = robot(name)
    kin = wbc.Kinematics(bot, random_state(bot, 1))
    kin.motion("left_sole"), kin.J_com  # cached values must not survive
    state = random_state(bot, 2)
    kin.update(state)
    fresh = wbc.Kinematics(bot, state)
    np.testing.assert_array_equal(kin.J_com, fresh.J_com)
    np.testing.assert_array_equal(kin.J_angular, fresh.J_angular)
    np.testing.assert_array_equal(kin.jacobian("left_sole"), fresh.jacobian("left_sole"))
    np.testing.assert_array_equal(
        kin.motion_local("left_sole").bias, fresh.motion_local("left_sole").bias
    )


def test_arrays_read_before_an_update_stay_unchanged():
    bot = robot("talos")
    kin = wbc.Kinematics(bot, random_state(bot, 1))
    kept = (kin.mass_matrix, kin.J_com, kin.p_com, kin.frame("torso_2_link").homogeneous)
    copies = [np.array(x) for x in kept]
    kin.update(random_state(bot, 2))
    for x, copy in zip(kept, copies, strict=True):
        np.testing.assert_array_equal(x, copy)


def test_a_missing_frame_lists_near_names():
    bot = robot("talos")
    with pytest.raises(FrameNotFound, match=r"'left_soul'.*did you mean 'left_sole'"):
        wbc.Kinematics(bot, bot.standing()).frame("left_soul")


@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda q, v: (q[:-1], v), r"state\.q has shape \(38,\), the model needs \(39,\)"),
        (lambda q, v: (q, v[None]), r"state\.v has shape \(1, 38\)"),
        (lambda q, v: (_with(q, 9, np.nan), v), r"state\.q\[9\].*leg_left_3_joint.* is nan"),
        (lambda q, v: (q, _with(v, 2, np.inf)), r"state\.v\[2\].* is inf"),
        (lambda q, v: (q, _with(v, 37, 1e300)), r"state\.v\[37\].*1e\+300"),
        (lambda q, v: (_with(q, 6, 2.0), v), r"quaternion of length 2.*normalise"),
        (lambda q, v: (np.zeros_like(q), v), r"quaternion of length 0"),
    ],
)
def test_an_invalid_state_is_refused_with_the_entry_named(change, text):
    bot = robot("talos")
    state = bot.standing()
    bad = wbc.State(*change(state.q, state.v))
    with pytest.raises(StateError, match=text):
        wbc.Kinematics(bot, bad)
    with pytest.raises(StateError, match=text):
        wbc.WholeBodyController(bot).step(bad)


def _with(x: np.ndarray, index: int, value: float) -> np.ndarray:
    changed = x.copy()
    changed[index] = value
    return changed


def test_kinematics_are_equivariant_to_position_and_heading():
    bot = robot("talos")
    state = random_state(bot, 5)
    move = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, np.pi / 2), np.array([100.0, -50.0, 3.0]))
    base = move * pin.XYZQUATToSE3(state.q[:7])
    there = wbc.State(np.concatenate((pin.SE3ToXYZQUAT(base), state.q[7:])), state.v)
    here, far = wbc.Kinematics(bot, state), wbc.Kinematics(bot, there)
    np.testing.assert_allclose(far.p_com, move.act(here.p_com), atol=1e-11)
    np.testing.assert_allclose(far.J_com, move.rotation @ here.J_com, atol=1e-11)
    np.testing.assert_allclose(far.mass_matrix, here.mass_matrix, atol=1e-8)
    np.testing.assert_allclose(far.bias_forces, here.bias_forces, atol=1e-8)


@pytest.mark.parametrize("name", ["talos", "simple_humanoid"])
def test_placements_and_velocities_of_joints_are_pinocchios_and_follow_the_state(name):
    bot = robot(name)
    kin, data = wbc.Kinematics(bot, bot.standing()), bot.model.createData()
    placements, velocities = kin.joint_placements, kin.joint_velocities
    for seed in range(2):
        state = random_state(bot, seed)
        kin.update(state)
        pin.forwardKinematics(bot.model, data, state.q, state.v)
        for joint in range(bot.model.njoints):
            expected = kin.data.oMi[joint]
            np.testing.assert_array_equal(placements[joint, :9].reshape(3, 3).T, expected.rotation)
            np.testing.assert_array_equal(placements[joint, 9:], expected.translation)
            np.testing.assert_allclose(velocities[joint], data.v[joint].vector, atol=1e-12)


def test_what_is_not_stored_in_a_row_is_copied_after_each_update(monkeypatch):
    bot = robot("simple_humanoid")
    kin, other = (wbc.Kinematics(bot, bot.standing()) for _ in range(2))
    monkeypatch.setattr(wbc.kinematics, "_SE3_BYTES", 128)
    monkeypatch.setattr(wbc.kinematics, "_MOTION_BYTES", 64)
    for seed in range(2):
        for each in (kin, other):
            each.update(random_state(bot, seed))
        copied = kin.joint_placements
        assert copied.flags.owndata
        assert copied.flags.c_contiguous
        np.testing.assert_array_equal(copied[:, 9:], [T.translation for T in other.data.oMi])
        np.testing.assert_array_equal(copied[1, :9].reshape(3, 3).T, other.base.rotation)
        assert kin.joint_velocities.flags.owndata
        velocities = [motion.vector for motion in other.data.v]
        np.testing.assert_array_equal(kin.joint_velocities, velocities)
