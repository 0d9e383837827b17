"""`study.yaml` of `cartgrasp campaign`: strict to read, exact about places."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from ruamel.yaml.comments import CommentedMap

from estimation import FilterNoise, Prior
from planning import Caution, Choosing, RegraspTimes
from planning.contact_sources.strategies import LEAST_EFFORT, PERIODIC
from planning.planner import MAX_PERIOD
from planning.problem.problem_arms import arms_of
from planning.problem.problem_limits import cart_limits_of
from planning.problem.refusing import refusing
from planning.references import PathReference, Stretch
from planning.tracking import Gains

from ...arms import Arm
from ...cart_file import cart_from_document, load_cart
from ...checks import positive
from ...errors import FileError, UsageError
from ...information import WrenchNoise
from ...model import CartModel
from ...simulation.sensors import SensorNoise
from ...yaml_file import did_you_mean, file_error, parse_yaml, plain, read_yaml, validate
from ..named_paths import named_path
from ..scenario import Scenario, filter_noise, total_duration
from ..shopping_cart import FIRM_GAINS
from .closed_loop import ClosedLoopStudy
from .drawing import Drawn, parameter_names
from .logs import LogStudy
from .schema import ESTIMATIONS, ChoosingEntry, ClosedLoopEntry, DrawnEntry, LogsEntry, RegraspEntry, StudyEntry

MAX_CONTROL_STEPS, MAX_PLANT_SUBSTEPS = 1_000_000, 1_000
"""Periods of control in a run, and steps of the plant in one of them."""


def read_study(path: str | os.PathLike[str]) -> ClosedLoopStudy | LogStudy:
    """A mistake is refused as `file:line:column: key: why`."""
    file = _StudyFile(path)
    entry = file.entry
    if (entry.closed_loop is None) == (entry.logs is None):
        raise file.refuse([], "a study has either `closed_loop` (runs) or `logs`; write one of them")
    if entry.closed_loop is not None:
        return file.closed_loop(entry.closed_loop)
    assert entry.logs is not None
    if entry.drawn:
        raise file.refuse(["drawn"], "is for runs; logs have nothing to draw")
    return file.logs(entry.logs)


class _StudyFile:
    """Makes what stands in a file, whose paths are relative to it, and knows where its mistakes are."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.document, self.name, self.folder = read_yaml(path), str(path), Path(path).parent
        self.entry = validate(StudyEntry, self.document, self.name)

    def refuse(self, location: list[str | int], why: str) -> FileError:
        return file_error(self.document, self.name, location, why)

    def _cart(self, section: str, key: str) -> CartModel:
        found = self.document[section][key]
        if isinstance(found, str):
            return load_cart(self.folder / str(found))
        if isinstance(found, CommentedMap):
            return cart_from_document(found, self.name, [section, key])
        raise self.refuse([section, key], f"{found!r} is neither the path of a cart file nor a mapping")

    # --- runs -------------------------------------------------------------------------------------------------

    def closed_loop(self, loop: ClosedLoopEntry) -> ClosedLoopStudy:
        entry, truth = self.entry, self._cart("closed_loop", "cart")
        guess = truth if loop.guess is None else self._cart("closed_loop", "guess")
        if guess.constraints != truth.constraints:
            raise self.refuse(["closed_loop", "guess"], "its constraints differ from the cart's; they must be the same")
        scenario = self._scenario(loop, truth, guess)
        told = loop.model_dump(mode="json", exclude={"cart", "guess"}, exclude_none=True)
        for arm in told["arms"]:
            if "urdf" in arm:
                arm["urdf"]["file"] = (self.folder / arm["urdf"]["file"]).read_text(encoding="utf-8")
        drawn = {name: one.model_dump(exclude_none=True) for name, one in entry.drawn.items()}
        return ClosedLoopStudy(
            name=entry.name,
            scenario=scenario,
            drawn=tuple(self._drawn(name, one, truth) for name, one in entry.drawn.items()),
            seed=entry.seed,
            runs=entry.runs,
            told={"closed_loop": {**told, "cart": _told(truth), "guess": _told(guess)}, "drawn": drawn},
        )

    def _scenario(self, loop: ClosedLoopEntry, truth: CartModel, guess: CartModel) -> Scenario:
        sensors, known = SensorNoise(**loop.sensors.model_dump()), frozenset(loop.known)
        noise = filter_noise(sensors, **loop.filter.model_dump(exclude_none=True))
        with refusing(self.refuse, "closed_loop", "known"):
            Prior(known=known).free(guess)
        stretches = self._stretches(loop, guess)
        self._check_steps(loop, total_duration(stretches))
        arms = tuple(arms_of(loop.arms, ["closed_loop", "arms"], self.folder, self.refuse))
        parts = self._guards(loop, guess, arms) | self._contacts(loop, noise)
        with refusing(self.refuse, "closed_loop", "gains"):
            gains = Gains(**vars(FIRM_GAINS) | loop.gains.model_dump(exclude_none=True))
        try:
            scenario = Scenario(
                truth=truth,
                guess=guess,
                arms=arms,
                stretches=stretches,
                sensors=sensors,
                noise=noise,
                known=known,
                estimation=ESTIMATIONS[loop.estimation],
                plant=loop.plant,
                gains=gains,
                period=loop.period,
                plant_timestep=loop.plant_timestep,
                duration=loop.duration,
                disturbances=loop.disturbances,
                **parts,
            )
        except UsageError as error:
            why = str(error).removeprefix("disturbances: ")
            raise self.refuse(["closed_loop", "disturbances"], why) from error
        if loop.contacts is not None:
            with refusing(self.refuse, "closed_loop", "contacts"):
                scenario.controller()
        return scenario

    def _guards(self, loop: ClosedLoopEntry, guess: CartModel, arms: tuple[Arm, ...]) -> dict[str, Any]:
        """Limits of the cart, and caution."""
        found: dict[str, Any] = {"confidence": loop.confidence}
        if loop.cart_limits is not None:
            where: list[str | int] = ["closed_loop", "cart_limits"]
            found["cart_limits"] = cart_limits_of(loop.cart_limits, (guess, arms), where, self.refuse)
        if loop.confidence is not None and not found.get("cart_limits"):
            why = "is of `cart_limits`, which are missing; write `tip_over: {}`, say"
            raise self.refuse(["closed_loop", "confidence"], why)
        if loop.caution is not None:
            with refusing(self.refuse, "closed_loop", "caution"):
                found["caution"] = Caution(**loop.caution.model_dump())
        return found

    def _contacts(self, loop: ClosedLoopEntry, noise: FilterNoise) -> dict[str, Any]:
        """By `switching`, at once, as in the paper; or by `contacts`, with regrasps that take time."""
        if loop.contacts is None:
            for key in ("choosing", "regrasp"):
                if getattr(loop, key) is not None:
                    why = "is for `contacts`, which is missing; write `contacts: teach`, say"
                    raise self.refuse(["closed_loop", key], why)
            if loop.switching is None:
                return {}
            way = LEAST_EFFORT if loop.switching.least_effort else PERIODIC
            with refusing(self.refuse, "closed_loop", "switching", "every"):
                return {"contacts": way, "choosing": Choosing(every=loop.switching.every)}
        if loop.switching is not None:
            raise self.refuse(["closed_loop", "switching"], "stands beside `contacts`; write one of them")
        sensed = WrenchNoise(noise.force, noise.moment, 1.0 / loop.period)
        times = RegraspTimes(**(loop.regrasp or RegraspEntry()).model_dump())
        with refusing(self.refuse, "closed_loop", "choosing"):
            choosing = Choosing(**(loop.choosing or ChoosingEntry()).model_dump(), noise=sensed)
        return {"contacts": loop.contacts, "choosing": choosing, "regrasp": times}

    def _check_steps(self, loop: ClosedLoopEntry, path: float) -> None:
        """Whether a run can be begun, and will end; `path` is its reference's duration in s."""
        lasting = path if loop.duration is None else loop.duration
        steps = lasting / loop.period
        if steps >= 2:
            steps = max(steps, path / loop.period)
        if not 2 <= steps <= MAX_CONTROL_STEPS:
            keys = [key for key in ("period", "duration", "path") if key in loop.model_fields_set]
            why = f"a run of {steps:.3g} periods of control; 2 to {MAX_CONTROL_STEPS:,} can be"
            raise self.refuse(["closed_loop", *keys[:1]], why)
        with refusing(self.refuse, "closed_loop", "period"):
            positive("period", loop.period, MAX_PERIOD, "give s")
        if loop.plant_timestep is not None and loop.period / loop.plant_timestep > MAX_PLANT_SUBSTEPS:
            why = f"is below a {MAX_PLANT_SUBSTEPS:,}th of the control period of {loop.period:g} s; give a longer one"
            raise self.refuse(["closed_loop", "plant_timestep"], why)

    def _stretches(self, loop: ClosedLoopEntry, guess: CartModel) -> tuple[Stretch, ...]:
        try:
            if isinstance(loop.path, str):
                return named_path(loop.path, loop.speed, guess.constraints)
            stretches = tuple(Stretch(one.duration, one.acceleration, one.yaw_acceleration) for one in loop.path)
            PathReference(stretches, guess.rolling)
            return stretches
        except UsageError as error:
            key = "speed" if str(error).startswith("speed") else "path"
            raise self.refuse(["closed_loop", key], str(error)) from error

    def _drawn(self, name: str, entry: DrawnEntry, truth: CartModel) -> Drawn:
        known = parameter_names(truth)
        if name not in known:
            raise self.refuse(["drawn", name], f"is no parameter of the cart{did_you_mean(name, known)}")
        laws = entry.model_dump(exclude_none=True)
        if len(laws) != 1:
            why = "needs one law: `uniform: [low, high]` or `normal: [mean, deviation]`"
            raise self.refuse(["drawn", name], why)
        ((law, (first, second)),) = laws.items()
        with refusing(self.refuse, "drawn", name, law):
            return Drawn(name, law, (first, second))

    # --- logs -------------------------------------------------------------------------------------------------

    def logs(self, entry: LogsEntry) -> LogStudy:
        paths: list[Path] = []
        for i, pattern in enumerate(entry.files):
            try:
                found = _files(self.folder, pattern)
            except ValueError as error:
                raise self.refuse(["logs", "files", i], f"{pattern}: {error}") from error
            if not found:
                raise self.refuse(["logs", "files", i], f"{pattern}: there is no such file")
            paths += [path for path in found if path not in paths]
        cart = self._cart("logs", "cart")
        told = {"do": entry.do, "method": entry.method if entry.do == "estimate" else None, "cart": _told(cart)}
        topics = None if entry.topics is None else self.folder / entry.topics
        return LogStudy(self.entry.name, tuple(paths), cart, entry.do, entry.method, topics, told)


def _told(cart: CartModel) -> Any:
    return plain(parse_yaml(cart.source, cart.name))


def _files(folder: Path, pattern: str) -> list[Path]:
    if not any(sign in pattern for sign in "*?["):
        return [folder / pattern] if (folder / pattern).exists() else []
    whole = Path(pattern)
    return sorted((folder / whole.anchor).glob(str(whole.relative_to(whole.anchor))))
