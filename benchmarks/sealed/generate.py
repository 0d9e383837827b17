"""Writes run logs and cart files under opaque names, and truth in another folder."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from .carts import cart_file
from .cases import draw_case
from .rough import rough
from .scenes import Scene, random_of
from .sensors import csv_text, noiseless, record
from .strength import strength
from .weaker import weaker

SALT, ROUGH = "sealed", " rough"


def generate(
    out: Path,
    cases: Sequence[str],
    seeds: Sequence[int],
    motion: str,
    shares: Sequence[float] = (1.0,),
    is_rough: bool = False,
) -> list[str]:
    """Names of the logs written, in no telling order; each case with `shares` of its effects' sizes; `is_rough`: by
    worse sensors."""
    return sorted(
        write(out, case, seed, motion, share, is_rough) for case in cases for seed in seeds for share in shares
    )


def write(out: Path, case: str, seed: int, motion: str, share: float = 1.0, is_rough: bool = False) -> str:
    kind = ("" if share == 1.0 else f" {share:g}") + (ROUGH if is_rough else "")
    name = hashlib.sha256(f"{SALT} {case} {seed} {motion}{kind}".encode()).hexdigest()[:10]
    scene = weaker(draw_case(case, seed, motion), share)
    if is_rough:
        scene = rough(scene, random_of(case + ROUGH, seed, motion))
    header, table, truth = simulate(scene, random_of(f"{case} sensors", seed, motion))
    folder, truths = out / "logs" / name, out / "truth"
    folder.mkdir(parents=True, exist_ok=True)
    truths.mkdir(parents=True, exist_ok=True)
    viscous = not any(t.name == "viscous_drag" for t in scene.truths)
    (folder / "run.csv").write_text(csv_text(header, table), encoding="utf-8")
    (folder / "cart.yaml").write_text(cart_file(scene.world, scene.believed, viscous), encoding="utf-8")
    document = {"case": case, "seed": seed, "motion": motion, "share": share, **truth}
    (truths / f"{name}.json").write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    return name


def simulate(scene: Scene, random: np.random.Generator) -> tuple[list[str], np.ndarray, dict[str, Any]]:
    """Header and table of the log, and the truth."""
    states, rates, present, told = scene.run()
    recorded = noiseless(scene.sensors, scene.drive, present, told)
    header, table = record(scene.sensors, scene.drive, states, recorded, random)
    return header, table, truth_of(scene) | {"strength": strength(scene, states, rates, recorded)}


def truth_of(scene: Scene) -> dict[str, Any]:
    world, sensors, drive = scene.world, scene.sensors, scene.drive
    return {
        "effects": [asdict(t) for t in scene.truths],
        "cart": {
            "mass": world.mass,
            "com_x": world.com_x,
            "com_y": world.com_y,
            "inertia": world.inertia,
            "viscous_drag": {"linear": world.linear, "angular": world.angular},
        },
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
