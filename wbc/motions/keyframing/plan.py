"""The plan of a keyframe motion: smooth references of the whole body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from wbc.errors import did_you_mean
from wbc.ik.objective import PostureObjective, PostureSolution
from wbc.ik.posture_ik import PostureIK
from wbc.motions.keyframing.keyframe import COM, FileValue, Keyframe, KeyframeError
from wbc.motions.keyframing.spline import Spline
from wbc.robot import Robot
from wbc.robot.upper_body import Side

_KNOT_SPACING = 0.1  # s between the postures that are computed for positions
_MAX_ERROR = 0.003  # m
#: Posture, CoM, torso and pelvis at one time.
References = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]

_SOLE_OFFSET, _SOLE_TILT = 0.005, 0.02  # m, rad: tolerances between posture and ground


@dataclass(frozen=True)
class KeyframePlan:
    """References over time, at rest at both ends; in the standing frame.

    Attributes:
        duration: s.
        posture: time -> (na,) joint positions, rad.
        com: time -> (3,) offset of the CoM, m.
        torso: time -> (3,) rotation vector of the upper trunk, rad.
        pelvis: time -> (3,) rotation vector of the root link, rad.
        places: side -> time -> (3,) position of the hand, m.
    """

    duration: float
    posture: Spline
    com: Spline
    torso: Spline
    pelvis: Spline
    places: Mapping[Side, Spline]

    def __repr__(self) -> str:
        hands = "".join(f", {side} hand led" for side in self.places)
        return f"KeyframePlan({self.duration:g} s, {self.posture.times.size} knots{hands})"


class KeyframePlanner:
    """Plans the keyframes of one file for one robot.

    Args:
        robot: the robot.
        frames: the keyframes in the order of time.
        source: name of the file, for messages.

    Raises:
        KeyframeError: a name that the robot does not have, or names that contradict each other.
    """

    def __init__(self, robot: Robot, frames: Sequence[Keyframe], source: str) -> None:
        self.robot = robot
        self.frames = frames
        self.source = source
        self._ik = PostureIK(robot)
        self._hands = {f"{arm.side}_hand": arm for arm in self._ik.upper_body.arms}
        self._hands |= {arm.hand: arm for arm in self._ik.upper_body.arms}
        self._check_names()
        self.joints = self._joint_splines()
        self._legs = {j - 6 for leg in robot.legs for j in leg}
        self.places = self._place_splines()
        self._check_contradictions()
        self.duration = frames[-1].time.number

    def plan(self) -> KeyframePlan:
        """Return the references.

        Raises:
            KeyframeError: a position out of reach, or a posture that lifts a sole.
        """
        times = [0.0]
        for before, after in pairwise([0.0, *(f.time.number for f in self.frames)]):
            steps = max(1, round((after - before) / _KNOT_SPACING))
            times += list(np.linspace(before, after, steps + 1)[1:])
        q = self._ik.standing.q
        rows = []
        for time in times:
            q = np.concatenate((q[:7], self._joint_positions(time, q[7:])))
            row, q = self._solved(time, q) if self.places else self._from_joints(time, q)
            rows.append(row)
        knots = np.array(times)
        posture, com, torso, pelvis = (
            Spline(knots, np.array(column)) for column in zip(*rows, strict=True)
        )
        return KeyframePlan(self.duration, posture, com, torso, pelvis, self._hand_splines())

    def place_on_soles(self, posture: np.ndarray) -> np.ndarray:
        """Return the posture (nq,) of joint positions (na,) with the left sole where it stands."""
        q = np.concatenate((self._ik.standing.q[:7], posture))
        return self._ik.place_on_left_sole(q)[0]

    def value_at(self, joint: int, time: float) -> FileValue:
        """Return the value of the file that determines a joint at a time, s."""
        name = self.robot.joint_names[joint]
        after = [f for f in self.frames if f.time.number >= time - 1e-9] or [self.frames[-1]]
        for frame in after:
            if name in frame.joints:
                return frame.joints[name]
        for arm in self._hands.values():
            for key, place in after[0].places.items():
                if joint in arm.joints and self._hands.get(key) is arm:
                    return place[0]
        return after[0].time

    def _check_names(self) -> None:
        robot = self.robot
        for frame in self.frames:
            for name, value in frame.joints.items():
                if name not in robot.joint_names:
                    hint = did_you_mean(name, robot.joint_names)
                    text = f"{robot.name} has no joint '{name}'{hint}"
                    raise KeyframeError(self.source, value.where, text)
                slides = robot.model.joints[robot.model.getJointId(name)].shortname()
                quantity = "length" if slides.startswith("JointModelP") else "angle"
                if value.quantity != quantity:
                    text = f"joint '{name}' is stated as a {value.quantity}; it has an {quantity}"
                    raise KeyframeError(self.source, value.where, text)
            for name, (x, _, _) in frame.places.items():
                if name != COM and name not in self._hands:
                    known = [COM, *self._hands]
                    text = f"{robot.name} has no hand '{name}'{did_you_mean(name, known)}"
                    raise KeyframeError(self.source, x.where, text)

    def _check_contradictions(self) -> None:
        for frame in self.frames:
            for name, value in frame.joints.items():
                joint = self.robot.joint_index(name)
                led = [s for s in self.places if s in self._hands and joint in self._arm(s)]
                if led:
                    text = f"joint '{name}' cannot be given while '{led[0]}' is led to places"
                    raise KeyframeError(self.source, value.where, text)
                if joint in self._legs and self.places:
                    text = f"joint '{name}' of a leg cannot be given along with places"
                    raise KeyframeError(self.source, value.where, text)

    def _arm(self, name: str) -> tuple[int, ...]:
        return self._hands[name].joints

    def _joint_splines(self) -> dict[int, Spline]:
        splines = {}
        home = self.robot.q_nominal[7:]
        for name in dict.fromkeys(name for frame in self.frames for name in frame.joints):
            joint = self.robot.joint_index(name)
            keyed = [frame for frame in self.frames if name in frame.joints]
            times = [0.0, *(frame.time.number for frame in keyed)]
            values = [home[joint], *(frame.joints[name].number for frame in keyed)]
            splines[joint] = Spline(np.array(times), np.array(values)[:, None])
        return splines

    def _place_splines(self) -> dict[str, Spline]:
        splines = {}
        for name in dict.fromkeys(name for frame in self.frames for name in frame.places):
            home = np.zeros(3) if name == COM else self._home(name)
            keyed = [frame for frame in self.frames if name in frame.places]
            times = [0.0, *(frame.time.number for frame in keyed)]
            places = [home, *([v.number for v in frame.places[name]] for frame in keyed)]
            splines[name] = Spline(np.array(times), np.array(places))
        return splines

    def _home(self, name: str) -> np.ndarray:
        return self._ik.frame_position(self._hands[name].hand, self._ik.standing.q)

    def _hand_splines(self) -> dict[Side, Spline]:
        return {
            self._hands[name].side: spline for name, spline in self.places.items() if name != COM
        }

    def _joint_positions(self, time: float, posture: np.ndarray) -> np.ndarray:
        posture = posture.copy()
        for joint, spline in self.joints.items():
            posture[joint] = spline(time)[0]
        return posture

    def _solved(self, time: float, q: np.ndarray) -> tuple[References, np.ndarray]:
        """Return references and posture for hands and CoM at their positions, joints as given."""
        objective = PostureObjective(
            com=self.places[COM](time) if COM in self.places else np.zeros(3),
            hands={self._hands[n].hand: s(time) for n, s in self.places.items() if n != COM},
            fixed_joints=tuple(self.joints),
            strict_com=True,
        )
        posture = self._ik.solve(objective, q, restarts=0)
        for name in self.places:
            if name == COM:
                continue
            if posture.hand_errors[self._hands[name].hand] > _MAX_ERROR:
                raise self._out_of_reach(name, time, posture)
        if COM in self.places and posture.com_error > _MAX_ERROR:
            stops = self._ik.limiting_joints(posture)
            text = f"'{COM}' at {time:.2f} s is off by {1e3 * posture.com_error:.0f} mm: {stops}"
            raise self._place_error(COM, time, text)
        return (posture.q[7:], posture.com, posture.torso, posture.pelvis), posture.q

    def _out_of_reach(self, name: str, time: float, posture: PostureSolution) -> KeyframeError:
        """Return an error about the keyframe's own position rather than one on the way there."""
        hand = self._hands[name].hand
        place, miss = self.places[name](time), posture.hand_errors[hand]
        after = next(
            (f for f in self.frames if name in f.places and f.time.number >= time), self.frames[-1]
        )
        goal = np.array([v.number for v in after.places[name]])
        there = self._ik.solve(PostureObjective(hands={hand: goal}, strict_com=True), posture.q)
        if there.hand_error > _MAX_ERROR:
            time, place, miss = after.time.number, goal, there.hand_error
            posture = there
        at = " ".join(f"{x:.2f}" for x in place)
        text = f"'{name}' at {time:.2f} s: ({at}) m is out of reach by {1e3 * miss:.0f} mm"
        text += f": {self._ik.limits_of_reach(posture)}"
        return self._place_error(name, time, text)

    def _place_error(self, name: str, time: float, text: str) -> KeyframeError:
        keyed = [frame for frame in self.frames if name in frame.places]
        after = [f for f in keyed if f.time.number >= time - 1e-9] or keyed[-1:]
        return KeyframeError(self.source, after[0].places[name][0].where, text)

    def _from_joints(self, time: float, q: np.ndarray) -> tuple[References, np.ndarray]:
        """Return references and posture with CoM and trunk as the joints place them."""
        q, miss, tilt = self._ik.place_on_left_sole(q)
        if miss > _SOLE_OFFSET or tilt > _SOLE_TILT:
            leg = min(self._legs & set(self.joints), default=0)
            where = self.value_at(leg, time).where
            text = (
                f"the posture at {time:.2f} s lifts or turns a sole by {1e3 * miss:.0f} mm, "
                f"{np.rad2deg(tilt):.1f}°: both legs must keep the soles on the ground"
            )
            raise KeyframeError(self.source, where, text)
        com, torso, pelvis = self._ik.com_and_trunk(q)
        if not self._legs & set(self.joints):
            com = np.zeros(3)  # arms move the CoM, balance moves it back
        return (q[7:], com, torso, pelvis), q
