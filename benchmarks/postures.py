"""What it costs a tick of `WrenchPlanner.plan_or_hold` that the limits of two iiwa 14 are those of their posture of
now."""

from __future__ import annotations

from importlib.resources import files
from importlib.util import find_spec
from typing import Any

import numpy as np

from cartgrasp import Arm
from cartgrasp.spatial_pose import SpatialPose
from cartgrasp.urdf_arm import read_urdf_arm
from cartgrasp.urdf_postures import UrdfPostures
from planning import WrenchPlanner

from .measuring import Competitor, interleave
from .report import Result, timed_table
from .scene import CART

BURST, KINDS = 10, 3
KEPT = "limits as numbers"
SIDES, BASE, HAND = {"left": 0.2, "right": -0.2}, (-0.7, 0.7), (0.0, np.pi / 2, 0.0)
BENT = (0, 0.6, 0, -1.6, 0, -0.6, 0)
NOTE = """Two arms with boxes and seven joints each; after `warm_up`. The wrench is new at every call. Contacts go round
three places, whose postures are known since the planner was made, or move by 0.1 mm a call."""


def run(rounds: int) -> Result:
    if find_spec("pinocchio") is None or find_spec("rtbdata") is None:
        return Result("What postures cost", "Left out: needs the extra `arms`.", ())
    places = [{name: np.array([0.0, y, z]) for name, y in SIDES.items()} for z in (1.0, 1.1, 1.2)]
    competitors = {
        KEPT: _tick(_arms(_sources(), as_numbers=True), lambda k: places[0]),
        "postures, at the same contacts": _tick(_arms(_sources()), lambda k: places[0]),
        "at other contacts that are known": _tick(_arms(_sources()), lambda k: places[k % KINDS]),
        "at new contacts": _tick(_arms(_sources()), lambda k: _shifted(places[0], 1e-4 * k)),
        "with bases that move by 1 mm": _moving(_sources(), places[0]),
    }
    table = timed_table("Limits of two arms", interleave(competitors, rounds, BURST), KEPT, "µs", {})
    return Result("What postures cost", NOTE, (table,))


def _sources() -> dict[str, UrdfPostures]:
    import rtbdata

    urdf = files(rtbdata) / "xacro/kuka_description/kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf"
    found = {}
    for name, y in SIDES.items():
        arm = read_urdf_arm(str(urdf), "tool0", torque_limit=[20.0] * 7).placed(_base(0, y), (0.0, 0.0, 0.0))
        found[name] = UrdfPostures(arm, HAND, BENT)
    return found


def _base(call: int, y: float) -> SpatialPose:
    return SpatialPose.of((BASE[0] + 0.02 * np.sin(call / 20), y, BASE[1]))


def _arms(sources: dict[str, UrdfPostures], as_numbers: bool = False) -> list[Arm]:
    limits: dict[str, Any] = {"force_limit": (100.0,) * 3, "moment_limit": (8.0,) * 3}
    points = {name: [(0.0, y, z) for z in (1.0, 1.1, 1.2)] for name, y in SIDES.items()}
    posed = [Arm(name, points[name], joints=source, **limits) for name, source in sources.items()]
    return [Arm(arm.name, arm.contacts, joints=arm.joints, **limits) for arm in posed] if as_numbers else posed


def _shifted(contacts: dict[str, np.ndarray], up: float) -> dict[str, np.ndarray]:
    return {name: point + np.array([0.0, 0.0, up]) for name, point in contacts.items()}


def _tick(arms: list[Arm], contacts: Any) -> Competitor:
    wrenches = np.random.default_rng(0).uniform((10.0, 0.0, -3.0), (40.0, 0.0, 3.0), (40, 3))
    planner = WrenchPlanner(CART, arms)
    planner.warm_up()
    return lambda k: planner.plan_or_hold(wrenches[k % 40], contacts(k))


def _moving(sources: dict[str, UrdfPostures], contacts: dict[str, np.ndarray]) -> Competitor:
    tick = _tick(_arms(sources), lambda k: contacts)

    def moved(call: int) -> object:
        for name, y in SIDES.items():
            sources[name].place(_base(call, y))
        return tick(call)

    return moved
