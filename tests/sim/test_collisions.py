"""A robot collides with the ground and with itself."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from simtools import command, robot

from wbc.errors import PlantError
from wbc.robot import load
from wbc.robot.collision_shapes import SOLE_THICKNESS, collision_shapes
from wbc.sim import Mujoco, SensorNoise
from wbc.state import State

pytest.importorskip("mujoco")

QUIET = SensorNoise.none()


def energy(r, state: State) -> float:
    """Kinetic and potential energy, J."""
    data = r.model.createData()
    kinetic = pin.computeKineticEnergy(r.model, data, state.q, state.v)
    return float(kinetic + pin.computePotentialEnergy(r.model, data, state.q))


def lowest_point(r, plant: Mujoco) -> float:
    """Height of the lowest point of all shapes but the soles, m."""
    data = r.model.createData()
    pin.forwardKinematics(r.model, data, plant.ground_truth().q)
    heights = []
    for shape in plant.collision_shapes:
        T = data.oMi[shape.joint_id] * shape.placement
        if shape.kind == "hull":
            heights.append(float((shape.vertices @ T.rotation[2]).min() + T.translation[2]))
        if shape.kind == "sphere":
            heights.append(float(T.translation[2] - shape.size[0]))
    return min(heights)


@pytest.mark.parametrize("name", ["g1", "talos", "simple_humanoid"])
@pytest.mark.parametrize("direction", [(1.0, 0.3), (-0.3, -1.0)])
def test_limp_robot_falls_loses_energy_and_comes_to_rest_on_the_floor(name, direction):
    """Joint friction alone acts: no torque that would add energy."""
    r = robot(name)
    damping = 0.02 * r.tau_max
    with Mujoco(r, noise=QUIET) as plant:
        plant.push(0.5 * r.mass * np.array([*direction, 0.0]))
        energies, at_rest = [], 0
        for i in range(2500):
            v = plant.ground_truth().v
            plant.step(command(-np.clip(damping * v[6:], -0.2 * r.tau_max, 0.2 * r.tau_max)))
            if i >= 50:  # after the push
                energies.append(energy(r, plant.ground_truth()))
            at_rest = at_rest + 1 if np.linalg.norm(v[:6]) < 0.03 else 0
            if i > 500 and at_rest > 100:
                break
        assert at_rest > 100, "it does not come to rest"
        # The contacts are stiff springs: what they store for a moment comes back.
        assert np.diff(energies).max() < 5e-3 * energies[0]
        assert energies[-1] < 0.4 * energies[0]
        state = plant.ground_truth()
        assert state.q[2] < 0.5 * r.q_nominal[2]
        assert lowest_point(r, plant) > -0.01
        carried = sum(force for _, force in plant.contacts())
        np.testing.assert_allclose(carried, [0.0, 0.0, r.weight], atol=0.1 * r.weight)


def test_arms_meet_the_trunk_and_legs_each_other_unless_only_soles_collide():
    r = robot("g1")
    q = r.standing().q.copy()
    q[2] += 1.0
    q[7 + r.joint_index("left_hip_roll_joint")] = -0.4
    q[7 + r.joint_index("left_shoulder_roll_joint")] = -0.5
    with Mujoco(r) as plant:
        plant.reset(State(q, np.zeros(r.nv)))
        touching = {frozenset(pair) for pair in plant.self_contacts()}
    assert frozenset(("left_shoulder_yaw_joint", "waist_pitch_joint")) in touching
    assert any(all("knee" in name or "ankle" in name for name in pair) for pair in touching)
    with Mujoco(r, collisions="soles") as plant:
        plant.reset(State(q, np.zeros(r.nv)))
        assert not plant.collision_shapes
        assert {frozenset(p) for p in plant.self_contacts()} <= {
            frozenset(("left_ankle_roll_joint", "right_ankle_roll_joint"))
        }


def test_legs_that_swing_together_hit_each_other_and_conserve_momentum():
    r = robot("simple_humanoid")
    q, v = r.standing().q.copy(), np.zeros(r.nv)
    q[2] += 1.0
    for side, sign in (("left", -1.0), ("right", 1.0)):
        v[6 + r.joint_index(f"{side}_hip_roll")] = sign * 2.0
    start = State(q, v)
    touched = False
    with Mujoco(r, noise=QUIET) as plant:
        plant.reset(start)
        for _ in range(100):
            plant.step(command(np.zeros(r.na)))
            touched = touched or bool(plant.self_contacts())
        end = plant.ground_truth()
    assert touched
    apart = [end.v[6 + r.joint_index(f"{side}_hip_roll")] for side in ("left", "right")]
    assert abs(apart[0]) < 1.0, "the legs did not stop each other"
    data = r.model.createData()
    momenta = []
    for state in (start, end):
        pin.computeCentroidalMomentum(r.model, data, state.q, state.v)
        momenta.append(data.hg.vector.copy())
    # Forces inside of the robot move its parts, not the whole of it.
    fallen = np.array([0.0, 0.0, -9.81 * r.mass * 0.2, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(momenta[1], momenta[0] + fallen, atol=0.1)


@pytest.mark.parametrize("name", ["talos", "g1", "romeo", "icub", "simple_humanoid", "bolt"])
def test_no_bodies_touch_in_the_nominal_posture_and_the_soles_carry_it(name):
    r = load("bolt", left_foot="FL_FOOT", right_foot="FR_FOOT") if name == "bolt" else robot(name)
    with Mujoco(r, noise=QUIET) as plant:
        assert not plant.self_contacts()
        soles = {plant.model.geom(s.name).id for s in r.soles}
        touching = {int(g) for pair in plant.data.contact.geom for g in pair}
        assert touching - {plant.model.geom("floor").id} <= soles
        names = set(r.model.names)
        for pair in plant.excluded_pairs:
            assert {pair.first, pair.second} <= names
        # Bodies of different limbs keep colliding.
        legs = [{r.joint_names[i - 6] for i in leg} for leg in r.legs]
        for pair in plant.excluded_pairs:
            if pair.reason != "SRDF":
                assert not (pair.first in legs[0] and pair.second in legs[1])


def test_shapes_of_a_foot_begin_above_its_sole():
    for name in ("talos", "simple_humanoid", "icub"):
        r = robot(name)
        feet = {s.joint_id: s for s in r.soles}
        found = [shape for shape in collision_shapes(r) if shape.joint_id in feet]
        assert found
        for shape in found:
            sole = feet[shape.joint_id]
            T = sole.placement.inverse() * shape.placement
            height = shape.vertices @ T.rotation[2] + T.translation[2]
            assert height.min() == pytest.approx(SOLE_THICKNESS, abs=1e-9)


def test_heavy_bodies_without_collision_shapes_get_substitutes(tmp_path):
    """A description that gives shapes to the feet alone, and has no meshes."""
    text = robot("simple_humanoid").urdf_path.read_text(encoding="utf-8")
    head, *links = text.split("<link ")
    stripped = [
        link if "foot" in link.split(">")[0] else _without(_without(link, "collision"), "visual")
        for link in links
    ]
    path = tmp_path / "bare.urdf"
    path.write_text("<link ".join([head, *stripped]), encoding="utf-8")
    r = load(path, left_foot="left_foot", right_foot="right_foot")
    shapes = collision_shapes(r)
    boxes = {r.model.names[s.joint_id]: s for s in shapes if s.source == "inertia"}
    assert "torso_yaw" in boxes
    # The description's torso is a homogeneous box: its inertia gives its size back.
    np.testing.assert_allclose(sorted(boxes["torso_yaw"].size), [0.09, 0.16, 0.22], atol=1e-3)


def _without(text: str, tag: str) -> str:
    while f"<{tag}>" in text:
        before, _, rest = text.partition(f"<{tag}>")
        text = before + rest.partition(f"</{tag}>")[2]
    return text


def test_srdf_disables_pairs():
    with Mujoco(robot("talos")) as plant:
        disabled = {(p.first, p.second): p.reason for p in plant.excluded_pairs}
    assert disabled["arm_left_1_joint", "arm_left_2_joint"] == "adjacent"
    assert disabled["arm_left_1_joint", "arm_left_3_joint"] == "SRDF"


def test_unknown_collisions_are_refused():
    with pytest.raises(PlantError, match="soles"):
        Mujoco(robot(), collisions="none")
