"""CSV logs: bit-exact round trip, what is missing, and each kind of mistake by file, line and column."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cartgrasp.errors import CartgraspError, DataError, LogError
from cartgrasp.logs import ArmLog, RunLog, read_log, write_log

from .tables import HEADER, rows, spoiled, text, without

NUMBERS = st.one_of(st.floats(allow_nan=False, allow_infinity=False), st.just(math.nan))


@st.composite
def logs(draw):
    n = draw(st.integers(1, 6))
    clock = draw(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=n, max_size=n, unique=True))
    words = st.text(st.characters(codec="utf-8", exclude_characters="."), min_size=1).filter(lambda w: w == w.strip())
    arms = draw(st.lists(words, unique=True))

    def table(width):
        return draw(arrays(np.float64, (n, width), elements=NUMBERS))

    return RunLog(
        np.array(sorted(clock)),
        table(3),
        table(3) if draw(st.booleans()) else None,
        {arm: ArmLog(table(3), table(6)) for arm in arms[:3]},
    )


@given(logs())
def test_round_trip_is_exact_to_the_bit(tmp_path_factory, log):
    path = tmp_path_factory.mktemp("csv") / "run.csv"
    write_log(log, path)
    back = read_log(path)
    assert back.columns == log.columns
    assert np.array_equal(back.table, log.table, equal_nan=True)
    known = ~np.isnan(log.table)
    assert np.array_equal(np.signbit(back.table[known]), np.signbit(log.table[known]))  # -0.0 stays


def test_a_name_that_csv_loses_is_not_written(tmp_path):
    log = read_log(written(tmp_path, text()))
    path = tmp_path / "other.csv"
    for name in (" left", "left\n", "\x85"):
        with pytest.raises(DataError, match="begins or ends with a blank"):
            write_log(replace(log, arms={name: log.arms["left"]}), path)
        assert not path.exists()


def written(folder, content, name="run.csv"):
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize("cell", ["", "nan", "NaN", "NAN", " ", " nan "])
def test_blank_and_nan_are_missing(tmp_path, cell):
    log = read_log(written(tmp_path, spoiled(3, "left.fx", cell)))
    assert np.isnan(log.arms["left"].wrench[1, 0])
    assert np.isfinite(log.table).sum() == log.table.size - 1
    second = list(log.measurements())[1]
    assert second.wrenches == {}
    assert set(second.contacts) == {"left"}


def test_a_part_that_is_missing_whole_is_left_out(tmp_path):
    table = rows()
    for name in ("x", "y", "theta", "vx", "vy", "omega"):
        table[2][HEADER.index(name)] = ""
    third = list(read_log(written(tmp_path, text(table))).measurements())[2]
    assert third.pose is None
    assert third.velocity is None


def test_what_is_let_be(tmp_path):
    plain = read_log(written(tmp_path, text()))
    for content in (
        b"\xef\xbb\xbf" + text().encode(),
        text().replace("\n", "\r\n"),
        text().replace("\n", "\n\n"),
        text().replace(",", " , "),
        text().rstrip("\n"),
        text().replace("0.5", '"0.5"'),
        text().replace("0.5", "5e-1"),
    ):
        log = read_log(written(tmp_path, content))
        assert log.columns == plain.columns
        assert np.array_equal(log.table, plain.table)


def test_columns_in_any_order(tmp_path):
    order = np.random.default_rng(1).permutation(len(HEADER))
    table = [[f"{i}.{j:02d}" for j in range(len(HEADER))] for i in range(3)]
    log = read_log(written(tmp_path, text([[r[k] for k in order] for r in table], [HEADER[k] for k in order])))
    assert np.array_equal(log.table, [[float(c) for c in row] for row in table])


def test_several_arms_without_velocity(tmp_path):
    header = ["t", "x", "y", "theta", *(f"{a}.{c[5:]}" for a in ("b", "a c") for c in HEADER[7:])]
    log = read_log(written(tmp_path, text([[str(i)] * len(header) for i in range(3)], header)))
    assert log.velocity is None
    assert list(log.arms) == ["b", "a c"]


REPEATED = [*HEADER, "x"]
MISTAKES = {
    "missing column": (without("theta"), "1: theta", "this column is missing"),
    "missing clock": (without("t"), "1: t", "this column is missing"),
    "missing part of an arm": (without("left.tz"), "1: left.tz", "this column is missing"),
    "missing part of the velocity": (without("vy"), "1: vy", "together or not at all"),
    "unknown column": (text(header=["tt" if c == "omega" else c for c in HEADER]), "1: omega", "is missing"),
    "misspelt column": (text([[*r, "1"] for r in rows()], [*HEADER, "thta"]), "1: thta", "did you mean theta"),
    "column of no name": (text([[*r, "1"] for r in rows()], [*HEADER, ""]), "1: (empty)", "unknown column"),
    "arm with a dot": (
        text([[*r, "1"] for r in rows()], [*HEADER, "a.b.fx"]),
        "1: a.b.fx",
        "unknown column",
    ),
    "duplicate column": (text([[*r, "1"] for r in rows()], REPEATED), "1: x", "stands twice"),
    "bad cell": (spoiled(3, "left.fx", "fast"), "3: left.fx", "'fast' is not a number"),
    "decimal comma": (spoiled(3, "y", '"0,5"'), "3: y", "'0,5' is not a number"),
    "digits in groups": (spoiled(3, "y", "1_000"), "3: y", "'1_000' is not a number"),
    "digits of another script": (spoiled(3, "y", "\u0661"), "3: y", "is not a number"),
    "hexadecimal": (spoiled(3, "y", "0x10"), "3: y", "is not a number"),
    "too few cells": (text([r[:-1] if i == 2 else r for i, r in enumerate(rows())]), "4", "15 cells"),
    "too many cells": (text([[*r, "1"] if i == 2 else r for i, r in enumerate(rows())]), "4", "17 cells"),
    "inf": (spoiled(5, "x", "inf"), "5:2: x", "inf is not a finite number"),
    "minus infinity": (spoiled(5, "x", "-Infinity"), "5:2: x", "not a finite number"),
    "overflow": (spoiled(5, "x", "1e999"), "5:2: x", "not a finite number"),
    "clock repeats": (spoiled(4, "t", "0.01"), "4: t", "repeats"),
    "clock goes back": (spoiled(4, "t", "-1"), "4: t", "goes back"),
    "clock missing": (spoiled(4, "t", ""), "4: t", "without a time"),
    "clock far back": (spoiled(4, "t", "-1.7e308").replace("0.03,", "1.7e308,"), "4: t", "goes back"),
    "empty file": ("", "1", "the file is empty"),
    "header only": (text([]), "2", "no rows"),
    "blank lines only": ("\n\n\n", "1", "the file is empty"),
    "a blank line first": ("\n\n" + text(), "1", "is blank; the header, now in line 3, must stand here"),
    "blanks first": (" \n" + text(), "1", "is blank; the header, now in line 2, must stand here"),
    "blank cells first": (",,,\n" + text(), "1", "is blank; the header, now in line 2, must stand here"),
    "one long line": ("x" * 200_000, "1", "is not CSV"),
    "broken quotes": (spoiled(3, "y", '"0.5"5'), "3", "is not CSV"),
    "cells parted otherwise": (text().replace(",", ";"), "1: t", "cells are parted by ';'; part them by commas"),
    "cells parted by tabs": (text().replace(",", "\t"), "1: t", "part them by commas"),
    "a comment above": ("# of Monday\n" + text(), "1: t", "the first line is a comment"),
    "a comment within": (text().replace("\n0.02", "\n# stop\n0.02"), "4", "a comment, where only rows may stand"),
    "a clock of another name": (text(header=["time", *HEADER[1:]]), "1: t", "is missing; not known are time"),
    "text of two bytes a letter": (text().encode("utf-16-le"), "1: t", "save it as UTF-8"),
    "a cell without end": (spoiled(3, "y", "9" * 10_000), "3:3: y", "9" * 40 + "… is not a finite number"),
    "a NUL": (spoiled(3, "y", "0.\x005"), "3: y", "is not a number"),
}


@pytest.mark.parametrize("kind", MISTAKES)
def test_a_mistake_names_file_line_and_column(tmp_path, kind):
    content, place, why = MISTAKES[kind]
    path = written(tmp_path, content)
    with pytest.raises(LogError, match=re.escape(why)) as caught:
        read_log(path)
    message = str(caught.value)
    assert message.startswith(f"{path}:{place}")
    assert caught.value.place.file == str(path)
    assert len(message.splitlines()) == 1


@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"])
def test_lines_are_counted_as_an_editor_does(tmp_path, ending):
    content = spoiled(5, "x", "bad").replace("\n", ending)
    with pytest.raises(LogError, match=r"run\.csv:5: x: "):
        read_log(written(tmp_path, content))
    lines = spoiled(5, "x", "bad").splitlines()
    lines[1:1] = ["", ""]
    with pytest.raises(LogError, match=r"run\.csv:7: x: "):
        read_log(written(tmp_path, ending.join(lines)))
    lines = text().splitlines()
    quoted = lines[1].replace("0.5", f'"0.5{ending}"', 1)  # a cell that spans two lines
    lines[1:] = [quoted, lines[2], lines[3].replace("0.5", "bad", 1)]
    with pytest.raises(LogError, match=r"run\.csv:5: x: "):
        read_log(written(tmp_path, ending.join(lines)))


def test_not_text(tmp_path):
    with pytest.raises(LogError, match="not UTF-8"):
        read_log(written(tmp_path, bytes(range(256))))
    with pytest.raises(LogError, match="not UTF-8"):
        read_log(written(tmp_path, text().encode("utf-16")))
    with pytest.raises(LogError, match="not UTF-8"):
        read_log(written(tmp_path, text().replace("left", "löft").encode("latin-1")))


def test_no_such_file_a_folder_an_unknown_kind(tmp_path):
    with pytest.raises(LogError, match="no such file"):
        read_log(tmp_path / "nowhere.csv")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(LogError, match="is a folder"):
        read_log(tmp_path / "folder.csv")
    with pytest.raises(LogError, match=r"unknown kind of log '\.txt'; known are \.csv, \.parquet, \.mat"):
        read_log(written(tmp_path, text(), "run.txt"))
    with pytest.raises(LogError, match="can't write"):
        write_log(read_log(written(tmp_path, text())), tmp_path / "run.xlsx")
    assert issubclass(LogError, DataError)


def test_what_cannot_be_written_leaves_nothing(tmp_path):
    log = read_log(written(tmp_path, text()))
    with pytest.raises(CartgraspError, match="can't be written"):
        write_log(log, tmp_path / "nowhere" / "run.csv")
    (tmp_path / "there.csv").mkdir()
    with pytest.raises(CartgraspError, match="can't be written"):
        write_log(log, tmp_path / "there.csv")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.csv", "there.csv"]
