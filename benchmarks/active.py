"""Whether the motion that a diagnosis proposes names a hidden effect sooner than motions at random.

    python -m benchmarks.active DIR [--seeds 0:3] [--effects all] [--speed 0.8] [--duration 10] [--workers 2]

Carts, effects and sensors are those of `benchmarks.sealed`, whose equations share no code with the package. The first
log is a slow straight push. Then what the diagnosis of all logs so far proposes is recorded, from the same place, until
one name is left and it is the right one. Beside that, within the same limits and as long: pieces of the same list in
random order (`shuffled`), and speeds that are drawn anew every one to three seconds (`random`). DIR gets a file of each
cart and limits, so a run goes on where it was stopped, and `active.md`.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from cartgrasp.cart_file import cart_from_text
from cartgrasp.logs import RunLog, read_log
from cartgrasp.model import CartModel
from cartgrasp.reference_file import StoredReference, Stretch
from cartgrasp.studies.parallel import run_all
from cartgrasp.writing import write_atomically
from estimation import Diagnosis, diagnose
from estimation.experiments.manoeuvres import ACCELERATION, REST_DURATION, YAW_ACCELERATION, Limits, pieces
from planning.references import PathReference

from .sealed.__main__ import seeds
from .sealed.carts import cart_file
from .sealed.cases import draw_case
from .sealed.effects import VOCABULARY
from .sealed.robots import followed, hanging
from .sealed.scenes import PERIOD, Scene, random_of
from .sealed.sensors import csv_text, noiseless, record

ONCE = ("payload_change", "floor_patch", "external_push")
"""What happens once, or somewhere: another run doesn't meet it again."""
EFFECTS = tuple(name for name in VOCABULARY if name not in ONCE)
FIRST = Stretch(0.5), Stretch(0.5, 0.5), Stretch(10.0), Stretch(0.5, -0.5), Stretch(0.5)
FIRST_SAYS = "straight on at 0.25 m/s for 10 s"
LIMITS = Limits(speed=0.8, duration=10.0)
MOST = 5
"""Logs after the first."""
WAYS = PROPOSED, SHUFFLED, RANDOM = "proposed", "shuffled", "random"
HOLDS = (1.0, 3.0)
"""Shortest and longest time (s) from one random speed to the next."""


@dataclass(frozen=True)
class Run:
    """Of one way to go on: the names that are left after each log, and whether these were the right one at last."""

    way: str
    left: tuple[tuple[str, ...], ...]
    said: tuple[str, ...]
    is_named: bool
    seconds: float

    @property
    def logs(self) -> int | None:
        """How many were recorded after the first, until the right name alone was left; None: more than were tried."""
        return len(self.left) - 1 if self.is_named else None


def recorded(scene: Scene, stretches: Sequence[Stretch], random: np.random.Generator) -> RunLog:
    """A log of the hidden cart along stretches, from the scene's first place."""
    path, drive = PathReference(tuple(stretches)), scene.drive
    instants = PERIOD * np.arange(round(path.duration / PERIOD) + 1)
    at = [path.at(float(t)) for t in instants]
    n, wanted = len(at), np.array([[*one.velocity, *one.acceleration] for one in at])
    same = {name: getattr(drive, name)[:n] for name in ("shares", "extras", "errors")}
    contacts = np.repeat(drive.contacts[:1], n, axis=0)
    scene = replace(scene, drive=drive._replace(time=instants, speeds=wanted, contacts=contacts, **same))
    states, rates, present, told = scene.run()
    exact = noiseless(scene.sensors, scene.drive, present, told) + hanging(scene.sensors, scene.drive, states, rates)
    header, table = record(scene.sensors, scene.drive, followed(scene.sensors, states), exact, random)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.csv"
        file.write_text(csv_text(header, table), encoding="utf-8")
        return read_log(file)


def names_left(found: Diagnosis) -> tuple[str, ...]:
    """That are told, and that these logs can't tell from them."""
    return tuple(sorted({name for one in found.effects for name in (one.name, *one.confusable_with)}))


def shuffled(random: np.random.Generator, cart: CartModel, limits: Limits = LIMITS) -> StoredReference:
    """Pieces of the list in random order, as long as a proposal."""
    chosen, left, known = list[Stretch](), limits.duration, pieces(limits, cart.constraints)
    while fitting := [piece for piece in known if piece.duration <= left + PERIOD / 2]:
        piece = fitting[int(random.integers(len(fitting)))]
        chosen += piece.stretches
        left -= piece.duration
    return StoredReference(tuple(chosen), says="shuffled")


def at_random(random: np.random.Generator, cart: CartModel, limits: Limits = LIMITS) -> StoredReference:
    """Forward speeds and yaw rates drawn uniformly within the limits, one after the other, as long as a proposal; at
    rest at last."""
    most = np.array([limits.speed, 0.0 if cart.constraints.no_rotation else limits.yaw_rate])
    chosen, speeds, left = list[Stretch](), np.zeros(2), limits.duration
    while True:
        wanted = random.uniform(-most, most)
        ramp = _ramp(wanted - speeds)
        duration = max(round(float(random.uniform(*HOLDS)), 1), ramp + PERIOD)
        if duration + _ramp(wanted) + REST_DURATION > left:
            break
        chosen += [Stretch(ramp, *((wanted - speeds) / ramp)), Stretch(duration - ramp)]
        speeds, left = wanted, left - duration
    ramp = _ramp(speeds)
    return StoredReference((*chosen, Stretch(ramp, *(-speeds / ramp)), Stretch(REST_DURATION)), says="at random")


def _ramp(change: np.ndarray) -> float:
    """Time (s) that a change of forward speed and yaw rate takes."""
    return round(float(np.max(np.abs(change) / (ACCELERATION, YAW_ACCELERATION))) + PERIOD, 2)


CHANCE = {SHUFFLED: shuffled, RANDOM: at_random}


def run_cart(name: str, seed: int, limits: Limits = LIMITS) -> list[Run]:
    """Each way, until the right name alone is left, from the same first log on."""
    scene = draw_case(name, seed, "straight", "active ")
    cart = cart_from_text(cart_file(scene.world, scene.believed, name != "viscous_drag"))
    log = recorded(scene, FIRST, random_of(f"{name} first", seed, "active"))
    first = diagnose([log], cart, limits=limits)
    return [run_way(way, scene, (log, first), (name, seed), limits) for way in WAYS]


def run_way(way: str, scene: Scene, begun: tuple[RunLog, Diagnosis], of: tuple[str, int], limits: Limits) -> Run:
    begin, (log, found), (name, seed) = time.perf_counter(), begun, of
    noise, motion = (random_of(f"{name} {kind} {way}", seed, "active") for kind in ("noise", "motion"))
    logs, left, said = [log], [names_left(found)], [FIRST_SAYS]
    while left[-1] != (name,) and len(logs) <= MOST:
        reference = found.next_reference if way == PROPOSED else CHANCE[way](motion, found.cart, limits)
        if reference is None:
            said.append(found.next_experiment.why_none)
            break
        said.append(reference.says)
        logs.append(replace(recorded(scene, reference.stretches, noise), name=f"log {len(logs) + 1}"))
        found = diagnose(logs, found.nominal_cart, limits=limits)
        left.append(names_left(found))
    return Run(way, tuple(left), tuple(said), left[-1] == (name,), time.perf_counter() - begin)


def run_one(job: tuple[str, int], out: Path, limits: Limits = LIMITS) -> dict[str, Run]:
    name, seed = job
    file = out / f"{name}-{seed}-{limits.speed:g}-{limits.duration:g}.json"
    if not file.is_file():
        write_atomically(file, json.dumps([vars(run) for run in run_cart(name, seed, limits)], indent=1) + "\n")
    told = json.loads(file.read_text(encoding="utf-8"))
    runs = (one | {"left": tuple(map(tuple, one["left"])), "said": tuple(one["said"])} for one in told)
    return {one["way"]: Run(**one) for one in runs}


def table(found: dict[tuple[str, int], dict[str, Run]]) -> str:
    """Medians over seeds of each effect, and of all."""
    rows = ["| effect | names left after the first log | proposed | shuffled | at random |", "|" + " --- |" * 5]
    for name in dict.fromkeys(name for name, _ in found):
        runs = [ways for (effect, _), ways in found.items() if effect == name]
        first = ", ".join(str(len(ways[PROPOSED].left[0])) for ways in runs)
        rows.append(f"| `{name}` | {first} | {' | '.join(_cell([ways[way] for ways in runs]) for way in WAYS)} |")
    every = [_cell([ways[way] for ways in found.values()], median_alone=True) for way in WAYS]
    return "\n".join([*rows, f"| all {len(found)} | | {' | '.join(every)} |"]) + "\n"


def _cell(runs: Sequence[Run], median_alone: bool = False) -> str:
    median = float(np.median([np.inf if run.logs is None else run.logs for run in runs]))
    told = f"{median:g}" if np.isfinite(median) else f"more than {MOST}"
    done = sum(run.is_named for run in runs)
    each = ", ".join("-" if run.logs is None else str(run.logs) for run in runs)
    return f"{told}; {done} of {len(runs)} named" if median_alone else f"{told} ({each})"


def main() -> None:
    parser = argparse.ArgumentParser(
        "python -m benchmarks.active", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("out", type=Path, metavar="DIR")
    parser.add_argument("--seeds", type=seeds, default=range(3), metavar="FROM:TO")
    parser.add_argument("--effects", default=",".join(EFFECTS), metavar="NAME,…")
    parser.add_argument("--speed", type=float, default=LIMITS.speed, metavar="M/S", help="of motions after the first")
    parser.add_argument("--duration", type=float, default=LIMITS.duration, metavar="S", help="of each of them")
    parser.add_argument("--workers", type=int, default=1, metavar="N")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    jobs = [(name, seed) for name in options.effects.split(",") for seed in options.seeds]
    run = partial(run_one, out=options.out, limits=Limits(options.speed, options.duration))
    found = dict(zip(jobs, run_all(run, jobs, options.workers), strict=True))
    print(write_atomically(options.out / "active.md", table(found)).read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
