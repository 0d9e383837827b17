"""Carts on rails: two rows of constraints, to and fro over one stroke."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .references import smoothed
from .scenes import Roughness, Scene, draw_contacts
from .sizes import ROUGH


def rail(scene: Scene, random: np.random.Generator) -> Scene:
    """Along {s}'s x in half of the seeds, where only x is measured; else in any direction."""
    stroke = float(random.uniform(*ROUGH["rail"]["stroke"]))
    along_x = random.random() < 0.5
    heading = 0.0 if along_x else float(random.uniform(-np.pi, np.pi))
    drive = scene.drive
    wanted = to_and_fro(drive.time, stroke, random)
    contacts = draw_contacts(drive.time, wanted, drive.shares.shape[1], random)
    errors = drive.errors * np.array([1.0, 0.0])
    return replace(
        scene,
        world=scene.world._replace(rail=1.0),
        drive=drive._replace(speeds=wanted, contacts=contacts, errors=errors),
        sensors=replace(scene.sensors, along_x_only=along_x),
        begins=(heading, 0.0, 0.0),
        roughness=(*scene.roughness, Roughness("rail", {"stroke": stroke, "heading": heading})),
    )


def to_and_fro(time: np.ndarray, stroke: float, random: np.random.Generator) -> np.ndarray:
    """(n, 4): u, r and their rates. Trapezes of speed, each of one stroke, with rests between or without."""
    limits, u = ROUGH["rail"], np.zeros(len(time))
    at, way = time[0] + 1.0, 1.0
    while True:
        gained = random.uniform(*limits["acceleration"])
        fast = min(random.uniform(*limits["speed"]), np.sqrt(gained * stroke))
        duration = stroke / fast + fast / gained
        if at + duration > time[-1] - 1.0:
            break
        since = time - at
        u += way * np.clip(np.minimum(gained * np.minimum(since, duration - since), fast), 0.0, None)
        at, way = at + duration + random.uniform(*limits["rest"]), -way
    path = smoothed(u[:, None])[:, 0]
    zero = np.zeros_like(path)
    return np.column_stack([path, zero, np.gradient(path, time), zero])


def along_rail(scene: Scene) -> Scene:
    """A slope is along the rail: across it none would be felt."""
    if not scene.world.rail:
        return scene
    cosine, sine = np.cos(scene.begins[0]), np.sin(scene.begins[0])

    def turned(values: dict[str, float]) -> dict[str, float]:
        grade = float(np.copysign(np.hypot(values["grade_x"], values["grade_y"]), values["grade_x"]))
        return {"grade_x": grade * float(cosine), "grade_y": grade * float(sine)}

    truths = tuple(
        replace(t, parameters=t.parameters | turned(t.parameters)) if t.name == "floor_slope" else t
        for t in scene.truths
    )
    world = scene.world._replace(**turned(scene.world._asdict()))
    return replace(scene, world=world, truths=truths)
