"""One step of the online filter at 100 Hz, beside the paper's as printed and the algebra of filterpy's EKF and UKF."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from importlib.util import find_spec

import numpy as np

from cartgrasp import CartModel, ContactWrenches, Measurement
from cartgrasp.effects import Effect, RollingResistance, ViscousDrag
from cartgrasp.roles import Estimator
from cartgrasp.simulation.plant import ModelPlant
from cartgrasp.simulation.sensors import Sensors
from cartgrasp.studies.shopping_cart import FILTER_NOISE, SENSOR_NOISE, first_guess, loaded_cart
from estimation import CartFilter, PaperFilter

from .measuring import Competitor, interleave
from .report import Result, timed_table

PERIOD = 0.01
LENGTH = 200  # measurements; then a new filter begins
BURST = 5
POINT = np.array([-0.25, 0.1, 1.0])
OURS = "CartFilter, two effects"
EKF, PARTED, UKF = (f"filterpy {kind}, algebra alone" for kind in ("EKF", "EKF, three updates", "UKF"))
NOTE = """Each measurement holds pose, velocity and one arm's wrench, of a loaded shopping cart that is pushed round
curves. States are pose, nu and memory with the parameters that are learned. Parameters come from a regression, of
which a row is worked out in one step of ten or so: that is in p99, not in the median.

filterpy's filters get as many states as `CartFilter, two effects` has, a fixed transition and no model, so their rows
are the price of their algebra alone. Three updates, with pose, velocity and wrench, do the same job: each sensor has
its gate, and may be missing. One with pose and velocity as six numbers does less: it takes the wrench as exact."""


def run(rounds: int) -> Result:
    log = _log()
    carts = {
        OURS: _with_only(first_guess(), ViscousDrag, RollingResistance),
        "CartFilter, and caster_realignment": first_guess(),
        "CartFilter, viscous_drag alone": _with_only(first_guess(), ViscousDrag),
    }
    makers = {name: partial(CartFilter, cart, noise=FILTER_NOISE) for name, cart in carts.items()}
    states = {name: _size(make()) for name, make in makers.items()}
    competitors = {name: _stepping(make, log) for name, make in makers.items()}
    competitors["PaperFilter"] = _stepping(
        lambda: PaperFilter(_with_only(first_guess(), ViscousDrag), noise=FILTER_NOISE), log
    )
    states["PaperFilter"] = 10
    if find_spec("filterpy") is not None:
        n = states[OURS]
        competitors |= {EKF: _ekf(n, ((0, 6),)), PARTED: _ekf(n, ((0, 3), (3, 2), (n - 2, 2))), UKF: _ukf(n)}
        states |= dict.fromkeys((EKF, PARTED, UKF), n)
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


def _size(online: CartFilter) -> int:
    return len(online.cart.state_names) + len(online.prior.free(online.cart))


def _with_only(cart: CartModel, *kinds: type[Effect]) -> CartModel:
    for effect in cart.effects:
        if not isinstance(effect, kinds):
            cart = cart.without_effect(effect.key)
    return cart


def _log() -> list[Measurement]:
    cart = loaded_cart()
    plant, sensors, log = ModelPlant(cart), Sensors(cart, SENSOR_NOISE), []
    for k in range(LENGTH):
        time = k * PERIOD
        push = 25.0 if time % 3.0 < 1.5 else -2.0
        wrench = np.array([push, 0.0, 0.0, 0.0, 0.0, 0.1 * push + 4.0 * np.sin(4.0 * time)])
        wrenches = ContactWrenches({"hand": wrench}, {"hand": POINT}, {"hand": 0.0})
        seen, felt = sensors.motion(time, plant.motion), sensors.wrenches(time, wrenches)
        log.append(Measurement(time, seen.pose, seen.velocity, felt.wrenches, felt.contacts))
        plant.step(wrenches, PERIOD)
    return log


def _ekf(n: int, blocks: tuple[tuple[int, int], ...]) -> Competitor:
    """Updates with blocks of the state: where each begins, and its size."""
    from filterpy.kalman import ExtendedKalmanFilter

    online = ExtendedKalmanFilter(dim_x=n, dim_z=3)
    online.Q *= 1e-3
    parts = [(np.zeros((size, 1)), np.eye(n)[start : start + size], np.eye(size)) for start, size in blocks]

    def step(_: int) -> object:
        online.predict()
        for z, H, R in parts:
            online.update(z, lambda _, H=H: H, lambda x, H=H: H @ x, R=R)
        return online.x

    return step


def _ukf(n: int) -> Competitor:
    from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

    points = MerweScaledSigmaPoints(n, alpha=0.1, beta=2.0, kappa=0.0)
    online = UnscentedKalmanFilter(n, 6, PERIOD, hx=lambda x: x[:6], fx=lambda x, _: x, points=points)
    online.Q *= 1e-3

    def step(_: int) -> object:
        online.predict()
        online.update(np.zeros(6))
        return online.x

    return step
