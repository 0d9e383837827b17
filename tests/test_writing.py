"""What is written is whole, and what the killed leave is taken over; the kills themselves are in `tests/cli`."""

from __future__ import annotations

import fcntl
import os
import threading

import pytest

from cartgrasp import writing
from cartgrasp.errors import FileError
from cartgrasp.writing import together, write_atomically, write_folder


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_file_is_written_over_what_a_killed_process_left(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("old")
    (tmp_path / ".a.csv.part").write_text("half of a much longer file")
    assert write_atomically(path, "new") == path
    assert path.read_text() == "new"
    assert names(tmp_path) == ["a.csv"]


def test_writers_of_one_file_take_turns(tmp_path):
    path = tmp_path / "a"
    contents = [bytes([65 + i]) * 200_000 for i in range(8)]
    threads = [threading.Thread(target=write_atomically, args=(path, content)) for content in contents * 3]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert path.read_bytes() in contents
    assert names(tmp_path) == ["a"]


def test_a_writer_waits_for_the_one_that_is_alive(tmp_path):
    aside = os.open(tmp_path / ".a.part", os.O_RDWR | os.O_CREAT)
    fcntl.flock(aside, fcntl.LOCK_EX)
    writer = threading.Thread(target=write_atomically, args=(tmp_path / "a", "mine"))
    writer.start()
    writer.join(0.2)
    assert writer.is_alive()
    os.write(aside, b"theirs")
    os.replace(tmp_path / ".a.part", tmp_path / "a")
    os.close(aside)
    writer.join(10)
    assert (tmp_path / "a").read_text() == "mine"
    assert names(tmp_path) == ["a"]


def test_together_all_or_none(tmp_path):
    (tmp_path / "a").write_text("old")
    with together():
        write_atomically(tmp_path / "a", "new")
        write_atomically(tmp_path / "b", "new")
        assert names(tmp_path) == [".a.part", ".b.part", "a"]
        assert (tmp_path / "a").read_text() == "old"
    assert [path.read_text() for path in sorted(tmp_path.iterdir())] == ["new", "new"]
    with pytest.raises(FileError):
        write_newer_and_fail(tmp_path)
    assert (tmp_path / "a").read_text() == "new"
    assert names(tmp_path) == ["a", "b"]


def write_newer_and_fail(folder):
    with together():
        write_atomically(folder / "a", "newer")
        write_atomically(folder / "nowhere" / "a", "newer")


@pytest.mark.parametrize("in_one_call", [True, False])
def test_a_folder_takes_the_place_of_another(tmp_path, monkeypatch, in_one_call):
    if not in_one_call:
        monkeypatch.setattr(writing, "_exchanged", lambda one, other: False)
    folder, aside = tmp_path / "deep" / "c", tmp_path / "deep" / ".c.part"
    assert write_folder(folder, lambda f: (f / "1").write_text("1")) == folder
    aside.mkdir()
    (aside / "left").mkdir()
    (aside / "left" / "over").write_text("by one that was killed")
    write_folder(folder, lambda f: (f / "2").write_text("2"))
    assert names(folder) == ["2"]
    assert names(folder.parent) == ["c"]

    def fail(f):
        (f / "3").write_text("3")
        raise OSError(28, "No space left on device")

    with pytest.raises(FileError, match="No space left"):
        write_folder(folder, fail)
    assert names(folder) == ["2"]
    assert names(folder.parent) == ["c"]


@pytest.mark.parametrize("name", ["nowhere/a", "folder", "x" * 300])
def test_what_cannot_be_written_is_said(tmp_path, name):
    (tmp_path / "folder").mkdir()
    with pytest.raises(FileError, match=r"can't be written.*name another place"):
        write_atomically(tmp_path / name, "a")
    assert names(tmp_path) == ["folder"]
