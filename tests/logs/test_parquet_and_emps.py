"""Parquet logs equal CSV ones; the EMPS data set's .mat; what is broken is refused by its place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from cartgrasp.errors import LogError
from cartgrasp.logs import read_log, write_log

from .tables import HEADER, random_log

arrow = pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
parquet = pytest.importorskip("pyarrow.parquet", reason="the extra `parquet` is not installed")

EMPS = Path(__file__).parents[3] / "shared" / "data" / "emps" / "DATA_EMPS.mat"


@pytest.mark.parametrize("velocity", [True, False])
def test_parquet_is_csv(tmp_path, velocity):
    log = random_log(np.random.default_rng(3), velocity=velocity)
    log.arms["left"].wrench[3, 2] = np.nan
    log.pose[5] = np.nan
    write_log(log, tmp_path / "run.csv")
    write_log(log, tmp_path / "run.parquet")
    first, second = read_log(tmp_path / "run.csv"), read_log(tmp_path / "run.parquet")
    assert first.columns == second.columns == log.columns
    assert np.array_equal(first.table, second.table, equal_nan=True)
    assert np.array_equal(second.table, log.table, equal_nan=True)
    assert parquet.ParquetFile(tmp_path / "run.parquet").read().column("x").null_count == 1


def columns(n=3):
    return {name: [0.25 * i for i in range(n)] for name in HEADER}


def stored(folder, table, name="run.parquet"):
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    parquet.write_table(arrow.table(table), path)
    return path


def test_whole_numbers_and_nulls(tmp_path):
    table = columns() | {"x": [1, 2, 3], "left.fx": [None, 1.0, np.nan], "left.pz": [None] * 3}
    log = read_log(stored(tmp_path, table))
    assert log.pose[:, 0].tolist() == [1, 2, 3]
    assert np.isnan(log.arms["left"].wrench[:, 0]).tolist() == [True, False, True]
    assert np.isnan(log.arms["left"].contact[:, 2]).all()


def test_a_folder_with_an_equals_sign_adds_no_column(tmp_path):
    assert read_log(stored(tmp_path, columns(), "day=3/run.parquet")).columns == tuple(HEADER)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x": ["1", "2", "3"]}, r"run\.parquet: x: holds string, not numbers"),
        ({"x": [True, False, True]}, r"run\.parquet: x: holds bool, not numbers"),
        ({"x": [[1.0], [2.0], [3.0]]}, r"run\.parquet: x: holds list.*, not numbers"),
        ({"x": [0.0, np.inf, 0.0]}, r"run\.parquet:2: x: is not a finite number"),
        ({"t": [0.0, 0.0, 1.0]}, r"run\.parquet:2: t: 0 s repeats"),
        ({"t": [0.0, None, 1.0]}, r"run\.parquet:2: t: a row without a time"),
        ({"thta": [0.0, 0.0, 0.0]}, r"run\.parquet:1: thta: unknown column.*did you mean theta"),
    ],
)
def test_a_mistake_in_parquet(tmp_path, change, message):
    with pytest.raises(LogError, match=message):
        read_log(stored(tmp_path, columns() | change))


def test_broken_parquet(tmp_path):
    good = stored(tmp_path, columns()).read_bytes()
    for content in (b"", b"PAR1", good[:-20], good[: len(good) // 2], b"PAR1" + bytes(100) + b"PAR1"):
        (tmp_path / "bad.parquet").write_bytes(content)
        with pytest.raises(LogError, match="can't be read as Parquet"):
            read_log(tmp_path / "bad.parquet")
    with pytest.raises(LogError, match="no rows"):
        read_log(stored(tmp_path, {name: arrow.array([], arrow.float64()) for name in HEADER}))
    table = columns()
    del table["y"]
    with pytest.raises(LogError, match=r"run\.parquet:1: y: this column is missing"):
        read_log(stored(tmp_path, table))


def axis(n=40, **changes):
    t = 0.001 * np.arange(n)
    return {
        "t": t[:, None],
        "qm": np.sin(t)[:, None],
        "qg": np.sin(t)[:, None],
        "vir": np.cos(t)[:, None],
        "gtau": 35.15,
    } | changes


@pytest.mark.parametrize("version", ["4", "5"])
def test_emps_from_a_synthetic_file(tmp_path, version):
    savemat(tmp_path / "axis.mat", axis(), format=version)
    log = read_log(tmp_path / "axis.mat")
    t = 0.001 * np.arange(40)
    assert list(log.arms) == ["drive"]
    assert np.array_equal(log.time, t)
    assert np.array_equal(log.pose, np.column_stack([np.sin(t), 0 * t, 0 * t]))
    assert log.velocity is None
    assert log.arms["drive"].wrench[:, 0] == pytest.approx(35.15 * np.cos(t), rel=1e-15)
    assert not log.arms["drive"].wrench[:, 1:].any()
    assert not log.arms["drive"].contact.any()


def test_rows_of_a_matlab_file_may_lie(tmp_path):
    savemat(tmp_path / "axis.mat", {k: np.ravel(v)[None, :] for k, v in axis().items()})
    assert len(read_log(tmp_path / "axis.mat")) == 40


@pytest.mark.parametrize(
    ("change", "key", "why"),
    [
        *(({key: None}, key, "this variable is missing") for key in ("t", "qm", "vir", "gtau")),
        ({"t": axis(39)["t"]}, "t", "39 times, 40 positions"),
        ({"t": np.zeros((40, 1))}, "t", "strictly increasing"),
        ({"t": np.full((40, 1), np.nan)}, "t", "strictly increasing"),
        ({"qm": "words"}, "qm", "does not hold real numbers"),
        ({"qm": np.ones((40, 1)) * 1j}, "qm", "does not hold real numbers"),
        ({"qm": {"inner": 3.0}}, "qm", "does not hold real numbers"),
        ({"qm": np.array([[1.0], ["a"]], dtype=object)}, "qm", "does not hold real numbers"),
        ({"vir": np.full((40, 1), np.inf)}, "vir", "not finite"),
        ({"gtau": np.ones(3)}, "gtau", "3 numbers; one is needed"),
        ({"gtau": np.zeros((0, 0))}, "gtau", "0 numbers; one is needed"),
        ({k: v[:1] for k, v in axis().items() if k != "gtau"}, "t", "two rows or more"),
    ],
)
def test_a_mistake_in_a_matlab_file(tmp_path, change, key, why):
    path = tmp_path / "axis.mat"
    savemat(path, {k: v for k, v in axis(**change).items() if v is not None})
    with pytest.raises(LogError) as caught:
        read_log(path)
    assert str(caught.value).startswith(f"{path}: {key}: ")
    assert why in str(caught.value)


def test_broken_matlab_files(tmp_path):
    savemat(tmp_path / "axis.mat", axis(), do_compression=True)
    good = (tmp_path / "axis.mat").read_bytes()
    hdf5 = b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + b"\x89HDF\r\n\x1a\n" + bytes(100)
    spoiled = bytes(b ^ 0x5A if i > 150 and i % 37 == 0 else b for i, b in enumerate(good))
    for content in (b"", b"not a mat file", good[:100], good[:200], good[:-30], hdf5, spoiled):
        (tmp_path / "bad.mat").write_bytes(content)
        with pytest.raises(LogError, match=r"bad\.mat: "):
            read_log(tmp_path / "bad.mat")


@pytest.mark.skipif(not EMPS.is_file(), reason=f"the EMPS data set is not at {EMPS}")
def test_the_real_axis():
    log = read_log(EMPS)
    assert len(log) > 20_000
    assert np.median(np.diff(log.time)) == pytest.approx(0.001, rel=1e-4)
    assert 0.1 < np.ptp(log.pose[:, 0]) < 1.0
    assert log.thinned().duration == pytest.approx(log.duration, abs=0.01)
