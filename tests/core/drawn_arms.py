"""Serial arms that hypothesis draws: their URDF, and their kinematics and weight worked out here from the same numbers
by SciPy's rotations, without Pinocchio."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from .drawn import numbers, vectors

TOOL = (0.02, -0.05, 0.1)


@dataclass(frozen=True)
class Joint:
    """A joint at `xyz`, turned by `rpy`, that slides along or turns about `axis`; the mass of the link behind it."""

    slides: bool
    xyz: np.ndarray
    rpy: np.ndarray
    axis: np.ndarray
    mass: float
    centre: np.ndarray


@dataclass(frozen=True)
class DrawnArm:
    joints: tuple[Joint, ...]

    def write(self, folder: Path) -> Path:
        path = folder / "arm.urdf"
        path.write_text(self.urdf(), encoding="utf-8")
        return path

    def urdf(self) -> str:
        parts = ['<robot name="drawn"><link name="link_0"/>']
        for i, joint in enumerate(self.joints, 1):
            parts.append(
                f'<joint name="joint_{i}" type="{"prismatic" if joint.slides else "revolute"}">'
                f'<parent link="link_{i - 1}"/><child link="link_{i}"/>'
                f'<origin xyz="{text(joint.xyz)}" rpy="{text(joint.rpy)}"/><axis xyz="{text(joint.axis)}"/>'
                f'<limit lower="-3" upper="3" effort="{10 * i}" velocity="1"/></joint>'
                f'<link name="link_{i}"><inertial><origin xyz="{text(joint.centre)}"/><mass value="{joint.mass!r}"/>'
                '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
            )
        parts.append(
            f'<link name="tool"/><joint name="flange" type="fixed"><parent link="link_{len(self.joints)}"/>'
            f'<child link="tool"/><origin xyz="{text(TOOL)}"/></joint></robot>'
        )
        return "\n".join(parts)

    def links(self, configuration: np.ndarray) -> list[tuple[Rotation, np.ndarray]]:
        """Rotation and position of each moving link in {r}."""
        rotation, position, found = Rotation.identity(), np.zeros(3), []
        for joint, value in zip(self.joints, configuration, strict=True):
            position = position + rotation.apply(joint.xyz)
            rotation = rotation * Rotation.from_euler("xyz", joint.rpy)
            if joint.slides:
                position = position + rotation.apply(value * joint.axis)
            else:
                rotation = rotation * Rotation.from_rotvec(value * joint.axis)
            found.append((rotation, position))
        return found

    def tool(self, configuration: np.ndarray) -> tuple[Rotation, np.ndarray]:
        rotation, position = self.links(configuration)[-1]
        return rotation, position + rotation.apply(TOOL)

    def potential(self, configuration: np.ndarray, gravity_r: np.ndarray) -> float:
        """Potential energy, J."""
        centres = [position + rotation.apply(j.centre) for (rotation, position), j in self.pairs(configuration)]
        return -sum(j.mass * float(gravity_r @ c) for j, c in zip(self.joints, centres, strict=True))

    def pairs(self, configuration: np.ndarray):
        return zip(self.links(configuration), self.joints, strict=True)


def text(values) -> str:
    return " ".join(repr(float(v)) for v in values)


def axes() -> st.SearchStrategy[np.ndarray]:
    return vectors(3, -1.0, 1.0).filter(lambda v: np.linalg.norm(v) > 0.1).map(lambda v: v / np.linalg.norm(v))


def joints() -> st.SearchStrategy[Joint]:
    return st.builds(
        Joint,
        st.booleans(),
        vectors(3, -0.5, 0.5),
        vectors(3, -3.0, 3.0),
        axes(),
        numbers(0.1, 9),
        vectors(3, -0.2, 0.2),
    )


def arms(most: int = 7) -> st.SearchStrategy[DrawnArm]:
    return st.lists(joints(), min_size=1, max_size=most).map(lambda drawn: DrawnArm(tuple(drawn)))
