"""The manoeuvre that best tells apart what is still open, chosen piece by piece."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.reference_file import StoredReference

from .manoeuvres import MANOEUVRE_TIME_STEP, Limits, Piece, Place, pieces, said
from .separation import Belief, Evidence, Hands, traced

HALF_VALUE_SIGMAS = 10.0
"""Deviations at which more of them are worth half."""


@dataclass(frozen=True)
class Question:
    """Whether a cart is as `truth` says, called `name`, and not as `rival` does (places in a list of beliefs); an empty
    `other` stands for a cart without it, which then is of so large a share of its usual `size`. So many deviations tell
    it `before` another motion."""

    name: str
    other: str
    truth: int
    rival: int
    weight: float = 1.0
    before: float = 0.0
    size: float = 1.0


@dataclass(frozen=True, eq=False)
class Proposal:
    """The pieces, where they begin, and by how many deviations each question is told there."""

    pieces: tuple[Piece, ...]
    start: tuple[float, float, float]
    questions: tuple[Question, ...]
    deviations: tuple[float, ...]

    @property
    def says(self) -> str:
        return said(self.pieces)

    @property
    def reference(self) -> StoredReference:
        """To be simulated, or run."""
        stretches = (stretch for piece in self.pieces for stretch in piece.stretches)
        return StoredReference(tuple(stretches), self.start, self.says)


@dataclass(frozen=True, eq=False)
class Experiment:
    """What is open, and with which sensors one looks: places in `questions` are those of `beliefs`."""

    beliefs: tuple[Belief, ...]
    questions: tuple[Question, ...]
    hands: Hands

    @cached_property
    def weights(self) -> Array:
        return self.hands.weights(self.beliefs[0].cart)

    def begun(self, start: Array, time: float) -> _Course:
        """At a pose (3,), at rest."""
        begins = (belief.cart.state(start) for belief in self.beliefs)
        memories = (state[b.cart.memory_slice] for b, state in zip(self.beliefs, begins, strict=True))
        places = tuple(Place(start, memory, time) for memory in memories)
        return _Course((), places, tuple(Evidence.none(self.beliefs[one.rival]) for one in self.questions))

    def after(self, course: _Course, piece: Piece) -> _Course:
        """With another piece."""
        pairs = zip(self.beliefs, course.places, strict=True)
        traces = [traced(belief, piece, place, self.hands, self.weights) for belief, place in pairs]
        known = zip(self.questions, course.evidence, strict=True)
        evidence = tuple(old.more(traces[one.truth], traces[one.rival]) for one, old in known)
        return _Course((*course.pieces, piece), tuple(trace.end for trace in traces), evidence)

    def told(self, course: _Course) -> float:
        """How much of the questions is answered, each 1 at most."""
        found = zip(self.questions, course.evidence, strict=True)
        squares = np.array([question.before**2 + one.deviations**2 for question, one in found])
        weights = np.array([one.weight for one in self.questions])
        return float(weights @ (squares / (squares + HALF_VALUE_SIGMAS**2)))

    def proposed(self, limits: Limits, start: Array, time: float = 0.0) -> Proposal:
        """Each piece is the one that tells most beside those before it, until the time is over."""
        known = pieces(limits, self.beliefs[0].cart.constraints)
        course, left = self.begun(start, time), limits.duration
        while fitting := [piece for piece in known if piece.duration <= left + MANOEUVRE_TIME_STEP / 2]:
            course = max((self.after(course, piece) for piece in fitting), key=self.told)
            left -= course.pieces[-1].duration
        x, y, theta = start.tolist()
        deviations = tuple(one.deviations for one in course.evidence)
        return Proposal(course.pieces, (x, y, theta), self.questions, deviations)


@dataclass(frozen=True, eq=False)
class _Course:
    """Pieces, where each belief has the cart after them, and what they tell of each question."""

    pieces: tuple[Piece, ...]
    places: tuple[Place, ...]
    evidence: tuple[Evidence, ...]
