"""What ways to choose contacts may ask, spend and take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from cartgrasp.checks import MAX_NUMBER, check_kind, check_known, number, positive
from cartgrasp.first_guess import PHYSICAL_NAMES
from cartgrasp.information import WrenchNoise

MAX_HORIZON = 3600.0  # s
DEFAULT_WRENCH_NOISE = WrenchNoise()


@dataclass(frozen=True)
class Choosing:
    """How contacts are chosen.

    Args:
        every: s between choices, in which a hand stays.
        ahead: s of the reference by which a choice is judged, for "teach" and "schedule".
        asked: To which standard deviation a parameter is to be known (`mass`, `com_x`, `com_y`, `inertia`; kg, m, m,
            kg·m²), for "teach".
        extra_effort: Share of the least effort of the time ahead that may be spent on learning, for "teach".
        regrasp_effort: What a regrasp must save beyond what the others bear meanwhile, N²·s, for "teach", "schedule".
        noise: Of the arms' force sensors, for "teach".
        min_hand_distance: m between any two hands.

    Raises:
        UsageError: A number is out of bounds, or a parameter is not known.
    """

    every: float = 3.0
    ahead: float = 8.0
    asked: Mapping[str, float] = field(default_factory=lambda: {"com_x": 0.02, "com_y": 0.02})
    extra_effort: float = 0.3
    regrasp_effort: float = 20.0
    noise: WrenchNoise = DEFAULT_WRENCH_NOISE
    min_hand_distance: float = 0.0

    def __post_init__(self) -> None:
        positive("choosing: every", self.every, MAX_HORIZON, "give s")
        positive("choosing: ahead", self.ahead, MAX_HORIZON, "give s")
        check_kind("choosing: asked", self.asked, Mapping, 'write {"com_x": 0.02}')
        check_known("choosing: asked", self.asked, PHYSICAL_NAMES)
        for name, std in self.asked.items():
            positive(f"choosing: asked: {name}", std, MAX_NUMBER, "give one standard deviation")
        for name in ("extra_effort", "regrasp_effort", "min_hand_distance"):
            number(f"choosing: {name}", getattr(self, name), 0.0, MAX_NUMBER)
