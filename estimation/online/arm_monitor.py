"""Arms whose wrenches can't be used, whatever they are: none has come, or nobody has said where the arm holds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from cartgrasp.motion import Measurement

from ..sensor_check.suspicion import Suspicion


class ArmMonitor:
    """Notes of which arms there were wrenches and contacts so far."""

    def __init__(self, arms: Sequence[str] | None) -> None:
        self._asked = arms
        self._recorded, self._holding = set[str](), set[str]()

    def note(self, measurement: Measurement) -> None:
        self._recorded |= measurement.wrenches.keys()
        self._holding |= measurement.contacts.keys()

    @property
    def suspicions(self) -> Iterator[Suspicion]:
        """One for each arm, in words that say what is missing."""
        for arm in sorted(self._recorded) if self._asked is None else self._asked:
            if arm not in self._recorded:
                others = ", ".join(sorted(self._recorded)) or "no arm"
                yield _missing(arm, f"no wrench of it has come; those that came are of {others}")
            elif arm not in self._holding:
                yield _missing(arm, f"its wrenches come without a contact; give contacts={{{arm!r}: (x, y, z)}} once")


def _missing(arm: str, words: str) -> Suspicion:
    return Suspicion("missing", arm, 1.0, None, f"{arm}: {words}")
