"""One step of the online filter at 100 Hz, beside the paper's as printed and the algebra of filterpy's EKF."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib.util import find_spec

import numpy as np

from cartgrasp import CartModel, ContactWrenches, Measurement
from cartgrasp.effects import ViscousDrag
from cartgrasp.roles import Estimator
from cartgrasp.simulation.plant import ModelPlant
from cartgrasp.simulation.sensors import Sensors
from cartgrasp.studies.shopping_cart import NOISE, SENSORS, first_guess, loaded_cart
from estimation import CartFilter, PaperFilter

from .measuring import Competitor, interleave
from .report import Result, timed_table

PERIOD = 0.01
LENGTH = 200  # measurements; then a new filter begins
BURST = 5
POINT = np.array([-0.25, 0.1, 1.0])
OURS = "CartFilter, viscous_drag"
FILTERPY = "filterpy EKF, algebra alone"
NOTE = """Each measurement holds pose, velocity and one arm's wrench, of a loaded shopping cart that is pushed round
curves. filterpy's EKF gets a fixed transition, no model, and the same three updates, so its row is the price of
its algebra alone, for the state of `CartFilter, viscous_drag`."""


def run(rounds: int) -> Result:
    log = _log()
    simple = _only_drag(first_guess())
    with_effects = "CartFilter, and rolling_resistance, caster_realignment"
    makes: dict[str, Callable[[], Estimator]] = {
        OURS: lambda: CartFilter(simple, noise=NOISE),
        with_effects: lambda: CartFilter(first_guess(), noise=NOISE),
        "PaperFilter": lambda: PaperFilter(simple, noise=NOISE),
    }
    competitors = {name: _stepping(make, log) for name, make in makes.items()}
    n = _size(CartFilter(simple, noise=NOISE), log)
    states = {OURS: n, with_effects: _size(CartFilter(first_guess(), noise=NOISE), log), "PaperFilter": 10}
    if find_spec("filterpy") is not None:
        competitors[FILTERPY], states[FILTERPY] = _filterpy(n), n
    columns = {"states": {name: str(size) for name, size in states.items()}}
    table = timed_table("A step", interleave(competitors, rounds, BURST), OURS, "µs", columns)
    return Result("Filter step", NOTE, (table,))


def _stepping(make: Callable[[], Estimator], log: list[Measurement]) -> Competitor:
    """Walks through the log, call by call; at its end a new filter begins."""

    def steps() -> Iterator[object]:
        while True:
            online = make()
            yield from (online.update(measurement) for measurement in log)

    walk = steps()
    return lambda _: next(walk)


def _size(online: CartFilter, log: list[Measurement]) -> int:
    online.update(log[0])
    return len(online.belief.mean)


def _only_drag(cart: CartModel) -> CartModel:
    for effect in cart.effects:
        if not isinstance(effect, ViscousDrag):
            cart = cart.without_effect(effect.key)
    return cart


def _log() -> list[Measurement]:
    cart = loaded_cart()
    plant, sensors, log = ModelPlant(cart), Sensors(cart, SENSORS), []
    for k in range(LENGTH):
        time = k * PERIOD
        push = 25.0 if time % 3.0 < 1.5 else -2.0
        wrench = np.array([push, 0.0, 0.0, 0.0, 0.0, 0.1 * push + 4.0 * np.sin(4.0 * time)])
        wrenches = ContactWrenches({"hand": wrench}, {"hand": POINT}, {"hand": 0.0})
        seen, felt = sensors.motion(time, plant.motion), sensors.wrenches(time, wrenches)
        log.append(Measurement(time, seen.pose, seen.velocity, felt.wrenches, felt.contacts))
        plant.step(wrenches, PERIOD)
    return log


def _filterpy(n: int) -> Competitor:
    from filterpy.kalman import ExtendedKalmanFilter  # type: ignore[import-not-found]

    online = ExtendedKalmanFilter(dim_x=n, dim_z=3)
    online.Q *= 1e-3
    parts = []
    for start, size in ((0, 3), (3, 2), (n - 2, 2)):
        H = np.zeros((size, n))
        H[:, start : start + size] = np.eye(size)
        parts.append((np.zeros((size, 1)), H, np.eye(size)))

    def step(_: int) -> object:
        online.predict()
        for z, H, R in parts:
            online.update(z, lambda _, H=H: H, lambda x, H=H: H @ x, R=R)
        return online.x

    return step
