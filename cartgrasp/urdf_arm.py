"""`UrdfArm`: an arm read from a URDF, standing beside a cart (extra `arms`, Pinocchio).

Frames: {b} cart, {r} root of the URDF, {t} the tool, {a} the contact frame at {t}'s origin with {b}'s axes turned by
a yaw. An arm that stands still and gives the wrench F_a to the cart holds its own weight and the reaction of F_a:

    tau = J_aᵀ F_a + tau_0,     tau_0 = gravity torque,    J_a (6, n): joint velocity -> [linear; angular] in {a}.

Joints that don't move the tool are held at zero. This is the only file that knows Pinocchio.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .checks import check_kind, listed
from .errors import FileError, Place, UsageError
from .frames import Array, rotation_z
from .joint_torques import JointTorques
from .spatial_pose import SpatialPose
from .wheels import GRAVITY

LEVEL_GRAVITY = (0.0, 0.0, -GRAVITY)
MAX_JOINT_RANGE = 1e3  # rad or m: what a joint has no more of
IDENTITY_POSE = SpatialPose.of((0.0, 0.0, 0.0))


class LinkMass(NamedTuple):
    """A mass (kg) with its centre (m, in the link's frame): of a link whose URDF has none, or of a mounted hand."""

    link: str
    mass: float
    centre: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class UrdfArm:
    """Read by `read_urdf_arm`, put in its place by `placed`. Configurations are (n,) in the order of `joints`, rad (m
    for a sliding joint). Arms of one reading share a workspace: each thread reads its own."""

    file: str
    joints: tuple[str, ...]
    lower: Array
    upper: Array
    torque_limit: Array
    _model: Any
    _tool: int
    pose_br: SpatialPose = IDENTITY_POSE
    gravity_b: tuple[float, float, float] = LEVEL_GRAVITY

    def placed(self, pose_br: SpatialPose, gravity_b: Sequence[float] = LEVEL_GRAVITY) -> UrdfArm:
        """This arm with its root elsewhere in {b}; gravity, m/s², is not along z where the floor slopes, and (0, 0, 0)
        leaves it out."""
        check_kind(f"{self.file}: pose_br", pose_br, SpatialPose, "write SpatialPose.of((x, y, z))")
        return replace(self, pose_br=pose_br, gravity_b=_gravity(self.file, gravity_b))

    @cached_property
    def _data(self) -> Any:
        return self._model.createData()

    def tool_pose_b(self, configuration: ArrayLike) -> SpatialPose:
        """pose_bt."""
        return SpatialPose(*self.tool_in_b(configuration))

    def tool_in_b(self, configuration: ArrayLike) -> tuple[Array, Array]:
        """pose_bt as a rotation (3, 3) and a position (3,), which nobody checks."""
        _library().framesForwardKinematics(self._model, self._data, self.checked(configuration))
        pose_rt, rotation_br = self._data.oMf[self._tool], self.pose_br.rotation
        return rotation_br @ pose_rt.rotation, rotation_br @ pose_rt.translation + self.pose_br.position

    def jacobian_a(self, configuration: ArrayLike, yaw: float = 0.0) -> Array:
        """J_a, shape (6, n)."""
        pinocchio = _library()
        jacobian_r = pinocchio.computeFrameJacobian(
            self._model, self._data, self.checked(configuration), self._tool, pinocchio.LOCAL_WORLD_ALIGNED
        )
        linear, angular = np.reshape(jacobian_r, (2, 3, -1))  # of a single joint it comes as (6,)
        rotation_ar = rotation_z(yaw).T @ self.pose_br.rotation
        return np.vstack([rotation_ar @ linear, rotation_ar @ angular])

    def gravity_torque(self, configuration: ArrayLike) -> Array:
        """Joint torques (n,) that carry the arm itself."""
        gravity_b, checked = np.array(self.gravity_b), self.checked(configuration)
        if gravity_b.any() and not any(inertia.mass for inertia in self._model.inertias.tolist()[1:]):
            raise UsageError(
                f"{self.file}: no moving link has a mass: give added_masses, or gravity_b=(0, 0, 0) to leave it out"
            )
        self._model.gravity.linear = self.pose_br.rotation.T @ gravity_b
        return np.array(_library().computeGeneralizedGravity(self._model, self._data, checked))

    def joint_torques(self, configuration: ArrayLike, yaw: float = 0.0) -> JointTorques:
        """All that limits the wrench at this posture; `yaw` is that of {a} in {b}."""
        names = tuple("_".join(re.split(r"[\s:]+", joint)) for joint in self.joints)
        jacobian, gravity = self.jacobian_a(configuration, yaw), self.gravity_torque(configuration)
        return JointTorques(jacobian, gravity, self.torque_limit, names)

    def checked(self, configuration: ArrayLike) -> Array:
        """The configuration as an array (n,), refused if it is none."""
        values = np.asarray(configuration, dtype=float)
        if values.shape != (len(self.joints),) or not np.isfinite(values).all():
            raise UsageError(
                f"{self.file}: a configuration is {len(self.joints)} finite numbers ({', '.join(self.joints)}), "
                f"not {values.tolist()}"
            )
        return values


def read_urdf_arm(
    path: str | Path, tool: str, *, torque_limit: Sequence[float] | None = None, added_masses: Sequence[LinkMass] = ()
) -> UrdfArm:
    """The arm whose tool is the link `tool`, with its root in {b}'s origin. `torque_limit` (n,), N·m, replaces the
    URDF's efforts, and is needed where these are 0."""
    file = str(path)
    model = _reduced(_parsed(file), tool, file)
    for added in listed(f"{file}: added_masses", added_masses, LinkMass, "write [LinkMass(link, mass, centre)]"):
        _add_mass(model, added, file)
    joints = tuple(model.names)[1:]
    lower, upper = np.array(model.lowerPositionLimit), np.array(model.upperPositionLimit)
    for joint, low, high in zip(joints, lower, upper, strict=True):
        if not 0 < high - low <= MAX_JOINT_RANGE:
            raise UsageError(f"{file}: joint {joint}: no range: lower {low:g}, upper {high:g}")
    return UrdfArm(file, joints, lower, upper, _torque_limit(model, torque_limit, file), model, _link(model, tool))


def rotation_vector(rotation: Array) -> Array:
    """log R (3,) of a rotation (3, 3), rad; in a twentieth of the time that SciPy takes."""
    return np.array(_library().log3(rotation))


def _parsed(file: str) -> Any:
    pinocchio = _library()
    try:
        text = Path(file).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(Place(file), "", f"can't be read: {error}") from error
    try:
        return pinocchio.buildModelFromXML(text)
    except ValueError as error:
        raise FileError(Place(file), "", f"is no URDF (xacro must be expanded first): {error}") from error


def _reduced(model: Any, tool: str, file: str) -> Any:
    """The model with only the joints that move the tool."""
    pinocchio = _library()
    links = [frame.name for frame in model.frames if frame.type == pinocchio.FrameType.BODY]
    if tool not in links:
        raise UsageError(f"{file}: tool: no link is called {tool!r}; there are {', '.join(links)}")
    moving = set(model.supports[model.frames[_link(model, tool)].parentJoint]) - {0}
    if not moving:
        raise UsageError(f"{file}: tool: no joint moves {tool!r}")
    endless = [model.names[joint] for joint in moving if model.joints[joint].nq != 1]
    if endless:
        raise UsageError(f"{file}: joint {endless[0]}: give it limits; only revolute and prismatic joints are known")
    held = [joint for joint in range(1, model.njoints) if joint not in moving]
    try:
        return pinocchio.buildReducedModel(model, held, pinocchio.neutral(model)) if held else model
    except ValueError as error:  # where a joint is called as a link is
        raise UsageError(f"{file}: joints that don't move {tool!r} can't be held: {error}") from error


def _add_mass(model: Any, added: LinkMass, file: str) -> None:
    pinocchio = _library()
    if not model.existBodyName(added.link):
        raise UsageError(f"{file}: added_masses: no link is called {added.link!r}")
    centre = np.array(added.centre, dtype=float)
    if not (np.isfinite(added.mass) and added.mass >= 0 and centre.shape == (3,) and np.isfinite(centre).all()):
        raise UsageError(f"{file}: added_masses: {added} needs a finite mass >= 0 and a finite centre (3,)")
    frame = model.frames[_link(model, added.link)]
    inertia = pinocchio.Inertia(added.mass, centre, np.zeros((3, 3)))
    model.appendBodyToJoint(frame.parentJoint, inertia, frame.placement)


def _link(model: Any, name: str) -> int:
    return int(model.getFrameId(name, _library().FrameType.BODY))  # a joint may be called as a link is


def _torque_limit(model: Any, given: Sequence[float] | None, file: str) -> Array:
    limit = np.array(model.effortLimit if given is None else given, dtype=float)
    if limit.shape != (model.nv,):
        raise UsageError(f"{file}: torque_limit: {model.nv} numbers are needed, {limit.size} given")
    wrong = np.flatnonzero(~(limit > 0))
    if wrong.size:
        joint = model.names[1 + int(wrong[0])]
        raise UsageError(f"{file}: joint {joint}: torque limit {limit[wrong[0]]:g} is not > 0; give torque_limit")
    return limit


def _library() -> Any:
    try:
        import pinocchio
    except ImportError as error:
        raise UsageError("arms from a URDF need Pinocchio: in cartgrasp's clone, pip install '.[arms]'") from error
    return pinocchio


def _gravity(file: str, gravity_b: Sequence[float]) -> tuple[float, float, float]:
    values = np.asarray(gravity_b, dtype=float)
    if values.shape != (3,) or not np.isfinite(values).all():
        raise UsageError(f"{file}: gravity_b: {values.tolist()} is not three finite numbers, m/s²")
    return (float(values[0]), float(values[1]), float(values[2]))
