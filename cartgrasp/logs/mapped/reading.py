"""From a bag or a table to a run log, step by step, each with its counts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import LogError, Place, printable
from ...frames import Array
from ..run_log import ArmLog, RunLog
from .planar_pose import of_body, spline_velocity, world_velocity
from .processing_steps import ProcessingStep, ProcessingSteps
from .resampling import averaged, held, interpolated
from .run_map import ArmEntry, MapFile, RunMap
from .sensor_wrench import at_contact, on_cart
from .timed_samples import MapPlace, TimedSamples

MIN_TARE_SAMPLES = 5
MAX_TARE_MOTION, MAX_TARE_ROTATION = 0.005, 0.01
MAX_ROWS_PER_SAMPLE = 50


@dataclass(frozen=True)
class MapReading:
    """A log, how it came about, and what was lost on the way."""

    log: RunLog
    map: RunMap
    steps: tuple[ProcessingStep, ...]
    lost: tuple[str, ...]


@dataclass(frozen=True)
class MappedSamples:
    """Samples of the bag or the table `name` by their place in its map: poses (n, 3) of the tracked frame, its twist
    (n, 3) where the map wants one, along its own axes if not `is_velocity_in_world`, wrenches (n, 6) as they were read,
    contact points (n, 3). `tilt` is the largest angle between the tracked frame's z and the vertical, rad; None where
    all is planar."""

    name: str
    map_file: MapFile[Any]
    samples: Mapping[MapPlace, TimedSamples]
    steps: ProcessingSteps
    tilt: float | None = None
    lost: Sequence[str] = ()
    is_velocity_in_world: bool = False

    def log(self) -> MapReading:
        """The run log of them, with how it came about."""
        map_ = self.map_file.map
        self._check_steps()
        tracked = self._tracked()
        wrenches = {name: self._wrench(name, arm, tracked) for name, arm in map_.arms.items()}
        time = self._clock()
        pose = interpolated(tracked.time, tracked.numbers, time, tracked.bridged(map_.max_gap))
        figures = {"taken": pose.taken, "interpolated": pose.interpolated, "masked": pose.masked}
        self.steps.add("pose", "on the log's clock", **figures)
        velocity = self._velocity(tracked, pose.rows, time)
        arms = {}
        for name, arm in map_.arms.items():
            wrench = wrenches[name]
            rows = averaged(wrench.time, wrench.numbers, time, wrench.bridged(map_.max_gap))
            figures = {"averaged": rows.taken, "interpolated": rows.interpolated, "masked": rows.masked}
            self.steps.add(name, "wrenches on the log's clock", **figures)
            arms[name] = ArmLog(self._contact(name, arm, time), rows.rows)
        notes = {f"step {i + 1}": str(step) for i, step in enumerate(self.steps.done)}
        log = RunLog(time, pose.rows, velocity, arms, self.name, notes)
        return MapReading(log, map_, tuple(self.steps.done), tuple(self.lost))

    def _check_steps(self) -> None:
        for where, samples in self.samples.items():
            if samples.is_slower(self.map_file.map.max_gap) and len(where) < 3:
                step = samples.usual_step
                why = f"{'.'.join(where)} has a sample every {step:.3g} s, so all would be gaps; state a longer one"
                raise self.map_file.refuse(("max_gap",), why)

    def _tracked(self) -> TimedSamples:
        """The poses of {b}."""
        samples, entry = self.samples["pose",], self.map_file.map.pose
        pose = of_body(samples.numbers, np.array(entry.body))
        turned = pose[:, 2][np.isfinite(pose[:, 2])]
        wraps = round(float(np.ptp(turned)) / (2 * np.pi)) if len(turned) else 0
        figures: dict[str, float | int | str] = {"whole_turns": wraps}
        if self.tilt is not None:
            figures = {"largest_tilt_deg": float(np.degrees(self.tilt)), **figures}
        self.steps.add("pose", "planar pose of {b}, yaw unwrapped", **figures)
        return TimedSamples(samples.time, pose)

    def _wrench(self, name: str, arm: ArmEntry, tracked: TimedSamples) -> TimedSamples:
        samples = self.samples["arms", name]
        wrench = on_cart(samples.numbers, arm)
        if arm.force == "on_sensor":
            self.steps.add(name, "signs turned: readings are what the sensor feels", samples=len(wrench))
        if arm.tool is not None:
            self.steps.add(name, "weight of the tool taken off", mass_kg=arm.tool.mass, samples=len(wrench))
        if arm.tare is not None:
            wrench = wrench - self._tare(name, arm.tare, samples.time, wrench, tracked)
        if any(arm.sensor.position) or any(arm.sensor.rpy):
            wrench = at_contact(wrench, arm)
            self.steps.add(name, "from the sensor's frame to the contact frame", samples=len(wrench))
        return TimedSamples(samples.time, wrench)

    def _tare(self, name: str, still: list[float], time: Array, wrench: Array, tracked: TimedSamples) -> Array:
        """Mean (6,) of the readings in a stretch in which the cart stands still."""
        where = ("arms", name, "tare")
        inside = (time >= still[0]) & (time <= still[1]) & np.isfinite(wrench).all(axis=1)
        if inside.sum() < MIN_TARE_SAMPLES:
            raise self.map_file.refuse(where, f"{inside.sum()} readings in it; {MIN_TARE_SAMPLES} are needed")
        there = (tracked.time >= still[0]) & (tracked.time <= still[1]) & np.isfinite(tracked.numbers).all(axis=1)
        poses = tracked.numbers[there]
        if len(poses) < MIN_TARE_SAMPLES:
            raise self.map_file.refuse(where, f"{len(poses)} poses in it: whether the cart stands still can't be told")
        parts = np.array([np.median(part, axis=0) for part in np.array_split(poses, MIN_TARE_SAMPLES)])
        moved, turned = np.ptp(parts, axis=0)[:2].max(), np.ptp(parts[:, 2])
        if moved > MAX_TARE_MOTION or turned > MAX_TARE_ROTATION:
            why = f"the cart moves {1e3 * moved:.0f} mm and {turned:.2g} rad in it; name one in which it stands still"
            raise self.map_file.refuse(where, why)
        mean = wrench[inside].mean(axis=0)
        figures = {k: float(v) for k, v in zip(("fx", "fy", "fz", "tx", "ty", "tz"), mean, strict=True)}
        self.steps.add(name, "tare taken off", readings=int(inside.sum()), **figures)
        return np.asarray(mean)

    def _clock(self) -> Array:
        """The log's times: those that the map names, where all topics have begun and none has ended."""
        map_ = self.map_file.map
        spans = {where: samples.span() for where, samples in self.samples.items() if len(where) < 3}
        start, end = max(first for first, _ in spans.values()), min(last for _, last in spans.values())
        if start > end:
            said = ", ".join(f"{'.'.join(where)} from {a:.3f} to {b:.3f} s" for where, (a, b) in spans.items())
            raise self._refuse(f"its parts have no time in common: {said}")
        if isinstance(map_.clock, str):
            times = self.samples[("pose",) if map_.clock == "pose" else ("arms", map_.clock)].time
            kept = times[(times >= start) & (times <= end)]
            figures = {"rows": len(kept), "left out": len(times) - len(kept)}
            self.steps.add("log", f"rows at the stamps of {map_.clock}", **figures)
        else:
            kept = self._even(map_.clock, start, end)
            self.steps.add("log", "rows at an even rate", rows=len(kept), rate_Hz=map_.clock)
        if not len(kept):
            raise self._refuse(f"no stamp of {map_.clock} between {start:.3f} and {end:.3f} s, where all topics are")
        return kept

    def _refuse(self, why: str) -> LogError:
        return LogError(Place(self.name), "", printable(why))

    def _even(self, rate: float, start: float, end: float) -> Array:
        rows = (end - start) * rate
        if rows > MAX_ROWS_PER_SAMPLE * max(len(samples.time) for samples in self.samples.values()):
            why = f"{rows:.3g} rows from {start:.6g} to {end:.6g} s, far more than there are samples: is a stamp wrong?"
            raise self.map_file.refuse(("clock",), why)
        return np.asarray(start + np.arange(int(rows + 1e-9) + 1) / rate)

    def _velocity(self, tracked: TimedSamples, pose: Array, time: Array) -> Array | None:
        entry, max_gap = self.map_file.map.pose, self.map_file.map.max_gap
        if entry.velocity == "none":
            return None
        if entry.velocity != "spline":
            twist, body = self.samples["velocity",], np.array(entry.body)
            heading = TimedSamples(tracked.time, tracked.numbers[:, 2:] - body[2]).whole
            there = interpolated(heading.time, heading.numbers, twist.time, heading.bridged(max_gap)).rows[:, 0]
            in_world = world_velocity(twist.numbers, there, body, self.is_velocity_in_world)
            velocity = interpolated(twist.time, in_world, time, twist.bridged(max_gap)).rows
        else:
            assert entry.noise is not None
            noise = (entry.noise.position, entry.noise.position, entry.noise.heading)
            gap = tracked.whole.bridged(max_gap)
            velocity = spline_velocity(tracked.time, tracked.numbers, noise, time, gap)
            velocity[np.isnan(pose).any(axis=1)] = np.nan
        self.steps.add("pose", f"velocity by {entry.velocity}", masked=int(np.isnan(velocity).any(axis=1).sum()))
        return velocity

    def _contact(self, name: str, arm: ArmEntry, time: Array) -> Array:
        if isinstance(arm.contact, list):
            return np.tile(np.array(arm.contact), (len(time), 1))
        samples = self.samples["arms", name, "contact"]
        if samples.is_static:
            self.steps.add(name, "contact point from a static transform", sent=len(samples.time))
            return np.tile(samples.numbers[-1, :3], (len(time), 1))
        rows = held(samples.time, samples.numbers[:, :3], time, samples.bridged(self.map_file.map.max_gap))
        self.steps.add(name, "contact points from TF, held", rows=rows.taken, masked=rows.masked)
        return rows.rows
