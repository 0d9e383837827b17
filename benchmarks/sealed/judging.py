"""One report beside its truth."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from .lawful import AS_WELL, FOLLOWS, with_law

PARAMETERS, DRAG = ("mass", "com_x", "com_y", "inertia"), ("linear", "angular")
CLOSE_DRAG = 0.25
"""A drag that the cart file lacks counts as found when it is refitted this near, as a share."""
CLOSE_PERIOD = 0.02
MOST = 0.5
LAW = "learned_force"
CLOSES = 0.8
"""Of the squared held-out gap above the noise, what a law closes at least."""


@dataclass(frozen=True)
class Estimate:
    """What was said of a number, beside what it is. `roughly`: the two differ somewhat in meaning."""

    name: str
    truth: float
    value: float
    std: float
    roughly: bool = False

    @property
    def z(self) -> float:
        return (self.value - self.truth) / self.std if self.std > 0 else np.nan

    @property
    def error(self) -> float:
        return self.value - self.truth


@dataclass(frozen=True, eq=False)
class Judgement:
    """A truth file's and a report's contents (None: there is no report), how long that took, the gap (m) of the true
    structure, and of a log in which what is hidden is local times and poses (n, 4)."""

    truth: Mapping[str, Any]
    report: Mapping[str, Any] | None
    seconds: float | None = None
    refit: float | None = None
    course: np.ndarray | None = None

    @property
    def case(self) -> str:
        return str(self.truth["case"])

    @property
    def share(self) -> float:
        """Of the usual sizes of this case."""
        return float(self.truth.get("share", 1.0))

    @property
    def z(self) -> float | None:
        """How plainly wrenches show what is hidden; None of what the motion shows, or where nobody worked it out."""
        strength = self.truth.get("strength", {})
        return None if strength.get("lateral_speed") else strength.get("z")

    @property
    def kind(self) -> str:
        """nothing, single, outside or pair."""
        effects = self.truth["effects"]
        if not effects:
            return "nothing"
        if any(e["outside"] for e in effects):
            return "outside"
        return "single" if len(effects) == 1 else "pair"

    @property
    def roughness(self) -> tuple[str, ...]:
        """What makes the log rough on purpose."""
        return tuple(one["name"] for one in self.truth.get("roughness", ()))

    @property
    def is_proof(self) -> bool:
        """Kept for proof: only totals are looked at."""
        return bool(self.truth.get("proof", False))

    @property
    def arms(self) -> tuple[str, ...]:
        return tuple(self.truth.get("settings", {}).get("arms", ("arm",)))

    @property
    def true_names(self) -> set[str]:
        return {e["name"] for e in self.truth["effects"] if not e["outside"]}

    @property
    def tolerated(self) -> set[str]:
        """Names that say what is rough, where no effect is meant."""
        return {name for one in self.truth.get("roughness", ()) for name in one["tolerates"]} - self.true_names

    @property
    def wrong_names(self) -> tuple[str, ...]:
        return tuple(name for name in self.names if name not in self._right)

    @cached_property
    def sets(self) -> tuple[frozenset[str], ...]:
        """Of each reported effect: its name and those that it may be confused with."""
        found = []
        for effect in self._effects:
            names = [effect["name"], *effect.get("confusable_with", [])]
            found.append(frozenset(bare(name) for name in names))
        if not found and self.drag_refitted:
            return (frozenset({"viscous_drag"}),)
        return tuple(found)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Reported names in the order of addition."""
        found = tuple(dict.fromkeys(bare(effect["name"]) for effect in self._effects))
        return ("viscous_drag",) if not found and self.drag_refitted else found

    @property
    def drag_refitted(self) -> bool:
        """Whether a drag that is not in the cart file came with the refit."""
        if self.true_names != {"viscous_drag"}:
            return False
        found = [e for e in self.mismatches if e.name == "linear"]
        return any(abs(e.error) < CLOSE_DRAG * e.truth for e in found)

    @property
    def exact(self) -> bool:
        return set(self.names) - self.tolerated == self.true_names

    @property
    def right(self) -> bool:
        """What this log asks for: nothing, the names, or that something without a name is left."""
        if self.kind == "nothing":
            return self.called_nothing
        return self.law_right if self.kind == "outside" else self.exact

    @property
    def within(self) -> bool:
        """Each true effect is in the set of an entry of its own."""
        return matched(sorted(self.true_names), list(self.sets))

    @property
    def called_nothing(self) -> bool:
        if self.report is None or set(self.names) - self.tolerated:
            return False
        return bool(self.names) or self.report["verdict"] == "no_discrepancy"

    @property
    def partly(self) -> bool:
        """Something is left unexplained, whatever was named beside it."""
        return self.report is not None and self.report["verdict"] in ("unexplained", "partly_explained")

    @property
    def laws(self) -> list[Mapping[str, Any]]:
        """That were found."""
        return [effect["law"] for effect in self._effects if effect["name"] == LAW]

    @property
    def period_right(self) -> bool | None:
        """None where truth has no period."""
        wanted = next((e["parameters"]["period"] for e in self.truth["effects"] if "period" in e["parameters"]), None)
        if wanted is None or self.report is None:
            return None
        periods = [law["period"] for law in self.laws if law["period"] and law["period"]["unit"] == self._follows[1]]
        return any(abs(one["value"] - wanted) < CLOSE_PERIOD * wanted for one in periods)

    @property
    def variable_right(self) -> bool:
        """Whether a law is of what the force follows, or a name says as much."""
        return bool(set(self.names) & self._as_well) or any(law["of"] == self._follows[0] for law in self.laws)

    @property
    def closed(self) -> float | None:
        """Of the squared held-out gap above the noise; None where most of it is noise."""
        gap = (self.report or {}).get("gap")
        if not gap or not self.stands_out:
            return None
        noise = gap["noise_floor"] ** 2
        return float((gap["refitted"] ** 2 - gap["after"] ** 2) / max(gap["refitted"] ** 2 - noise, 1e-12))

    @property
    def law_right(self) -> bool:
        """The variable, its period, and most of the gap, with what is beside."""
        closed = self.closed
        return (
            self.variable_right
            and self.period_right is not False
            and (closed is None or closed >= CLOSES)
            and self.true_names <= set(self.names)
            and not self.wrong_names
        )

    @property
    def probabilities(self) -> list[tuple[float, bool]]:
        """Of each name at its first mention: what is said, and whether it is true."""
        first = {bare(effect["name"]): effect for effect in reversed(self._effects)}
        return [(e["probability"], name in self._right) for name, e in first.items() if "probability" in e]

    @property
    def gap(self) -> tuple[float, float] | None:
        """Held-out gap after over that of the refitted nominal model, and over the noise floor."""
        gap = (self.report or {}).get("gap")
        if not gap or not gap["refitted"] or not gap["noise_floor"]:
            return None
        return gap["after"] / gap["refitted"], gap["after"] / gap["noise_floor"]

    @property
    def beside_truth(self) -> float | None:
        """Held-out gap after over that of a refit of the true structure."""
        gap = (self.report or {}).get("gap")
        return gap["after"] / self.refit if gap and self.refit else None

    @property
    def stands_out(self) -> bool:
        """Whether most of the refitted nominal model's squared gap is more than noise."""
        return self.gap is not None and self.gap[1] > MOST**-0.5 * self.gap[0]

    @cached_property
    def estimates(self) -> tuple[Estimate, ...]:
        """Of the parameters of effects that are there and were named."""
        found = []
        for true in self.truth["effects"]:
            for effect in [e for e in self._effects if bare(e["name"]) == true["name"] and concerns(true, e)][:1]:
                found += list(compared(self._as_told(true), effect))
        return tuple(found)

    @cached_property
    def mismatches(self) -> tuple[Estimate, ...]:
        """Of mass, CoM, inertia and drag; of a cart that coasts all but the mass, and per mass."""
        entries, cart, found = (self.report or {}).get("parameter_mismatch", {}), self.truth["cart"], []
        for name in PARAMETERS:
            if name in entries and (self.arms or name != "mass"):
                truth = cart[name] * (self._given if name == "inertia" else 1.0)
                found.append(Estimate(name, truth, entries[name]["refitted"], entries[name]["std"] or np.nan))
        drag = {name: entries.get(f"viscous_drag.{name}") for name in DRAG}
        drag["linear"] = drag["linear"] or entries.get("viscous_drag")
        for name, entry in drag.items():
            if entry and name in cart["viscous_drag"]:
                truth = cart["viscous_drag"][name] * self._given
                found.append(Estimate(name, truth, entry["refitted"], entry["std"] or np.nan))
        return tuple(found)

    @property
    def _given(self) -> float:
        """Times the true mass that a report on a cart that coasts has to take as given."""
        return 1.0 if self.arms else self.truth["cart_file"]["mass"] / self.truth["cart"]["mass"]

    def _as_told(self, true: Mapping[str, Any]) -> Mapping[str, Any]:
        """A true effect, as it is told by who takes the cart file's mass for the mass."""
        for law in self.truth["effects"] if not self.laws else ():
            true = with_law(true, law, self.truth["cart"]["mass"])
        given = {name: self.truth["cart_file"]["mass"] * value for name, value in true.get("per_mass", {}).items()}
        groups = {key: {n: given.get(n, v) for n, v in true[key].items()} for key in ("parameters", "roughly")}
        return {**true, **groups}

    @property
    def _outside(self) -> list[str]:
        return [e["name"] for e in self.truth["effects"] if e["outside"]]

    @property
    def _follows(self) -> tuple[str, str]:
        return FOLLOWS[self._outside[0]]

    @property
    def _right(self) -> set[str]:
        """Names that are not wrong: a law is none where a force has no name."""
        return self.true_names | self.tolerated | self._as_well | ({LAW} if self.kind == "outside" else set())

    @property
    def _as_well(self) -> set[str]:
        """Names that say as much as a law of what has none."""
        return set[str]().union(*(AS_WELL.get(name, set()) for name in self._outside))

    @property
    def _effects(self) -> list[Mapping[str, Any]]:
        return list((self.report or {}).get("effects", []))


def bare(name: str, last: bool = False) -> str:
    """`force_bias.left` is force_bias (or `left`, the last part)."""
    return name.split(".")[-1 if last else 0]


def matched(wanted: list[str], sets: list[frozenset[str]]) -> bool:
    if not wanted:
        return True
    return any(wanted[0] in names and matched(wanted[1:], sets[:i] + sets[i + 1 :]) for i, names in enumerate(sets))


def concerns(true: Mapping[str, Any], effect: Mapping[str, Any]) -> bool:
    """Of the arm that is meant, where arms are told apart."""
    label = str(effect.get("label") or (effect["name"].split(".")[1] if "." in effect["name"] else ""))
    return not (true["arm"] and label) or label == true["arm"]


def compared(true: Mapping[str, Any], effect: Mapping[str, Any]) -> Iterator[Estimate]:
    """Parameters of one true and one reported effect."""
    arm = true["arm"]
    for roughly, group in ((False, "parameters"), (True, "roughly")):
        for name, value in true[group].items():
            keys = [k for k in effect["parameters"] if bare(k, last=True) == name]
            own = [k for k in keys if arm and arm in k.split(".")] or keys
            for key in own[:1]:
                said = effect["parameters"][key]
                std = said.get("std")
                yield Estimate(f"{true['name']}.{name}", value, said["value"], np.nan if std is None else std, roughly)
