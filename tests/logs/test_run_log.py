"""`RunLog`: thinning averages wrenches; and whatever bytes come, only this library's errors come out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.errors import CartgraspError, DataError
from cartgrasp.logs import ArmLog, RunLog, read_log

from .tables import random_log, text


def even_log(n, step, start=3.0):
    rng = np.random.default_rng(7)
    arms = {"left": ArmLog(rng.normal(size=(n, 3)), rng.normal(size=(n, 6)))}
    return RunLog(start + step * np.arange(n), rng.normal(size=(n, 3)), rng.normal(size=(n, 3)), arms)


@pytest.mark.parametrize(("step", "size"), [(0.001, 4), (0.0005, 8), (0.002, 2), (0.0001, 40)])
def test_thinning_averages_wrenches_and_picks_poses(step, size):
    log = even_log(103, step)
    thin = log.thinned(250.0)
    n = 103 // size
    assert len(thin) == n
    for i in range(n):
        part = slice(i * size, (i + 1) * size)
        assert thin.time[i] == log.time[part][0]
        assert np.array_equal(thin.pose[i], log.pose[part][0])
        assert np.array_equal(thin.velocity[i], log.velocity[part][0])
        assert np.array_equal(thin.arms["left"].contact[i], log.arms["left"].contact[part][0])
        assert thin.arms["left"].wrench[i] == pytest.approx(log.arms["left"].wrench[part].mean(axis=0))


def test_a_clock_that_goes_back_is_told_to_the_digit():
    """In unix time, too: nine digits said that 1.7e+09 s came after 1.7e+09 s."""
    time = 1.7e9 + np.array([0.0, 0.25, 0.125])
    with pytest.raises(DataError, match=r"1700000000\.125 s in row 2 after 1700000000\.25 s"):
        RunLog(time, np.zeros((3, 3)), None, {})


def test_slow_logs_stay():
    for step in (0.004, 0.01, 0.0033, 1.0):
        log = even_log(20, step)
        assert log.thinned() is log


def test_a_missing_wrench_makes_its_mean_missing():
    log = even_log(12, 0.001)
    log.arms["left"].wrench[5, 0] = np.nan
    thin = log.thinned()
    assert np.isnan(thin.arms["left"].wrench[:, 0]).tolist() == [False, True, False]


@pytest.mark.parametrize("first", range(8))
def test_sensors_with_rates_of_their_own_lose_nothing_to_thinning(first):
    """At 1 kHz, poses at 125 Hz and wrenches at 500 Hz: from most rows to begin with, all poses were lost."""
    log = even_log(800, 0.001)
    poses, wrenches = np.arange(first, 800, 8), np.arange(1 - first % 2, 800, 2)
    log.pose[np.setdiff1d(np.arange(800), poses)] = np.nan
    log.velocity[np.setdiff1d(np.arange(800), poses)] = np.nan
    told, arm = log.pose[poses].copy(), log.arms["left"]
    arm.wrench[np.setdiff1d(np.arange(800), wrenches)] = np.nan
    arm.contact[1:] = np.nan
    thin = log.thinned()
    kept = np.isfinite(thin.pose).all(axis=1)
    np.testing.assert_array_equal(thin.pose[kept], told)
    np.testing.assert_array_equal(thin.time[kept], log.time[poses])
    assert np.isfinite(thin.velocity[kept]).all()
    assert (np.diff(thin.time) > 0).all()
    assert np.isfinite(thin.arms["left"].contact[0]).all()
    pairs = arm.wrench[wrenches].reshape(-1, 2, 6).mean(axis=1)
    np.testing.assert_allclose(thin.arms["left"].wrench, pairs)


@pytest.mark.parametrize("times", [[0.0], [0, 1e-6, 2e-6], [0, 5e-324, 1e-323], [-1.7e308, 0.0, 1.7e308]])
def test_odd_clocks_can_be_thinned(times):
    n = len(times)
    log = RunLog(np.array(times), np.zeros((n, 3)), None, {"a": ArmLog(np.zeros((n, 3)), np.zeros((n, 6)))})
    thin = log.thinned()
    assert 1 <= len(thin) <= n
    assert thin.time[0] == times[0]


def test_measurements_and_back():
    log = random_log(np.random.default_rng(5))
    log.pose[3] = np.nan
    log.velocity[4] = np.nan
    log.arms["left"].wrench[6] = np.nan
    back = RunLog.from_measurements(list(log.measurements()), ["left", "right"])
    assert np.array_equal(back.table, log.table, equal_nan=True)


@pytest.mark.parametrize("times", [[], [0.0, 0.0], [1.0, 0.0], [0.0, np.nan], [0.0, np.inf]])
def test_a_log_needs_a_clock(times):
    n = len(times)
    with pytest.raises(DataError):
        RunLog(np.array(times), np.zeros((n, 3)), None, {"a": ArmLog(np.zeros((n, 3)), np.zeros((n, 6)))})


def only_our_errors(path):
    said = ""
    try:
        assert len(read_log(path)) > 0
    except CartgraspError as error:
        said = str(error)
    assert not said or str(path) in said


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz")


@settings(max_examples=150)
@given(content=st.binary(max_size=300), suffix=st.sampled_from(["csv", "mat", "parquet"]))
def test_random_bytes(folder, content, suffix):
    path = folder / f"run.{suffix}"
    path.write_bytes(content)
    only_our_errors(path)


@settings(max_examples=150)
@given(st.text(alphabet=st.one_of(st.characters(codec="utf-8"), st.sampled_from(',.\n\r"te0x')), max_size=200))
def test_random_text(folder, content):
    path = folder / "run.csv"
    path.write_bytes(content.encode())
    only_our_errors(path)


EDITS = st.lists(
    st.tuples(st.integers(0, 600), st.integers(0, 3), st.sampled_from([*'\0\n\r,".-_e9', "inf", "nan", "\ufeff"])),
    min_size=1,
    max_size=4,
)


@settings(max_examples=200)
@given(EDITS)
def test_a_good_log_with_random_edits(folder, edits):
    content = text()
    for at, removed, added in edits:
        at %= len(content)
        content = content[:at] + added + content[at + removed :]
    path = folder / "run.csv"
    path.write_bytes(content.encode())
    only_our_errors(path)


@settings(max_examples=150)
@given(
    st.integers(1, 2**31),
    st.sampled_from(["parquet", "mat4"]),
    st.integers(0, 20),
)
def test_good_binary_files_with_random_edits(folder, seed, kind, removed):
    """Not with .mat of version 5: scipy 1.17's reader of it breaks the process on some spoiled bytes."""
    rng = np.random.default_rng(seed)
    content = bytearray(binary_log(folder, kind))
    for at in rng.integers(0, len(content), rng.integers(1, 6)):
        content[at] = rng.integers(0, 256)
    path = folder / f"fuzz.{kind.rstrip('4')}"
    path.write_bytes(content[: len(content) - removed])
    only_our_errors(path)


@pytest.mark.parametrize("share", np.linspace(0, 0.99, 12).tolist())
def test_a_matlab_file_that_is_cut(folder, share):
    content = binary_log(folder, "mat")
    path = folder / "cut.mat"
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(CartgraspError):
        read_log(path)


def binary_log(folder, kind, made={}):  # noqa: B006 - made once
    if kind not in made:
        from scipy.io import savemat

        from cartgrasp.logs import write_log

        path = folder / f"good.{kind.rstrip('4')}"
        if kind == "parquet":
            pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
            write_log(even_log(5, 0.01), path)
        else:
            t = np.arange(5.0)
            savemat(path, {"t": t, "qm": t, "qg": t, "vir": t, "gtau": 2.0}, format="4" if kind == "mat4" else "5")
        made[kind] = path.read_bytes()
    return made[kind]
