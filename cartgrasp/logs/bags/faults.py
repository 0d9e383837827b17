"""Samples that are whole, but can't belong to one run: in other frames than the rest, stamped in another year, or of a
static transform that changes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .bag import SALVAGE_HINT, Bag
from .messages import NS_PER_S
from .topic_samples import TopicSamples

SECONDS_PER_DAY = 86_400.0


@dataclass(frozen=True)
class Fault:
    """Which samples (n,) have it, why the first of them can't be used, and what is said where they are left out."""

    is_there: NDArray[np.bool_]
    why: str
    lost: str


def without(samples: TopicSamples, fault: Fault, bag: Bag, is_salvage: bool) -> TopicSamples:
    """The samples that don't have it; a bag that is not salvaged must have none that do."""
    if not fault.is_there.any():
        return samples
    if not is_salvage:
        number = samples.message[int(np.argmax(fault.is_there))]
        raise bag.refuse(f"message {number}: {fault.why}; {SALVAGE_HINT}", samples.topic)
    bag.lost.append(f"{samples.topic}: {int(fault.is_there.sum())} samples {fault.lost}")
    return samples.only(~fault.is_there)


def other_frames(samples: TopicSamples) -> Fault:
    """Numbers in two frames can't be compared: those in other frames than most."""
    most = int(np.bincount(samples.frames).argmax())
    odd = samples.frames != most
    one, usual = _said(samples, int(samples.frames[int(np.argmax(odd))])), _said(samples, most)
    return Fault(odd, f"is in the frames {one}, most others in {usual}", f"are in other frames than {usual}")


def other_values(samples: TopicSamples) -> Fault:
    """A static transform has the numbers that were sent last, all through the run."""
    is_same = (samples.numbers == samples.numbers[-1]) | np.isnan(samples.numbers)
    why = "holds another transform than was sent later, but a static one holds for the whole run"
    return Fault(~is_same.all(axis=1), why, "are not the static transform that was sent last")


def far_stamps(samples: TopicSamples, max_gap: float) -> Fault:
    """Header stamps that are days (or beyond `max_gap`, in s, if that is longer) from those of most others: a clock
    that was set anew, or a header that was never stamped."""
    order = np.argsort(samples.stamp, kind="stable")
    cuts = np.diff(samples.stamp[order]) / NS_PER_S > max(SECONDS_PER_DAY, max_gap)
    group = np.empty(len(samples), dtype=np.int64)
    group[order] = np.concatenate([[0], np.cumsum(cuts)])
    most = int(np.bincount(group).argmax())
    far = group != most
    days = (samples.stamp[int(np.argmax(far))] - np.median(samples.stamp[~far])) / NS_PER_S / SECONDS_PER_DAY
    why = (
        f"its header's stamp is {days:+.0f} days from those of most others (`stamps: receive` in the map does without)"
    )
    return Fault(far, why, "are stamped days from the others")


def _said(samples: TopicSamples, place: int) -> str:
    frame, child = samples.names[place]
    return f"{frame!r} → {child!r}" if child else repr(frame)
