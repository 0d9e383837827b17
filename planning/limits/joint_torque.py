"""What the joints bear: |Jᵀ F + tau_0| <= tau_max for each joint. The zero wrench holds it, since `JointTorques`
refuses a posture whose own weight breaks it."""

from __future__ import annotations

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError

from .limit import Limit, LimitRows


class JointTorque(Limit):
    def rows(self, arm: Arm) -> LimitRows:
        if arm.joints is None:
            raise UsageError(f"arm {arm.name}: a limit of joint torques needs joints")
        joints = arm.joints
        return LimitRows(
            rows=joints.jacobian.T,
            limits=joints.torque_limit - joints.gravity_torque,
            names=tuple(f"{label} torque upper" for label in joints.labels),
            low_limits=-joints.torque_limit - joints.gravity_torque,
            low_names=tuple(f"{label} torque lower" for label in joints.labels),
        )
