"""`SpatialPose`: where one frame stands in another, in space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .errors import UsageError
from .frames import Array, rotation_z

ORTHONORMAL_TOLERANCE = 1e-9
"""How far `R Rᵀ` may be from the identity: far above rounding, far below any mistake."""


@dataclass(frozen=True, eq=False)
class SpatialPose:
    """`pose_ab`, the pose of {b} in {a}: a rotation (3, 3) and the position (3,) of {b}'s origin, m."""

    rotation: Array
    position: Array

    def __post_init__(self) -> None:
        for field, shape in (("rotation", (3, 3)), ("position", (3,))):
            values = np.array(getattr(self, field), dtype=float)
            if values.shape != shape or not np.isfinite(values).all():
                raise UsageError(f"pose: {field}: {values.tolist()} is not {shape} finite numbers")
            values.setflags(write=False)
            object.__setattr__(self, field, values)
        if (
            np.abs(self.rotation @ self.rotation.T - np.eye(3)).max() > ORTHONORMAL_TOLERANCE
            or np.linalg.det(self.rotation) < 0
        ):
            raise UsageError(f"pose: rotation: {self.rotation.tolist()} is not a right-handed rotation")

    @classmethod
    def of(cls, position: ArrayLike, roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> SpatialPose:
        """At a position, turned by roll about x, then pitch about y, then yaw about z of the fixed frame (as in URDF),
        rad."""
        about_x = rotation_z(roll)[np.ix_((2, 0, 1), (2, 0, 1))]
        about_y = rotation_z(pitch)[np.ix_((1, 2, 0), (1, 2, 0))]
        return cls(rotation_z(yaw) @ about_y @ about_x, np.asarray(position, dtype=float))

    def __matmul__(self, other: SpatialPose) -> SpatialPose:
        """`pose_ab @ pose_bc == pose_ac`."""
        return SpatialPose(self.rotation @ other.rotation, self.rotation @ other.position + self.position)
