"""`study.yaml` of `cartgrasp campaign`: strict to read, exact about places."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from ruamel.yaml.comments import CommentedMap

from estimation import FilterNoise, Prior
from planning import CartLimit, Caution, Choosing, RegraspTimes
from planning.contact_sources.strategies import LEAST_EFFORT, PERIODIC
from planning.problem.problem_arms import arms_of
from planning.problem.problem_limits import cart_limits_of
from planning.references import PathReference, Stretch
from planning.tracking import Gains

from ...cart_file import cart_from_document, load_cart
from ...errors import FileError, UsageError
from ...information import WrenchNoise
from ...model import CartModel
from ...simulation.sensors import SensorNoise
from ...yaml_file import did_you_mean, file_error, parse_yaml, plain, read_yaml, validate
from ..named_paths import named_path
from ..scenario import Scenario, total_duration
from ..shopping_cart import FIRM_GAINS
from .closed_loop import ClosedLoopStudy
from .drawing import NORMAL, UNIFORM, Drawn, parameter_names
from .logs import LogStudy
from .schema import (
    ESTIMATIONS,
    ChoosingEntry,
    ClosedLoopEntry,
    DrawnEntry,
    LogsEntry,
    RegraspEntry,
    StudyEntry,
)

Refuse = Callable[[list[str | int], str], FileError]
SHARED_NOISE_KEYS = ("position", "heading", "linear_velocity", "yaw_rate", "force", "moment")
"""What filter and sensors both have."""
CONTACT_KEYS = ("contacts", "choosing", "regrasp")
"""Keys that hashes of studies without `contacts` don't know."""
GUARD_KEYS = ("cart_limits", "confidence", "caution", "disturbances")
"""Keys that hashes of studies without them don't know."""
MAX_CONTROL_STEPS, MAX_PLANT_SUBSTEPS = 1_000_000, 1_000
"""Periods of control in a run, and steps of the plant in one of them."""


def read_study(path: str | os.PathLike[str]) -> ClosedLoopStudy | LogStudy:
    """A mistake is refused as `file:line:column: key: why`."""
    document, name = read_yaml(path), str(path)
    entry = validate(StudyEntry, document, name)

    def refuse(location: list[str | int], why: str) -> FileError:
        return file_error(document, name, location, why)

    if (entry.closed_loop is None) == (entry.logs is None):
        raise refuse([], "a study has either `closed_loop` (runs) or `logs`; write one of them")
    carts = _Carts(document, Path(path), refuse)
    if entry.closed_loop is not None:
        return _closed_loop(entry, entry.closed_loop, carts)
    assert entry.logs is not None
    if entry.drawn:
        raise refuse(["drawn"], "is for runs; logs have nothing to draw")
    return _logs(entry.name, entry.logs, carts)


class _Carts:
    """The carts of a study: of files, whose paths are relative to it, or mappings in it."""

    def __init__(self, document: CommentedMap, path: Path, refuse: Refuse) -> None:
        self.document, self.path, self.refuse = document, path, refuse

    def at(self, section: str, key: str) -> CartModel:
        found = self.document[section][key]
        if isinstance(found, str):
            return load_cart(self.path.parent / str(found))
        if isinstance(found, CommentedMap):
            return cart_from_document(found, str(self.path), [section, key])
        raise self.refuse([section, key], f"{found!r} is neither the path of a cart file nor a mapping")


def _told(cart: CartModel) -> Any:
    return plain(parse_yaml(cart.source, cart.name))


def _told_arm(told: dict[str, Any], folder: Path) -> dict[str, Any]:
    """With what a URDF's file says in the place of its name; hashes of studies without one don't know the key."""
    urdf = told.pop("urdf")
    if urdf is not None:
        told["urdf"] = {**urdf, "file": (folder / urdf["file"]).read_text(encoding="utf-8")}
    return told


def _closed_loop(entry: StudyEntry, loop: ClosedLoopEntry, carts: _Carts) -> ClosedLoopStudy:
    truth = carts.at("closed_loop", "cart")
    guess = truth if loop.guess is None else carts.at("closed_loop", "guess")
    if guess.constraints != truth.constraints:
        raise carts.refuse(["closed_loop", "guess"], "its constraints differ from the cart's; they must be the same")
    scenario = _scenario(loop, truth, guess, carts)
    unknown = [*(CONTACT_KEYS if loop.contacts is None else ()), *(key for key in GUARD_KEYS if not getattr(loop, key))]
    told = loop.model_dump(mode="json", exclude={"cart", "guess", *unknown})
    told["arms"] = [_told_arm(arm, carts.path.parent) for arm in told["arms"]]
    drawn = {name: one.model_dump(exclude_none=True) for name, one in entry.drawn.items()}
    return ClosedLoopStudy(
        name=entry.name,
        scenario=scenario,
        drawn=tuple(_drawn(name, one, truth, carts.refuse) for name, one in entry.drawn.items()),
        seed=entry.seed,
        runs=entry.runs,
        told={"closed_loop": {**told, "cart": _told(truth), "guess": _told(guess)}, "drawn": drawn},
    )


def _scenario(loop: ClosedLoopEntry, truth: CartModel, guess: CartModel, carts: _Carts) -> Scenario:
    refuse, folder = carts.refuse, carts.path.parent
    sensors = SensorNoise(**loop.sensors.model_dump())
    told = {name: getattr(sensors, name) for name in SHARED_NOISE_KEYS} | loop.filter.model_dump(exclude_none=True)
    noise = FilterNoise(**told)
    known, stretches = _known(loop, guess, refuse), _stretches(loop, guess, refuse)
    _check_steps(loop, total_duration(stretches), refuse)
    arms = arms_of(loop.arms, ["closed_loop", "arms"], folder, refuse)
    scenario = Scenario(
        truth=truth,
        guess=guess,
        arms=tuple(arms),
        stretches=stretches,
        sensors=sensors,
        noise=noise,
        known=known,
        estimation=ESTIMATIONS[loop.estimation],
        plant=loop.plant,
        gains=Gains(**vars(FIRM_GAINS) | loop.gains.model_dump(exclude_none=True)),
        period=loop.period,
        plant_timestep=loop.plant_timestep,
        duration=loop.duration,
    )
    return _with_contacts(_guarded(scenario, loop, refuse), loop, refuse)


def _guarded(scenario: Scenario, loop: ClosedLoopEntry, refuse: Refuse) -> Scenario:
    """With limits of the cart, caution, and an answer to disturbances."""
    limits: tuple[CartLimit, ...] = ()
    if loop.cart_limits is not None:
        where: list[str | int] = ["closed_loop", "cart_limits"]
        limits = cart_limits_of(loop.cart_limits, (scenario.guess, scenario.arms), where, refuse)
    if loop.confidence is not None and not limits:
        raise refuse(["closed_loop", "confidence"], "is of `cart_limits`, which are missing; write `tip_over: {}`, say")
    key, guarded = "disturbances", replace(scenario, cart_limits=limits, confidence=loop.confidence)
    try:
        guarded, key = replace(guarded, disturbances=loop.disturbances), "caution"
        return guarded if loop.caution is None else replace(guarded, caution=Caution(**loop.caution.model_dump()))
    except UsageError as error:
        raise refuse(["closed_loop", key], str(error).removeprefix("disturbances: ")) from error


def _with_contacts(scenario: Scenario, loop: ClosedLoopEntry, refuse: Refuse) -> Scenario:
    """By `switching`, at once, as in the paper; or by `contacts`, with regrasps that take time."""
    if loop.contacts is None:
        for key in ("choosing", "regrasp"):
            if getattr(loop, key) is not None:
                raise refuse(["closed_loop", key], "is for `contacts`, which is missing; write `contacts: teach`, say")
        if loop.switching is None:
            return scenario
        way = LEAST_EFFORT if loop.switching.least_effort else PERIODIC
        return replace(scenario, contacts=way, choosing=Choosing(every=loop.switching.every))
    if loop.switching is not None:
        raise refuse(["closed_loop", "switching"], "stands beside `contacts`; write one of them")
    sensed = WrenchNoise(scenario.noise.force, scenario.noise.moment, 1.0 / loop.period)
    times = RegraspTimes(**(loop.regrasp or RegraspEntry()).model_dump())
    key = "choosing"
    try:
        choosing = Choosing(**(loop.choosing or ChoosingEntry()).model_dump(), noise=sensed)
        found, key = replace(scenario, contacts=loop.contacts, choosing=choosing, regrasp=times), "contacts"
        found.controller()
    except UsageError as error:
        raise refuse(["closed_loop", key], str(error)) from error
    return found


def _check_steps(loop: ClosedLoopEntry, path: float, refuse: Refuse) -> None:
    """Whether a run can be begun, and will end; `path` is its reference's duration in s."""
    lasting = path if loop.duration is None else loop.duration
    steps = lasting / loop.period
    if steps >= 2:
        steps = max(steps, path / loop.period)
    if not 2 <= steps <= MAX_CONTROL_STEPS:
        keys = [key for key in ("period", "duration", "path") if key in loop.model_fields_set]
        why = f"a run of {steps:.3g} periods of control; 2 to {MAX_CONTROL_STEPS:,} can be"
        raise refuse(["closed_loop", *keys[:1]], why)
    if loop.plant_timestep is not None and loop.period / loop.plant_timestep > MAX_PLANT_SUBSTEPS:
        why = f"is below a {MAX_PLANT_SUBSTEPS:,}th of the control period of {loop.period:g} s; give a longer one"
        raise refuse(["closed_loop", "plant_timestep"], why)


def _known(loop: ClosedLoopEntry, guess: CartModel, refuse: Refuse) -> frozenset[str]:
    known = frozenset(loop.known)
    try:
        Prior(known=known).free(guess)
    except UsageError as error:
        raise refuse(["closed_loop", "known"], str(error)) from error
    return known


def _stretches(loop: ClosedLoopEntry, guess: CartModel, refuse: Refuse) -> tuple[Stretch, ...]:
    try:
        if isinstance(loop.path, str):
            return named_path(loop.path, loop.speed, guess.constraints)
        stretches = tuple(Stretch(one.duration, one.acceleration, one.yaw_acceleration) for one in loop.path)
        PathReference(stretches, guess.rolling)
        return stretches
    except UsageError as error:
        key = "speed" if str(error).startswith("speed") else "path"
        raise refuse(["closed_loop", key], str(error)) from error


def _drawn(name: str, entry: DrawnEntry, truth: CartModel, refuse: Refuse) -> Drawn:
    known = parameter_names(truth)
    if name not in known:
        raise refuse(["drawn", name], f"is no parameter of the cart{did_you_mean(name, known)}")
    laws = {law: numbers for law, numbers in ((UNIFORM, entry.uniform), (NORMAL, entry.normal)) if numbers is not None}
    if len(laws) != 1:
        raise refuse(["drawn", name], "needs one law: `uniform: [low, high]` or `normal: [mean, deviation]`")
    (law, (first, second)) = next(iter(laws.items()))
    try:
        return Drawn(name, law, (first, second))
    except UsageError as error:
        raise refuse(["drawn", name, law], str(error)) from error


def _logs(name: str, entry: LogsEntry, carts: _Carts) -> LogStudy:
    paths: list[Path] = []
    for i, pattern in enumerate(entry.files):
        try:
            found = _files(carts.path.parent, pattern)
        except ValueError as error:
            raise carts.refuse(["logs", "files", i], f"{pattern}: {error}") from error
        if not found:
            raise carts.refuse(["logs", "files", i], f"{pattern}: there is no such file")
        paths += [path for path in found if path not in paths]
    cart = carts.at("logs", "cart")
    told = {"do": entry.do, "method": entry.method if entry.do == "estimate" else None, "cart": _told(cart)}
    topics = None if entry.topics is None else carts.path.parent / entry.topics
    return LogStudy(name, tuple(paths), cart, entry.do, entry.method, topics, told)


def _files(folder: Path, pattern: str) -> list[Path]:
    if not any(sign in pattern for sign in "*?["):
        return [folder / pattern] if (folder / pattern).exists() else []
    whole = Path(pattern)
    root = Path(whole.anchor) if whole.is_absolute() else folder
    return sorted(root.glob(str(whole.relative_to(whole.anchor) if whole.is_absolute() else whole)))
