"""Kinds of logs that are rough on purpose, each of which goes with hidden effects: `rolling_resistance@rail@bursts`."""

from __future__ import annotations

from collections.abc import Callable
from hashlib import sha256

import numpy as np

from .coasting import coasting
from .imperfect_sensors import force_lag, large_velocities, late_velocities, quantised_poses
from .pushing import bursts, leaning_load
from .rails import rail
from .scenes import Scene
from .sensor_track import sensor_track

ROUGHNESS: dict[str, Callable[[Scene, np.random.Generator], Scene]] = {
    f.__name__: f
    for f in (
        *(rail, coasting, bursts, leaning_load),
        *(quantised_poses, force_lag, late_velocities, large_velocities, sensor_track),
    )
}
"""In the order in which they are put into a scene: what moves the cart first."""
SETTINGS = ("mujoco", "two_arms")
"""What else stands behind an @."""
OF_SENSORS = ("force_bias", "force_scale", "force_misalignment", "time_delay", "contact_offset", "tool_inertia")
BARRED: dict[str, tuple[str, ...]] = {
    "rail": ("caster_realignment", "wheel_drag_imbalance", "wheel_misalignment", "lateral_slip", "mujoco"),
    "coasting": (*OF_SENSORS, "payload_change", "bursts", "leaning_load", "force_lag", "sensor_track", *SETTINGS),
    "leaning_load": ("load_slosh", "mujoco"),
    "quantised_poses": ("late_velocities", "large_velocities"),
}
"""What makes no sense together: wheels that a rail holds, hands where there are none, two masses for one."""

EFFECTS = ("nothing", "rolling_resistance", "floor_slope", "force_bias", "payload_change")
ROLLING = ("nothing", "rolling_resistance", "floor_slope", "quadratic_drag", "rolling_resistance+floor_slope")
TOGETHER = (
    *(
        "nothing@rail@bursts@leaning_load@quantised_poses",
        "rolling_resistance@rail@bursts@leaning_load@quantised_poses",
    ),
    *("rolling_resistance@bursts@leaning_load", "payload_change@bursts@leaning_load"),
    *("nothing@rail@sensor_track@quantised_poses", "rolling_resistance@rail@sensor_track@quantised_poses"),
    *("rolling_resistance+directional_drag@rail", "rolling_resistance+directional_drag@rail@sensor_track"),
    *(
        "rolling_resistance@rail@coasting@quantised_poses",
        "rolling_resistance+floor_slope@rail@coasting@quantised_poses",
    ),
    *("force_bias@force_lag@late_velocities", "nothing@force_lag@large_velocities"),
)
"""Nearly what a wheelchair, a cart on a track and an axis are when they are measured."""
EVERY_ROUGH = (
    *(f"{effects}@{kind}" for kind in ROUGHNESS if kind != "coasting" for effects in EFFECTS),
    *(f"{effects}@{kind}" for kind in ("coasting", "rail@coasting") for effects in ROLLING),
    *TOGETHER,
)
PROOF_SHARE = 4
"""One of so many kinds is kept for proof."""


def parts(case: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Effects, and what stands behind them."""
    effects, *kinds = case.split("@")
    return () if effects == "nothing" else tuple(effects.split("+")), tuple(kinds)


def is_rough(case: str) -> bool:
    return any(kind in ROUGHNESS for kind in parts(case)[1])


def for_proof(case: str) -> bool:
    """Whether a kind is frozen: it is only generated for proof, and its reports are only counted in totals. By its name
    alone, so that kinds which are added later leave the others where they are."""
    return case in EVERY_ROUGH and sha256(f"proof {case}".encode()).digest()[0] % PROOF_SHARE == 0


ROUGH_CASES = tuple(case for case in EVERY_ROUGH if not for_proof(case))
PROOF_CASES = tuple(case for case in EVERY_ROUGH if for_proof(case))
ARM_CASES = tuple(f"{name}@two_arms" for name in ("force_bias", "force_scale", "force_misalignment"))
"""One arm of two has the effect."""
