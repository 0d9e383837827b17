"""`cartgrasp estimate LOG --cart cart.yaml`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from estimation import CartFilter, PaperFilter, RegressorEstimator, identifiability
from estimation.log_noise import noise_of_log
from estimation.replay import Replay, replay

from ..cart_file import load_cart
from ..errors import UsageError
from ..logs import RunLog, read_log
from ..logs.emps import rail_cart
from ..model import CartModel
from ..motion import ParameterEstimate
from ..writing import write_atomically
from .output import check_writable, print_json, print_table, progress

METHODS: dict[str, type[CartFilter | RegressorEstimator | PaperFilter]] = {
    "filter": CartFilter,
    "regressor": RegressorEstimator,
    "paper": PaperFilter,
}


def run(path: Path, cart_path: Path | None, method: str, out: Path | None, topics: Path | None, as_json: bool) -> int:
    cart = cart_of(path, cart_path)
    if out is not None:
        check_writable(out, path, cart_path, topics)
    log = read_log(path, topics)
    with progress(f"estimating from {path.name}") as tell:
        result = _replay(log, cart, method, tell)
    if out is not None:
        write_atomically(out, result.series_csv())
    if as_json:
        print_json(result.as_dict())
    else:
        _print(result)
    return 0


def cart_of(path: Path, cart_path: Path | None) -> CartModel:
    if cart_path is not None:
        return load_cart(cart_path)
    if path.suffix.lower() == ".mat":
        return rail_cart()
    raise UsageError("--cart is missing: name the cart.yaml with the cart's structure and first guess")


def _replay(log: RunLog, cart: CartModel, method: str, tell: Any) -> Replay:
    thinned = log.thinned()
    estimator = METHODS[method](cart, list(log.arms), noise=noise_of_log(thinned, cart))
    return replay(thinned, estimator, tell, until=float(log.time[-1]))


def _print(result: Replay) -> None:
    title = f"After {result.last.time:.2f} s, health: {result.last.health}"
    print_parameters(title, result.last.parameters, "taught by this motion")
    if result.last.covariance is not None:
        for one in identifiability(result.last).untaught:
            print(f"- {one}")


def print_parameters(title: str, parameters: Mapping[str, ParameterEstimate], taught: str) -> None:
    """A table; `taught` heads its last column."""
    rows = [
        [name, f"{p.value:.5g}", f"{p.std:.2g}", p.unit, "yes" if p.identifiable else "no"]
        for name, p in parameters.items()
    ]
    print_table(title, ["parameter", "value", "sd", "unit", taught], rows)
