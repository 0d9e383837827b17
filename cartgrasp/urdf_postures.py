"""`UrdfPostures`: the postures of an arm from a URDF at the contacts where its hand holds (extra `arms`).

A posture is sought once for each contact, as long as the arm's base stands where it stood: from the one that was last
found there, else from that of the nearest contact, so that a hand that goes a little way takes its posture along.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from numpy.typing import ArrayLike

from .arm_postures import Posture, find_posture
from .checks import check_kind, digits, numbers
from .errors import UsageError
from .joint_torques import JointTorques, Point
from .spatial_pose import SpatialPose
from .urdf_arm import UrdfArm

MAX_CACHED_POSTURES = 1000
"""Contacts at which postures are remembered at most."""
ROLL_PITCH_YAW_FORM = "(roll, pitch, yaw), rad"


class UrdfPostures:
    """What to give as `joints` of an `Arm`, whose limits then are those of its posture of now.

    Args:
        arm: Placed where its root stands in {b}; see `place` for a base that moves in {b}.
        hand: Roll, pitch and yaw (rad, as in URDF) of the tool in {b}, at every contact.
        start: The configuration (n,) from which the first posture is sought; the middle of the joints' ranges, then
            drawn ones, unless given.

    Raises:
        UsageError: `hand` is no three angles, or `start` no configuration of the arm.
    """

    def __init__(self, arm: UrdfArm, hand: Sequence[float] = (0.0, 0.0, 0.0), start: ArrayLike | None = None) -> None:
        check_kind("urdf postures: arm", arm, UrdfArm, 'read it first: read_urdf_arm("arm.urdf", "tool")')
        self._hand = numbers("urdf postures: hand", hand, ROLL_PITCH_YAW_FORM, -math.tau, math.tau)
        self._arm, self._start = arm, None if start is None else arm.checked(start)
        self._here: dict[Point, Posture] = {}
        self._before: dict[Point, Posture] = {}
        self._joints: dict[tuple[Point, float], JointTorques] = {}

    def place(self, pose_br: SpatialPose) -> None:
        """From now on the arm's root stands there in {b}: postures are sought anew, each from what it was."""
        self._arm = self._arm.placed(pose_br, self._arm.gravity_b)
        self._before, self._here, self._joints = self._here or self._before, {}, {}

    def posture(self, contact: Point) -> Posture:
        """With the tool at a contact in {b}, or as near as was found: look at `reached`."""
        if contact not in self._here:
            if len(self._here) >= MAX_CACHED_POSTURES:
                self.place(self._arm.pose_br)
            self._here[contact] = self._sought(contact)
        return self._here[contact]

    def joints_at(self, contact: Point, yaw: float) -> JointTorques:
        """What the joints bear at that posture."""
        key = contact, yaw
        if key not in self._joints:
            posture = self.posture(contact)
            if not posture.reached:
                away = f"{posture.position_error:.3g} m and {posture.rotation_error:.3g} rad away"
                raise UsageError(f"no posture was found with the hand at {digits(contact)}; the nearest stays {away}")
            self._joints[key] = self._arm.joint_torques(posture.configuration, yaw)
        return self._joints[key]

    def _sought(self, contact: Point) -> Posture:
        target = SpatialPose.of(contact, *self._hand)
        reached = {point: posture for point, posture in (self._before | self._here).items() if posture.reached}
        if not reached:
            return find_posture(self._arm, target, self._start)
        nearest = min(reached, key=lambda point: math.dist(point, contact))
        return find_posture(self._arm, target, reached[nearest].configuration, restarts=0)
