"""Damaged bags: refused in one sentence, salvaged on request with what was lost; never a traceback, no wrong rows."""

from __future__ import annotations

import sqlite3

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.errors import CartgraspError, LogError
from cartgrasp.logs import read_log
from cartgrasp.logs.bags.messages import DECODERS
from cartgrasp.logs.bags.opening import open_bag, read_bag
from cartgrasp.logs.bags.whole_bag import ROS1_SUMS

from . import bag_files as files
from .bag_files import MAP, force_of, push

KINDS = {
    "zstd": ("run.mcap", files.write_mcap),
    "lz4": ("run.mcap", lambda p, m: files.write_mcap(p, m, "lz4")),
    "plain": ("run.mcap", lambda p, m: files.write_mcap(p, m, "none")),
    "ours": ("run.mcap", None),
    "sqlite": ("run.db3", files.write_old_sqlite),
    "ros1": ("run.bag", files.write_ros1),
    "ros1 bz2": ("run.bag", lambda p, m: files.write_ros1(p, m, files.Ros1Writer.CompressionFormat.BZ2)),
}
CHECKED = ("zstd", "lz4", "plain", "ours")
"""Those whose messages stand under a checksum."""
IN_PIECES = ("zstd", "lz4", "plain", "sqlite", "ros1")
"""Those that are not one compressed block."""


class Whole(dict):
    def __repr__(self):
        return "bytes of whole bags"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Bytes of a good bag of each kind."""
    found = Whole()
    for kind, (name, write) in KINDS.items():
        folder = tmp_path_factory.mktemp("whole")
        if write is None:
            from cartgrasp.logs import write_log

            (folder / "other.mcap").write_bytes(found["zstd"])
            (folder / "topics.yaml").write_text(MAP)
            path = write_log(read_log(folder / "other.mcap"), folder / name)
        else:
            path = write(folder / name, push())
        found[kind] = path.read_bytes()
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("damaged")
    (path / "topics.yaml").write_text(MAP)
    return path


def written(folder, kind, data):
    path = folder / KINDS[kind][0]
    path.write_bytes(data)
    return path


def told(path, salvage=False):
    """The reading, or None where it was refused in one sentence that names the file."""
    try:
        return read_bag(path, salvage=salvage)
    except CartgraspError as error:
        message = str(error)
        assert str(path.parent) in message
        assert len(message.splitlines()) == 1
        return None


def is_part_of_truth(log):
    """Whether each row is one that was recorded, at its time."""
    epoch = next(step for step in log.notes.values() if "epoch ns" in step)
    zero = int(epoch.split("epoch ns ")[1].split(",")[0])
    t = log.time + (zero - files.stamp(0)) / 1e9 if zero else log.time
    wrench = next(iter(log.arms.values())).wrench
    there = np.isfinite(wrench).all(axis=1)
    return np.allclose(wrench[there], force_of(t[there]), atol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_salvage_of_a_whole_bag_loses_nothing(folder, whole, kind):
    """Our walk through the file and rosbags' through its index find the same messages."""
    path = written(folder, kind, whole[kind])
    bag, salvaged = open_bag(path), open_bag(path, salvage=True)
    assert sorted(bag.messages(), key=lambda m: (m.topic, m.number)) == sorted(
        salvaged.messages(), key=lambda m: (m.topic, m.number)
    )
    assert salvaged.lost == []
    assert salvaged.kinds == bag.kinds


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("share", [0.0, 0.02, 0.3, 0.5, 0.9, 0.99])
def test_a_bag_that_was_cut_off(folder, whole, kind, share):
    path = written(folder, kind, whole[kind][: int(share * len(whole[kind]))])
    with pytest.raises(LogError, match=r"--salvage|is empty|no messages|no topic"):
        read_log(path)
    reading = told(path, salvage=True)
    if share > 0.4 and kind in IN_PIECES:
        assert reading is not None
        assert len(reading.log) > 0.5 * share * 100
    if reading is not None:
        assert is_part_of_truth(reading.log)
        assert reading.lost


@given(kind=st.sampled_from(sorted(KINDS)), share=st.floats(0, 1, exclude_max=True))
def test_any_cut(folder, whole, kind, share):
    path = written(folder, kind, whole[kind][: int(share * len(whole[kind]))])
    assert told(path) is None
    reading = told(path, salvage=True)
    assert reading is None or (reading.lost and is_part_of_truth(reading.log))


@given(
    kind=st.sampled_from(sorted(KINDS)),
    flips=st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 7)), min_size=1, max_size=4),
)
def test_any_flipped_bits(folder, whole, kind, flips):
    """Refused, or read; and where sums protect the messages, nothing wrong comes out, salvaged or not."""
    content = bytearray(whole[kind])
    for share, bit in flips:
        content[int(share * len(content))] ^= 1 << bit
    path = written(folder, kind, bytes(content))
    for salvage in (False, True):
        reading = told(path, salvage)
        if kind in CHECKED and reading is not None:
            assert is_part_of_truth(reading.log)


@given(name=st.sampled_from(["run.mcap", "run.db3", "run.bag"]), content=st.binary(max_size=400), start=st.booleans())
def test_garbage(folder, whole, name, content, start):
    """With the right first bytes too."""
    kind = next(k for k, (n, _) in KINDS.items() if n == name)
    path = folder / name
    path.write_bytes(whole[kind][: 13 + 8 * len(content) % 200] * start + content)
    assert told(path) is None
    assert told(path, salvage=True) is None


def test_a_flipped_bit_in_a_chunk_costs_that_chunk(folder, whole):
    content = bytearray(whole["plain"])
    at = content.index(b"sensor", len(content) // 2) + 20
    content[at] ^= 1
    path = written(folder, "plain", bytes(content))
    with pytest.raises(LogError, match=r"checksum mismatch; `cartgrasp convert --salvage`"):
        read_log(path)
    reading = read_bag(path, salvage=True)
    assert [lost.split(":")[1] for lost in reading.lost] == [" its checksum differs"]
    assert 80 <= len(reading.log) < 100
    assert is_part_of_truth(reading.log)


def test_a_torn_page_of_sqlite_costs_its_messages(folder, whole):
    content = bytearray(whole["sqlite"])
    page = int.from_bytes(content[16:18], "big")
    for k in (5, 9):
        content[k * page : k * page + 30] = b"\xff" * 30
    path = written(folder, "sqlite", bytes(content))
    with pytest.raises(LogError, match=r"run\.db3: .*malformed; `cartgrasp convert --salvage`"):
        read_log(path)
    reading = read_bag(path, salvage=True)
    assert 50 < len(reading.log) < 100
    assert any("the messages with the ids" in lost for lost in reading.lost)
    assert is_part_of_truth(reading.log)


def test_an_unindexed_bag_of_ros_1(folder, whole):
    """As a recorder that was killed leaves it: index_pos is 0."""
    content = bytearray(whole["ros1"])
    at = content.index(b"index_pos=") + len(b"index_pos=")
    content[at : at + 8] = bytes(8)
    path = written(folder, "ros1", bytes(content))
    with pytest.raises(LogError, match="not indexed"):
        read_log(path)
    assert len(read_bag(path, salvage=True).log) == 100


def test_metadata_that_lies_or_is_broken(tmp_path):
    bag = files.write_folder(tmp_path / "run", push(0.5))
    (bag / "topics.yaml").write_text(MAP)
    good = (bag / "metadata.yaml").read_text()
    assert len(read_log(bag)) == 25
    spoiled = {
        "message_count: 25": "message_count: 26",
        "sqlite3": "sqlite4",
        "version: 8": "version: 99",
        "version:": "versoin:",
        "run.db3": "../run.db4",
        "rosbag2_bagfile_information": "x",
        ":": "[",
    }
    for old, new in spoiled.items():
        (bag / "metadata.yaml").write_text(good.replace(old, new))
        with pytest.raises(LogError, match="--salvage"):
            read_log(bag)
        assert len(read_bag(bag, salvage=True).log) == 25
    (bag / "metadata.yaml").write_bytes(b"\xff\xfe")
    with pytest.raises(LogError, match="--salvage"):
        read_log(bag)


def test_messages_of_another_layout(tmp_path):
    """A type that only has the name of ROS's own is refused, not read as if it were."""
    database = sqlite3.connect(files.write_old_sqlite(tmp_path / "run.db3", push(0.5)))
    with database:
        (raw,) = database.execute("SELECT data FROM messages WHERE id = 8").fetchone()
        database.execute("UPDATE messages SET data = ? WHERE id = 8", (raw + bytes(8),))
    database.close()
    (tmp_path / "topics.yaml").write_text(MAP)
    with pytest.raises(LogError, match=r"run\.db3: /left/wrench: message 4: \d+ bytes, where its type has \d+"):
        read_log(tmp_path / "run.db3")
    reading = read_bag(tmp_path / "run.db3", salvage=True)
    assert reading.lost == ("/left/wrench: 1 samples are damaged",)


def test_types_of_ros_1_are_known_by_their_sums(tmp_path):
    for kind, stated in ROS1_SUMS.items():
        if kind in files.ROS1.fielddefs:
            assert stated == files.ROS1.generate_msgdef(kind, ros_version=1)[1]
    assert set(ROS1_SUMS) == set(DECODERS)
    path = files.write_ros1(tmp_path / "run.bag", push(0.5))
    (tmp_path / "topics.yaml").write_text(MAP)
    path.write_bytes(path.read_bytes().replace(ROS1_SUMS[files.WRENCH].encode(), b"0" * 32))
    with pytest.raises(LogError, match=r"/left/wrench: its geometry_msgs/msg/WrenchStamped is not the one of ROS"):
        read_log(path)


def test_a_database_that_was_not_closed(tmp_path):
    path = files.write_old_sqlite(tmp_path / "run.db3", push(0.5))
    (tmp_path / "topics.yaml").write_text(MAP)
    (tmp_path / "run.db3-wal").write_bytes(b"x")
    with pytest.raises(LogError, match=r"run\.db3-wal holds messages"):
        read_log(path)


def test_no_bag_at_all(tmp_path):
    for name in ("run.mcap", "run.db3", "run.bag"):
        with pytest.raises(LogError, match="no such file"):
            read_log(tmp_path / name)
        (tmp_path / f"folder.{name[4:]}").mkdir()
        with pytest.raises(LogError, match="is a folder"):
            read_log(tmp_path / f"folder.{name[4:]}")
    for name in ("monday.mcap", "tuesday.mcap"):
        files.write_mcap(tmp_path / name, push(0.2))
    with pytest.raises(LogError, match=r"holds several bags, monday, tuesday …; name one"):
        read_log(tmp_path)
