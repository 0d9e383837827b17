"""What was done to a bag's samples on their way into a log, step by step, with counts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class ProcessingStep:
    """`of` is a topic, an arm, the pose or the log."""

    of: str
    what: str
    figures: Mapping[str, float | int | str]

    def __str__(self) -> str:
        said = {name: f"{value:.4g}" if isinstance(value, float) else value for name, value in self.figures.items()}
        figures = ", ".join(f"{name} {value}" for name, value in said.items())
        return f"{self.of}: {self.what}" + (f" ({figures})" if figures else "")


@dataclass
class ProcessingSteps:
    """A growing list."""

    done: list[ProcessingStep] = field(default_factory=list)

    def add(self, of: str, what: str, **figures: float | int | str) -> None:
        self.done.append(ProcessingStep(of, what, {name.replace("_", " "): value for name, value in figures.items()}))
