"""`cartgrasp simulate --cart cart.yaml`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from planning import CartLimit, Caution, Choosing, RegraspTimes, Skid, TipOver
from planning.contact_sources.strategies import FIXED
from planning.limits.robust import RobustLimits
from planning.problem.problem_limits import limits_for

from ..arms import Arm
from ..cart_file import load_cart
from ..constraints import RollingConstraints
from ..errors import UsageError
from ..information import WrenchNoise
from ..model import CartModel
from ..reference_file import StoredReference, read_reference
from ..simulation.sensors import SensorNoise
from ..studies.named_paths import named_path
from ..studies.run_figures import RunFigures
from ..studies.scenario import FIRST_GUESS, LEARNING, MUJOCO_PLANT, Scenario, filter_noise
from ..studies.shopping_cart import FIRM_GAINS
from .artefacts import save_run
from .output import make_folder, print_json, progress, say
from .run_tables import print_run

HAND_PLACE_SPACING = 0.1
"""m along the handle, between the places where a hand may hold."""
MAX_ARM_FORCE, MAX_ARM_MOMENT, MAX_FORCE_NOISE = 150.0, 40.0, 1e4


@dataclass(frozen=True)
class Choice:
    """The options of the command; the last five keep the cart on its wheels and its path."""

    cart: Path
    guess: Path | None
    path: str
    reference: Path | None
    plant: str
    arms: int
    speed: float
    force_noise: float
    learn: bool
    seed: int
    contacts: str = FIXED
    skid: float | None = None
    tip_over: float | None = None
    confidence: float | None = None
    caution: bool = False
    disturbances: bool = False


def run(choice: Choice, out: Path, as_json: bool) -> int:
    scenario = build_scenario(choice)
    make_folder(out)
    with progress(f"simulating {scenario.truth.name}") as tell:
        record = scenario.run(tell)
    with progress("drawing") as tell:
        save_run(record, out, scenario.truth.name)
    figures = RunFigures.of(record)
    if as_json:
        told = [{"time": time, "words": words} for time, words in record.words]
        print_json({"run": figures.as_dict(), "hands": told, "out": str(out), "seed": choice.seed})
    else:
        print_run(figures, f"{scenario.truth.name}: {choice.reference or choice.path}, plant {choice.plant}")
    say(f"open {out / 'player.html'} to watch; the log is {out / 'run.csv'}")
    return 0


def build_scenario(choice: Choice) -> Scenario:
    """The run that the options describe."""
    truth = load_cart(choice.cart)
    guess = truth if choice.guess is None else load_cart(choice.guess)
    if guess.constraints != truth.constraints:
        raise UsageError("--guess: its constraints differ from those of --cart; the structure must be the same")
    if not 0 <= choice.force_noise <= MAX_FORCE_NOISE:
        raise UsageError(f"--force-noise {choice.force_noise:g}: give 0 to {MAX_FORCE_NOISE:g} N")
    way, arms = _way(choice, truth.constraints), _arms(choice.arms)
    moment = choice.force_noise / 20
    sensors = SensorNoise(force=choice.force_noise, moment=moment)
    slip = 0.0005 if choice.plant == MUJOCO_PLANT else 0.0002
    return Scenario(
        truth=truth,
        guess=guess,
        arms=arms,
        contacts=choice.contacts,
        choosing=Choosing(noise=WrenchNoise(choice.force_noise, moment), min_hand_distance=HAND_PLACE_SPACING / 2),
        regrasp=RegraspTimes(),
        cart_limits=_cart_limits(choice, guess, arms),
        confidence=choice.confidence,
        caution=Caution() if choice.caution else None,
        disturbances=choice.disturbances,
        stretches=way.stretches,
        start_pose=way.start,
        sensors=sensors,
        noise=filter_noise(sensors, disturbance=0.1, slip=slip),
        estimation=LEARNING if choice.learn else FIRST_GUESS,
        plant=choice.plant,
        gains=FIRM_GAINS,
        seed=choice.seed,
    )


def _cart_limits(choice: Choice, guess: CartModel, arms: Sequence[Arm]) -> tuple[CartLimit, ...]:
    asked = (("skid", Skid, choice.skid), ("tip-over", TipOver, choice.tip_over))
    limits = {key: partial(limit, value) for key, limit, value in asked if value is not None}
    if choice.confidence is not None and not limits:
        raise UsageError("--confidence: is of limits of the cart; give --skid or --tip-over beside it")
    try:
        RobustLimits((), choice.confidence)
    except UsageError as error:
        raise UsageError(f"--confidence {choice.confidence:g}: {error}") from error
    return limits_for(limits, (guess, arms), lambda key, why: UsageError(f"--{key}: {why}"))


def _arms(count: int) -> tuple[Arm, ...]:
    sides = np.linspace(0.25, -0.25, count) if count > 1 else np.zeros(1)
    force, moment = (MAX_ARM_FORCE,) * 3, (MAX_ARM_MOMENT,) * 3
    places = [[(-0.25, float(y) + off, 1.0) for off in (0.0, HAND_PLACE_SPACING, -HAND_PLACE_SPACING)] for y in sides]
    return tuple(Arm(f"arm{i + 1}", points, force_limit=force, moment_limit=moment) for i, points in enumerate(places))


def _way(choice: Choice, constraints: RollingConstraints) -> StoredReference:
    if choice.reference is None:
        try:
            return StoredReference(named_path(choice.path, choice.speed, constraints))
        except UsageError as error:
            raise UsageError(f"--{error}") from error
    way = read_reference(choice.reference)
    if constraints.no_rotation and any(stretch.yaw_acceleration for stretch in way.stretches):
        raise UsageError(f"{choice.reference}: turns, and a cart on a rail can't; take the yaw accelerations out")
    return way
