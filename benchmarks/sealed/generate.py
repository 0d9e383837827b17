"""Writes run logs and cart files under opaque names, and truth in another folder."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .carts import Believed, cart_file, guessed
from .cases import PROOF, draw_case
from .coasting import per_mass
from .robots import followed, hanging
from .rough import rough
from .scenes import Scene, random_of
from .sensors import csv_text, noiseless, record
from .strength import strength
from .weaker import weaker

SALT, ROUGH = "sealed", " rough"


@dataclass(frozen=True)
class Recipe:
    """All that a log is drawn from. `guess`: limits of how many times the true mass the cart file says, which the log
    knows nothing of; `is_proof`: from numbers that no other log is drawn from."""

    case: str
    seed: int
    motion: str
    share: float = 1.0
    is_rough: bool = False
    guess: tuple[float, float] | None = None
    is_proof: bool = False

    @property
    def stream(self) -> str:
        return PROOF if self.is_proof else ""

    @property
    def name(self) -> str:
        """It tells nothing."""
        kind = ("" if self.share == 1.0 else f" {self.share:g}") + (ROUGH if self.is_rough else "")
        kind += f" guess {self.guess[0]:g} {self.guess[1]:g}" if self.guess else ""
        text = f"{SALT} {self.stream}{self.case} {self.seed} {self.motion}{kind}"
        return hashlib.sha256(text.encode()).hexdigest()[:10]

    @property
    def document(self) -> dict[str, Any]:
        named = {"case": self.case, "seed": self.seed, "motion": self.motion, "share": self.share}
        return named | {"worse_sensors": self.is_rough, "guess": self.guess, "proof": self.is_proof}

    def random(self, what: str) -> np.random.Generator:
        return random_of(f"{self.stream}{self.case}{what}", self.seed, self.motion)

    def scene(self) -> Scene:
        scene = weaker(draw_case(self.case, self.seed, self.motion, self.stream), self.share)
        return rough(scene, self.random(ROUGH)) if self.is_rough else scene

    def told(self, scene: Scene) -> Believed:
        """What the cart file says."""
        if self.guess is None:
            return scene.believed
        return guessed(scene.world, scene.believed, self.guess, self.random(" guess"))


def generate(
    out: Path,
    cases: Sequence[str],
    seeds: Sequence[int],
    motion: str,
    shares: Sequence[float] = (1.0,),
    is_rough: bool = False,
    guess: tuple[float, float] | None = None,
    is_proof: bool = False,
) -> list[str]:
    """Names of the logs written, in no telling order; each case with `shares` of its effects' sizes; `is_rough`: by
    worse sensors."""
    recipes = (
        Recipe(case, seed, motion, share, is_rough, guess, is_proof)
        for case in cases
        for seed in seeds
        for share in shares
    )
    return sorted(write(out, recipe) for recipe in recipes)


def write(out: Path, recipe: Recipe) -> str:
    scene = recipe.scene()
    header, table, truth = simulate(scene, recipe.random(" sensors"))
    told = recipe.told(scene)
    folder, truths = out / "logs" / recipe.name, out / "truth"
    folder.mkdir(parents=True, exist_ok=True)
    truths.mkdir(parents=True, exist_ok=True)
    viscous = not any(t.name == "viscous_drag" for t in scene.truths)
    (folder / "run.csv").write_text(csv_text(header, table), encoding="utf-8")
    (folder / "cart.yaml").write_text(cart_file(scene.world, told, viscous), encoding="utf-8")
    document = recipe.document | {"kind": "rough" if scene.roughness else "plain", "cart_file": vars(told)} | truth
    (truths / f"{recipe.name}.json").write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    return recipe.name


def simulate(scene: Scene, random: np.random.Generator) -> tuple[list[str], np.ndarray, dict[str, Any]]:
    """Header and table of the log, and the truth."""
    states, rates, present, told = scene.run()
    recorded = noiseless(scene.sensors, scene.drive, present, told)
    recorded += hanging(scene.sensors, scene.drive, states, rates)
    header, table = record(scene.sensors, scene.drive, followed(scene.sensors, states), recorded, random)
    return header, table, truth_of(scene) | {"strength": strength(scene, states, rates, recorded)}


def truth_of(scene: Scene) -> dict[str, Any]:
    world, sensors, drive = scene.world, scene.sensors, scene.drive
    pushed = bool(scene.arms)
    cart = {
        "mass": world.mass,
        "com_x": world.com_x,
        "com_y": world.com_y,
        "inertia": world.inertia,
        "viscous_drag": {"linear": world.linear, "angular": world.angular},
    }
    return {
        "effects": [asdict(t) | ({} if pushed else {"per_mass": per_mass(t, world.mass)}) for t in scene.truths],
        "roughness": [asdict(one) for one in scene.roughness],
        "cart": cart,
        "settings": {
            "arms": list(scene.arms),
            "force_samples": "held" if drive.held else "sampled",
            "force_noise": sensors.force_noise,
            "moment_noise": sensors.moment_noise,
            "noise_correlation": sensors.colour,
            "pose_noise": sensors.pose_noise,
            "pose_correlation": sensors.pose_colour,
            "speed_noise": sensors.speed_noise,
            "speed_correlation": sensors.speed_colour,
            "lost_rows": sensors.lost,
            "poses_off": sensors.off,
            "jitter": bool(np.ptp(np.diff(drive.time)) > 5e-5),
            "speed_steps": not drive.speeds[:, 2:].any(),
        },
        "world": world._asdict(),
    }
