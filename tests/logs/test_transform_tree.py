"""Paths through trees of frames, and products along them, beside 4x4 matrices multiplied by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.logs.bags.transform_chain import composed
from cartgrasp.logs.bags.transform_tree import BadTreeError, NoPathError, TransformTree, frames_on, likely_path, usual
from cartgrasp.logs.mapped.processing_steps import ProcessingSteps
from cartgrasp.logs.mapped.timed_samples import TimedSamples

GAP = 0.25
SEEDS = st.integers(0, 2**32 - 1)


def key(frame, child, topic="/tf"):
    return topic, (frame, child)


class Screw:
    """A transform whose position moves straight and whose rotation turns about one axis, both evenly."""

    def __init__(self, rng, is_static=False):
        axis = rng.normal(size=3)
        self.axis, self.angle, self.at = axis / np.linalg.norm(axis), rng.uniform(-3, 3), rng.uniform(-2, 2, 3)
        self.rate, self.velocity = (0.0, np.zeros(3)) if is_static else (rng.uniform(-3, 3), rng.uniform(-1, 1, 3))

    def matrix(self, t):
        """By Rodrigues' formula."""
        angle, (x, y, z) = self.angle + self.rate * t, self.axis
        k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        found = np.eye(4)
        found[:3, :3] += np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
        found[:3, 3] = self.at + self.velocity * t
        return found

    def numbers(self, t):
        half = (self.angle + self.rate * np.asarray(t))[:, None] / 2
        position = self.at + self.velocity * np.asarray(t)[:, None]
        return np.hstack([position, self.axis * np.sin(half), np.cos(half)])


def matrix_of(numbers):
    """Of a position and a unit quaternion."""
    x, y, z, w = numbers[3:]
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    found = np.eye(4)
    found[:3, :3] += 2 * w * k + 2 * k @ k
    found[:3, 3] = numbers[:3]
    return found


@st.composite
def trees(draw):
    """The parent of each frame but 0, which has none, with two frames to be connected."""
    n = draw(st.integers(2, 9))
    parents = {i: draw(st.integers(0, i - 1)) for i in range(1, n)}
    ends = draw(st.lists(st.integers(0, n - 1), min_size=2, max_size=2, unique=True))
    return parents, ends


def in_root(parents, links, frame, t):
    pose = np.eye(4)
    while frame:
        pose = links[frame].matrix(t) @ pose
        frame = parents[frame]
    return pose


@given(trees(), SEEDS)
def test_any_path_is_the_product_of_matrices(tree, seed):
    """Links at stamps of their own, static ones among them, with samples left out: the truth, or nan in gaps."""
    (parents, (a, b)), rng = tree, np.random.default_rng(seed)
    static = {child: rng.random() < 0.3 for child in parents}
    links = {child: Screw(rng, static[child]) for child in parents}
    names = [
        key(str(parent), str(child), "/tf_static" if static[child] else "/tf") for child, parent in parents.items()
    ]
    path = TransformTree(names).path(str(a), str(b))
    assert frames_on(path)[0] == str(a)
    assert frames_on(path)[-1] == str(b)
    clocked = []
    for link in path:
        child = int(link.key[1][1])
        time = np.sort(rng.choice(2000, rng.integers(20, 60), replace=False)) * 1e-3
        time = np.concatenate([[0.0], time[time > 0], [2.0]])
        clocked.append(TimedSamples(time, links[child].numbers(time), static[child]))
    found = composed("pose", path, clocked, GAP, ProcessingSteps())
    moving = [c for c in clocked if not c.is_static]
    assert found.is_static == (not moving)
    if moving:
        assert found.time.tolist() == max(moving, key=lambda c: len(c.time)).time.tolist()
    for t, row in zip(found.time, found.numbers, strict=True):
        near = [(c.time[c.time <= t].max(), c.time[c.time >= t].min()) for c in moving]
        assert np.isfinite(row).all() == all(after - before <= GAP for before, after in near)
        if np.isfinite(row).all():
            expected = np.linalg.inv(in_root(parents, links, a, t)) @ in_root(parents, links, b, t)
            assert matrix_of(row) == pytest.approx(expected, abs=1e-12)


def test_a_jump_is_spread_between_two_transforms_and_no_further():
    """From yaw 170° to -170°, the short way round: as tf2 has it."""
    path = TransformTree([key("map", "odom"), key("odom", "base")]).path("map", "base")
    half = np.radians([170, 170, -170, -170]) / 2
    slow = np.column_stack([[0, 0, 1, 1], np.zeros((4, 4)), np.sin(half), np.cos(half)])
    at = np.arange(31) / 10
    fast = np.tile([0.0, 0, 0, 0, 0, 0, 1], (31, 1))
    found = composed(
        "pose", path, [TimedSamples(np.arange(4.0), slow), TimedSamples(at, fast)], 1.0, ProcessingSteps()
    ).numbers
    assert found[:, 0] == pytest.approx(np.clip(at - 1, 0, 1), abs=1e-12)
    yaw = np.degrees(2 * np.arctan2(found[:, 5], found[:, 6])) % 360
    assert yaw == pytest.approx(170 + 20 * np.clip(at - 1, 0, 1), abs=1e-9)


def test_what_is_missing_is_missing():
    path = TransformTree([key("map", "odom"), key("odom", "base")]).path("map", "base")
    time, rows = np.arange(10) / 10, np.tile([1.0, 0, 0, 0, 0, 0, 1], (10, 1))
    holed = rows.copy()
    holed[3, 2], holed[6] = np.nan, np.nan
    steps = ProcessingSteps()
    found = composed("pose", path, [TimedSamples(time, rows), TimedSamples(time, holed)], 0.1, steps).numbers
    assert np.flatnonzero(np.isnan(found).any(axis=1)).tolist() == [3, 6]
    assert np.isnan(found[[3, 6]]).all()
    assert steps.done[-1].figures == {"links": 2, "samples": 10, "left out": 0, "missing": 2}
    assert np.isnan(
        composed("pose", path, [TimedSamples(time, rows), TimedSamples(time, 0 * rows + np.nan)], 1.0, steps).numbers
    ).all()


BAD = {
    "two parents": (
        [key("map", "base"), key("odom", "base", "/tf_static"), key("odom", "map")],
        r"the frame base has two parents, map in /tf and odom in /tf_static; .*--salvage",
    ),
    "sent as moving and as static": (
        [key("map", "odom"), key("odom", "base"), key("odom", "base", "/tf_static")],
        r"the frame base has two parents, odom in /tf and odom in /tf_static",
    ),
    "a loop": ([key("a", "base"), key("b", "a"), key("base", "b")], "the frames base → b → a → base are a loop"),
    "a loop of one": ([key("base", "base"), key("map", "odom")], "the frames base → base are a loop"),
    "both ways": ([key("a", "base"), key("base", "a"), key("map", "b")], "the frames base → a → base are a loop"),
}


@pytest.mark.parametrize("kind", BAD)
def test_what_is_no_tree(kind):
    links, why = BAD[kind]
    with pytest.raises(BadTreeError, match=why):
        TransformTree([*links, key("world", "map")]).path("map", "base")


def test_what_is_elsewhere_in_the_tree_does_not_matter():
    links = [
        key("map", "odom"),
        key("odom", "base"),
        key("a", "wheel"),
        key("b", "wheel"),
        key("x", "map"),
        key("y", "map"),
    ]
    assert [link.key for link in TransformTree(links).path("map", "base")] == links[:2]


def test_a_chain_that_is_broken():
    tree = TransformTree([key("map", "odom"), key("base", "wheel"), key("base", "sensor")])
    why = "no chain from odom to wheel: neither map .above odom. nor base .above wheel. has a parent; its frames are b"
    with pytest.raises(NoPathError, match=why):
        tree.path("odom", "wheel")
    with pytest.raises(NoPathError, match="has no frame bse, but base, "):
        tree.path("map", "bse")
    with pytest.raises(NoPathError, match="where map is in itself"):
        tree.path("map", "map")
    with pytest.raises(NoPathError, match=r"but a.* and 21 more$"):
        TransformTree([key("a", f"a{i}") for i in range(30)]).path("a", "nowhere")
    with pytest.raises(NoPathError, match="has no frame a, but none"):
        TransformTree([]).path("a", "b")


def test_the_most_usual_parent():
    counts = {key("map", "base"): 2, key("odom", "base"): 90, key("map", "odom"): 1}
    assert usual(counts) == {key("odom", "base"), key("map", "odom")}


@pytest.mark.parametrize(
    ("counts", "ends"),
    [
        ({key("map", "odom"): 9, key("odom", "base_link"): 90, key("base_link", "wheel"): 900}, ["map", "base_link"]),
        (
            {key("odom", "r/base_footprint"): 9, key("r/base_footprint", "r/base_link", "/tf_static"): 1},
            ["odom", "r/base_link"],
        ),
        ({key("map", "cart"): 9, key("map", "box"): 8}, ["map", "cart"]),
        ({key("world", "base_link", "/tf_static"): 1, key("base_link", "tool"): 8}, ["base_link", "tool"]),
        ({key("a", "base_link"): 9, key("b", "base_link"): 8}, ["a", "base_link"]),
        ({key("world", "base_link", "/tf_static"): 1}, []),
    ],
)
def test_a_likely_path(counts, ends):
    frames = frames_on(likely_path(counts))
    assert frames[:1] + frames[-1:] == ends
