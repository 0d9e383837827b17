"""Impacts: on motions in closed form, on what only looks like one, on generated logs, on carts that really bounced."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.sealed.generate import generate
from cartgrasp.cart_file import load_cart
from cartgrasp.constraints import RollingConstraints
from cartgrasp.contacts import ContactWrenches
from cartgrasp.effects import EndStop, RollingResistance
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog, read_log
from cartgrasp.model import CartModel
from cartgrasp.simulation.plant import ModelPlant
from estimation.impacts.end_stops import end_stops
from estimation.impacts.impacts import impacts

RAIL = CartModel(Inertia(20.0, (0.0, 0.0), 2.0), RollingConstraints(0.0, no_rotation=True))
INCLINE = Path(__file__).parents[4] / "shared" / "data" / "real" / "incline"
WALL, PULL, FIRST = 1.0, 0.3, 1.0
SENSORS = pytest.mark.parametrize(
    ("rate", "noise", "step"),
    [
        (500.0, 3e-4, 0.0),
        (100.0, 0.0, 0.0),
        (100.0, 1e-3, 0.0),
        (100.0, 0.0, 0.01),
        (50.0, 1e-3, 0.0),
        (25.0, 5e-4, 0.002),
    ],
    ids=["500 Hz", "exact", "1 mm", "1 cm steps", "50 Hz", "25 Hz"],
)


def sensed(time, way, noise=0.0, step=0.0, seed=0, wrench=None, heading=0.0):
    """A log of a way (n,) along a heading, with noise, or rounded to steps, and the force of one arm."""
    way = way + np.random.default_rng(seed).normal(0.0, noise, len(time)) if noise else way
    way = np.round(way / step) * step if step else way
    pose = np.column_stack([way * np.cos(heading), way * np.sin(heading), np.full(len(time), heading)])
    arms = {}
    if wrench is not None:
        arms = {"hand": ArmLog(np.zeros((len(time), 3)), np.pad(wrench[:, None], ((0, 0), (0, 5))))}
    return RunLog(time, pose, None, arms)


def bouncing(rate, share, lasts=0.0, flights=4):
    """Times, places and (time, speed before, speed after) of a cart that comes down a slope on a wall: each flight is
    a parabola, each touch of `lasts` (s) a half sine whose ends have the speeds of the flights (their difference is
    spread over it, as by a damper)."""
    speed, begin = np.sqrt(2 * PULL * 0.6), np.sqrt(2 * 0.6 / PULL)
    pieces = [(FIRST, FIRST + begin, lambda t, s=FIRST: 0.4 + PULL * (t - s) ** 2 / 2)]
    hits, now = [], FIRST + begin
    for _ in range(flights):
        after = share * speed
        hits.append((now + lasts / 2, speed, -after))
        if lasts:
            pieces.append((now, now + lasts, lambda t, s=now, v=speed, w=after: _touched(t - s, v, w, lasts)))
        now += lasts
        pieces.append(
            (now, now + 2 * after / PULL, lambda t, s=now, v=after: WALL - v * (t - s) + PULL * (t - s) ** 2 / 2)
        )
        now, speed = now + 2 * after / PULL, after
    time = np.arange(0.0, now - 0.5, 1 / rate)
    way = np.full(len(time), 0.4)
    for start, stop, place in pieces:
        inside = (time >= start) & (time < stop)
        way[inside] = place(time[inside])
    return time, way, [hit for hit in hits if hit[0] < time[-1]]


def _touched(since, before, after, lasts):
    """A cubic from the speed before to the one after, that begins and ends at the wall."""
    s = since / lasts
    return WALL + lasts * (before * s * (1 - s) ** 2 + after * s**2 * (1 - s))


@SENSORS
@pytest.mark.parametrize("lasts", [0.0, 0.03, 0.08])
@pytest.mark.parametrize("share", [0.5, 0.8])
def test_bounces_are_found_with_time_place_and_speeds(rate, noise, step, lasts, share):
    time, way, hits = bouncing(rate, share, lasts)
    found = impacts(sensed(time, way, noise, step), RAIL)
    clear = 0.6 if step == 0.01 else 0.4
    strong = [hit for hit in hits if hit[1] - hit[2] > clear and hit[0] < time[-1] - 0.5]
    assert strong
    assert len(strong) <= len(found) <= len(hits)
    for at, before, after in strong:
        (impact,) = [one for one in found if abs(one.time - at) < 0.1]
        assert impact.time == pytest.approx(at, abs=0.03)
        assert impact.speed_before == pytest.approx(before, rel=0.1)
        assert impact.speed_after == pytest.approx(after, rel=0.1)
        assert impact.pose == pytest.approx([WALL, 0.0, 0.0], abs=0.005 + 0.5 * lasts * before)


@settings(max_examples=12)
@given(share=st.floats(0.85, 0.95), start=st.floats(0.0, 0.01))
def test_what_no_single_bounce_shows_a_stop_does(share, start):
    """At 33 Hz and in steps of 1 cm most bounces look as smooth as sudden; all of them, at one place, do not."""
    time, way, hits = bouncing(33.3, share, flights=7)
    found = impacts(sensed(time, way - start, step=0.01), RAIL)
    strong = [at for at, before, after in hits if before - after > 0.6 and at < time[-1] - 0.5]
    assert len(strong) >= 4
    assert sum(any(abs(one.time - at) < 0.05 for one in found) for at in strong) >= len(strong) - 1
    assert all(one.pose[0] == pytest.approx(WALL - start, abs=0.02) for one in found)


@settings(max_examples=12)
@given(heading=st.floats(-3.1, 3.1), seed=st.integers(0, 999), late=st.floats(0.0, 1e5))
def test_where_a_rail_lies_and_when_does_not_matter(heading, seed, late):
    time, way, hits = bouncing(100.0, 0.7)
    found = impacts(sensed(time + late, way, 5e-4, seed=seed, heading=heading), RAIL)
    assert [one.time - late for one in found[:2]] == pytest.approx([hit[0] for hit in hits[:2]], abs=0.03)
    for one in found[:2]:
        assert one.pose[:2] == pytest.approx([WALL * np.cos(heading), WALL * np.sin(heading)], abs=0.01)
        assert one.pose[2] == pytest.approx(heading)


# --- what is none --------------------------------------------------------------------------------------------

FINE = np.arange(0.0, 20.0, 0.001)


def driven(acceleration, noise, step, seed=0, jump=0.0, **more):
    """A log at 100 Hz of an acceleration (n,) at the times FINE."""
    speed = 0.3 + np.cumsum(acceleration) * 0.001
    way = np.cumsum(speed) * 0.001 + jump
    every = slice(None, None, 10)
    more = {key: value[every] for key, value in more.items()}
    return sensed(FINE[every], way[every], noise, step, seed, **more)


def pushes(random, lasts, most=2.0):
    """Half sines, one every 3 s."""
    found = np.zeros(len(FINE))
    for i in range(6):
        since = (FINE - 3 * i - random.uniform(1.0, 1.5)) / lasts
        found += random.choice([-1, 1]) * random.uniform(0.5, 1.0) * most * np.sin(np.pi * np.clip(since, 0, 1))
    return found


def smooth_pushes(random):
    return {"acceleration": pushes(random, random.uniform(0.4, 1.5))}


def steps_of_acceleration(random):
    return {"acceleration": np.repeat(random.uniform(-1, 1, 10), 2000)}


def waves(random):
    return {"acceleration": np.sin(2 * np.pi * random.uniform(1.0, 3.0) * FINE) * np.sin(FINE)}


def jumps(random):
    at = random.uniform(1, 19, 8)
    return {
        "acceleration": 0.5 * np.sin(FINE),
        "jump": (random.uniform(-0.05, 0.05, (8, 1)) * (at[:, None] < FINE)).sum(axis=0),
    }


def glitches(random):
    at, lasts = random.uniform(1, 19, 8), random.uniform(0.01, 0.3, 8)
    there = (at[:, None] < FINE) & ((at + lasts)[:, None] > FINE)
    return {"acceleration": 0.5 * np.sin(FINE), "jump": (random.uniform(-0.05, 0.05, (8, 1)) * there).sum(axis=0)}


def slow(random):
    return {"acceleration": -0.3 * 0.4 * np.cos(0.4 * FINE + random.uniform(0, 6)) * random.uniform(0.1, 1)}


def to_and_fro(random):
    """Turned round at the same two places, again and again."""
    half, speed = random.uniform(0.15, 0.5), random.uniform(0.3, 1.0)
    phase = (FINE + random.uniform(0.5, 1.5)) % 4.0
    turning = (np.abs(phase - 2.0) < half).astype(float) - (np.minimum(phase, 4.0 - phase) < half)
    return {"acceleration": speed / half * turning}


@pytest.mark.long
@pytest.mark.some(12)
@pytest.mark.parametrize(("noise", "step"), [(0.0, 0.0), (5e-4, 0.0), (3e-3, 0.0), (0.0, 0.01)])
@pytest.mark.parametrize("motion", [smooth_pushes, steps_of_acceleration, waves, jumps, glitches, slow, to_and_fro])
def test_what_is_not_sudden_or_no_motion_is_no_impact(motion, noise, step):
    """By design one log in a hundred has one."""
    told = [impacts(driven(noise=noise, step=step, seed=s, **motion(np.random.default_rng(s))), RAIL) for s in range(5)]
    assert told == [()] * 5


def test_poses_that_come_several_times_are_no_steps():
    log = driven(0.5 * np.sin(FINE), 3e-4, 0.0)
    held = log.pose[np.arange(len(log)) // 4 * 4]
    assert impacts(RunLog(log.time, held, None, {}), RAIL) == ()


def test_a_cart_that_stands_is_not_hit():
    for noise in (0.0, 1e-3):
        assert impacts(driven(np.zeros(len(FINE)), noise, 0.0), RAIL) == ()


@pytest.mark.parametrize("n", [1, 2, 5, 30])
def test_short_logs_and_holes(n):
    time, way, _ = bouncing(100.0, 0.8)
    assert impacts(sensed(time[:n], way[:n]), RAIL) == ()
    whole = sensed(time, way, 5e-4)
    hit = impacts(whole, RAIL)[0]
    pose = whole.pose.copy()
    pose[np.abs(time - hit.time) < 0.15] = np.nan
    unseen = impacts(RunLog(time, pose, None, {}), RAIL)
    assert all(abs(one.time - hit.time) > 1.0 for one in unseen)
    assert impacts(RunLog(time, np.full_like(pose, np.nan), None, {}), RAIL) == ()


# --- wrenches ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("guess", [1 / 3, 1.0, 3.0])
def test_what_the_arms_did_is_explained_whatever_the_first_guess(guess):
    """Blows of 50 ms, of 0.2 to 0.3 m/s, beside a steady 15 N; then the same blows that no sensor felt, and blows at
    which the hand that goes on pushing feels the opposite of what the cart does."""
    blow = pushes(np.random.default_rng(3), 0.05, 10.0)
    cart = CartModel(Inertia(20.0 * guess, (0.0, 0.0), 2.0), RAIL.constraints)
    steady = np.full(len(FINE), 15.0)
    assert impacts(driven(blow, 5e-4, 0.0, wrench=steady + 20.0 * blow), cart) == ()
    assert len(impacts(driven(blow, 5e-4, 0.0, wrench=steady), cart)) == 6
    assert len(impacts(driven(blow, 5e-4, 0.0, wrench=steady - 20.0 * blow), cart)) == 6


# --- carts in the plane --------------------------------------------------------------------------------------


@pytest.mark.parametrize("heading", [0.0, 0.5, -2.6])
def test_a_turning_cart_against_a_wall(heading):
    """It rolls in a curve against a stop, of our plant; momentum says how fast it leaves."""
    stop = EndStop(1.0, restitution=0.6) if abs(heading) < 1.5 else EndStop(-1.0, -1.0, 0.6)
    cart = CartModel(Inertia(24.0, (0.2, 0.05), 2.0), RollingConstraints(0.0), (stop, RollingResistance(0.01)))
    plant = ModelPlant(cart, (0.0, 0.0, heading), [0.8, 0.15])
    rows = []
    for _ in range(400):
        rows.append((plant.time, *plant.motion.pose_sb, *plant.motion.velocity))
        plant.step(ContactWrenches({}, {}), 0.01)
    time, *pose, u, _ = np.array(rows).T
    hit = int(np.argmax(np.abs(np.diff(u))))
    noise = np.random.default_rng(1).normal(0, 5e-4, (400, 3))
    (found,) = impacts(RunLog(time, np.array(pose).T + noise, None, {}), cart.without_effect("end_stop"))
    assert found.time == pytest.approx(time[hit], abs=0.03)
    assert found.pose[0] == pytest.approx(stop.position, abs=0.005)
    assert found.speed_before == pytest.approx(u[hit], rel=0.05)
    assert found.speed_after == pytest.approx(u[hit + 1], rel=0.05)


# --- logs of others ------------------------------------------------------------------------------------------


@pytest.mark.some(1)
@pytest.mark.long
@pytest.mark.parametrize("is_rough", [False, True])
def test_generated_logs_of_pushed_carts_have_none(tmp_path, is_rough):
    generate(tmp_path, ["nothing", "rolling_resistance", "external_push"], [0], "rich", is_rough=is_rough)
    folders = sorted((tmp_path / "logs").iterdir())
    assert len(folders) == 3
    for folder in folders:
        assert impacts(read_log(folder / "run.csv"), load_cart(folder / "cart.yaml")) == ()


@pytest.mark.skipif(not INCLINE.is_dir(), reason="the measured logs are not part of the project")
@pytest.mark.parametrize(("name", "least"), [("good_cart", 6), ("magnetic_bumper", 5), ("sail", 3)])
def test_carts_that_really_bounced(name, least):
    """Places of 1 cm at 100 Hz; the bumper is at about 1.15 m, and each bounce is lower than the last."""
    found = impacts(read_log(INCLINE / f"{name}.csv"), RAIL)
    assert len(found) >= least
    for one in found:
        assert one.pose[0] == pytest.approx(1.15, abs=0.03)
        assert one.speed_before > 0.1 > -0.1 > one.speed_after
    before = [one.speed_before for one in found]
    assert all(later < 1.1 * sooner for sooner, later in pairwise(before))
    (stop,) = end_stops(found)
    assert stop.position == pytest.approx(1.15, abs=0.03)
    assert 0.7 < stop.restitution < 1.0


@pytest.mark.skipif(not INCLINE.is_dir(), reason="the measured logs are not part of the project")
def test_a_cart_that_really_stood():
    assert impacts(read_log(INCLINE / "still.csv"), RAIL) == ()


def test_an_impact_as_a_report_tells_it():
    time, way, _ = bouncing(100.0, 0.8)
    first = impacts(sensed(time, way), RAIL)[0].as_dict()
    assert list(first) == ["time", "pose", "speed_before", "speed_after"]
    assert first["pose"] == pytest.approx([WALL, 0.0, 0.0], abs=0.001)
