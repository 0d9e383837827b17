"""Where results go: never over what a command reads, and what can't be written is said in one line."""

from __future__ import annotations

import os
import shutil

import pytest

from cartgrasp.errors import FileError
from cartgrasp.writing import write_atomically, write_folder

from .commands import CART, run
from .pushed_cart import as_csv, pushed_cart

ENDINGS = {"convert": "mcap", "estimate": "csv", "view": "html"}
LONG = 300 * "x"


@pytest.fixture
def inputs(tmp_path):
    log, cart = tmp_path / "run.csv", tmp_path / "cart.yaml"
    log.write_text(as_csv(pushed_cart()[:300]), encoding="utf-8")
    cart.write_text(CART, encoding="utf-8")
    return log, cart


@pytest.mark.parametrize("command", ["estimate", "view", "identify", "discrepancy"])
def test_nothing_that_is_read_is_written_over(capsys, inputs, command):
    log, cart = inputs
    alias = log.with_name("alias.csv")
    os.link(log, alias)
    before = log.read_bytes(), cart.read_bytes()
    outs = [log.parent] if command in ("identify", "discrepancy") else [log, cart, alias]
    for out in outs:
        run(capsys, command, log, "--cart", cart, "--out", out).refused(2, "--out", "is read by this command")
    assert (log.read_bytes(), cart.read_bytes()) == before


@pytest.mark.parametrize("command", ENDINGS)
def test_names_that_no_file_can_have(capsys, inputs, command):
    log, cart = inputs
    more = [] if command == "convert" else ["--cart", cart]
    out = log.with_name(f"{LONG}.{ENDINGS[command]}")
    run(capsys, command, log, *more, "--out", out).refused(2, "--out", "File name too long")
    out = log.with_name(f"ok.{ENDINGS[command]}")
    run(capsys, command, log.with_name(LONG + ".csv"), *more, "--out", out).refused(3, "File name too long")
    run(capsys, command, log.with_name(LONG + ".mcap"), *more, "--out", out).refused(3, "File name too long")
    assert sorted(p.name for p in log.parent.iterdir()) == ["cart.yaml", "run.csv"]


@pytest.mark.parametrize("command", [*ENDINGS, "identify", "discrepancy", "simulate", "demo"])
def test_a_folder_that_takes_no_files_is_told_first(capsys, inputs, command):
    """Nobody may write into Linux's /proc. Only when all was done had one been told."""
    log, cart = inputs
    options = {"convert": [log], "simulate": ["--cart", cart], "demo": []}.get(command, [log, "--cart", cart])
    out = f"/proc/ok.{ENDINGS[command]}" if command in ENDINGS else "/proc"
    run(capsys, command, *options, "--out", out).refused(2, f"--out {out}: can't be written", "; name another f")


def test_topics_of_a_name_that_no_file_can_have(capsys, tmp_path):
    run(capsys, "topics", tmp_path / (LONG + ".mcap")).refused(3, "File name too long")


def test_a_device_stays_one(tmp_path):
    """A file renamed over a device or a pipe would take its place."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(FileError, match="it is no ordinary file"):
        write_atomically(pipe, "x")
    assert pipe.is_fifo()
    assert list(tmp_path.iterdir()) == [pipe]


def test_a_folder_that_can_not_be_copied_is_one_sentence(tmp_path):
    def fill(_):
        raise shutil.Error([("a", "b", "[Errno 28] No space left on device: 'a' -> 'b'"), ("c", "d", "e")])

    with pytest.raises(FileError, match=r"can't be written: \[Errno 28\] No space left on device; mend that"):
        write_folder(tmp_path / "new", fill)
    assert not list(tmp_path.iterdir())
