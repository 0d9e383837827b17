"""A reach keeps the points within, and the parts of handles that are within."""

from __future__ import annotations

import numpy as np
import pytest

from cartgrasp.contacts import ContactSet, Segment
from cartgrasp.errors import UsageError
from cartgrasp.reach import Reach


@pytest.mark.parametrize("seed", range(40))
def test_a_clipped_handle_holds_the_points_within(seed):
    rng = np.random.default_rng(seed)
    reach = Reach(rng.normal(size=(4, 3)), rng.uniform(-0.2, 0.6, 4))
    start, stop = rng.uniform(-0.6, 0.6, (2, 3))
    if seed % 4 == 0:
        stop[1:] = start[1:]
    scan = start + np.linspace(0, 1, 501)[:, None] * (stop - start)
    within = scan[reach.excess(scan) <= 0]
    clipped = reach.clip(ContactSet(segments=(Segment(tuple(start), tuple(stop)),)))
    if clipped is None:
        assert len(within) <= 1
        return
    (part,) = clipped.segments
    ends = np.array([part.start, part.stop])
    assert reach.excess(ends).max() <= 1e-12
    spacing = np.linalg.norm(stop - start) / 500
    assert np.linalg.norm(ends[0] - within[0]) <= spacing
    assert np.linalg.norm(ends[1] - within[-1]) <= spacing


def test_a_box_and_its_points():
    reach = Reach.box((-0.3, 0.0, 0.9), (-0.2, 0.3, 1.1))
    inside, outside = (-0.25, 0.1, 1.0), (-0.25, -0.1, 1.0)
    assert reach.excess([inside, outside]) == pytest.approx([-0.05, 0.1])
    assert reach.clip(ContactSet((inside, outside))) == ContactSet((inside,))
    assert reach.clip(ContactSet((outside,))) is None
    handle = Segment((-0.25, -0.2, 1.0), (-0.25, 0.2, 1.0))
    (part,) = reach.clip(ContactSet(segments=(handle,))).segments
    assert part.stop == handle.stop
    assert part.start == pytest.approx((-0.25, 0.0, 1.0))
    beside = Segment((-0.25, 0.4, 1.0), (-0.25, 0.4, 1.05))
    assert reach.clip(ContactSet(segments=(beside,))) is None


def test_lengths_of_normals_do_not_matter():
    one, other = Reach([[0, 2, 0]], [1]), Reach([[0, 1, 0]], [0.5])
    assert one.excess([0, 1, 0]) == pytest.approx(other.excess([0, 1, 0]))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Reach([[1, 0]], [1]), "not \\(k, 3\\)"),
        (lambda: Reach([[1, 0, 0]], [1, 2]), "not \\(k, 3\\)"),
        (lambda: Reach([[0, 0, 0]], [1]), "a normal is zero"),
        (lambda: Reach([[1, 0, 0]], [np.nan]), "not finite"),
        (lambda: Reach.box((0, 0, 0), (1, -1, 1)), "corner of a box"),
        (lambda: Reach.box((0, 0), (1, 1)), "3 numbers are needed, 2 given"),
    ],
)
def test_what_cannot_be_meant_is_refused(call, words):
    with pytest.raises(UsageError, match=words):
        call()
