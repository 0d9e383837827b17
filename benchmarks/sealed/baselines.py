"""What general methods make of the same logs, over one library of terms, after the nominal model was refitted:

- `err`: forward regression by error reduction ratios, with orthogonal least squares (Chen, Billings and Luo, 1989);
- `sindy`: sequentially thresholded least squares as pysindy has it (extra `bench`);
- `everything`: least squares with all terms free at once, as system identification of a given structure does; named is
  what would be missed;
- `sysid`: MuJoCo's `sysid` with everything free that its model has (extra `bench`), by rollouts instead of terms;
- `lisdd`: terms of the regimes in which residuals are no noise, by F-tests (`lisdd.py` says what is a guess).

Their reports have the shape of the workflow's; they have no probabilities, no gaps, and nothing to say of what no
term explains.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from .columns import candidates
from .lisdd import localised
from .physics import measured, nominal_columns, report, weights
from .recorded import Cart, Recorded, has_arms, read_cart, read_recorded
from .sysid_report import rolled_out

STOP = 0.02
"""Of the residual's energy: a term that takes away less ends the search."""
COLLINEAR = 0.05
"""Of a column's length: what is left of it beside the terms before; shorter ones are no news."""
MOST_TERMS = 6
RIDGE = 0.05
"""pysindy's own default, for columns of length one."""
SLIGHT = 1e-6
"""For columns of length one: enough for a solution where terms are collinear."""


Selector = Callable[[np.ndarray, np.ndarray, list[np.ndarray], float], list[int]]
"""Of nominal columns, target, library and `stop`: places in the library."""


def regress_all(folder: Path, reports: str, stop: float, method: str = "err") -> int:
    """How many reports were written; none on carts that coast, which these methods know nothing of."""
    logs = sorted(path.parent for path in folder.glob("logs/*/run.csv") if has_arms(path))
    for log in logs:
        start = perf_counter()
        found = METHODS[method](read_recorded(log / "run.csv"), read_cart(log / "cart.yaml"), stop)
        out = log / reports
        out.mkdir(exist_ok=True)
        (out / "report.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        (out / "seconds.json").write_text(json.dumps({"seconds": perf_counter() - start}) + "\n", encoding="utf-8")
    return len(logs)


def regress(log: Recorded, cart: Cart, stop: float = STOP, select: Selector | None = None) -> dict[str, Any]:
    """A report."""
    select = select or selected
    nominal, target = nominal_columns(log, cart), measured(log)
    weight = weights(nominal, target)
    library = candidates(log, cart)
    chosen = select(weight * nominal, weight[:, 0] * target, [weight * one.columns for one in library], stop)
    terms = [(library[i], weight * library[i].columns) for i in chosen]
    return report(cart, weight * nominal, weight[:, 0] * target, terms)


def selected(nominal: np.ndarray, target: np.ndarray, library: list[np.ndarray], stop: float) -> list[int]:
    """Places in the library, in order of choice."""
    basis = np.linalg.qr(nominal)[0]
    lengths = [np.linalg.norm(columns, axis=0) for columns in library]
    rest = [columns - basis @ (basis.T @ columns) for columns in library]
    left = target - basis @ (basis.T @ target)
    energy, chosen = float(left @ left), []
    while len(chosen) < MOST_TERMS:
        bases = [orthonormal(columns, length) for columns, length in zip(rest, lengths, strict=True)]
        ratios = [float(((b.T @ left) ** 2).sum()) / energy for b in bases]
        best = int(np.argmax(ratios))
        if ratios[best] < stop:
            break
        chosen.append(best)
        left = left - bases[best] @ (bases[best].T @ left)
        rest = [columns - bases[best] @ (bases[best].T @ columns) for columns in rest]
    return chosen


def thresholded(nominal: np.ndarray, target: np.ndarray, library: list[np.ndarray], stop: float) -> list[int]:
    """As `selected`: those of which a column of length one has a coefficient that takes away `stop` or more."""
    from pysindy import STLSQ

    basis = np.linalg.qr(nominal)[0]
    left = target - basis @ (basis.T @ target)
    columns = np.hstack(library)
    lengths = np.linalg.norm(columns, axis=0)
    columns -= basis @ (basis.T @ columns)
    news = np.linalg.norm(columns, axis=0)
    fresh = news > COLLINEAR * np.maximum(lengths, 1e-12)
    energy = float(left @ left)
    columns = columns[:, fresh] / news[fresh]
    found = STLSQ(threshold=np.sqrt(stop * energy), alpha=RIDGE).fit(columns, left).coef_.ravel()
    owner = np.repeat(np.arange(len(library)), [one.shape[1] for one in library])[fresh]
    return list(dict.fromkeys(owner[np.argsort(-abs(found))][: np.count_nonzero(found)].tolist()))


def all_free(nominal: np.ndarray, target: np.ndarray, library: list[np.ndarray], stop: float) -> list[int]:
    """As `selected`: those without which the fit of everything would leave `stop` or more of the energy besides."""
    design = np.hstack([nominal, *library])
    design = design / np.maximum(np.linalg.norm(design, axis=0), 1e-12)
    covariance = np.linalg.inv(design.T @ design + SLIGHT * np.eye(design.shape[1]))
    value = covariance @ (design.T @ target)
    basis = np.linalg.qr(nominal)[0]
    left = target - basis @ (basis.T @ target)
    energy, at, missed = float(left @ left), nominal.shape[1], list[float]()
    for columns in library:
        own = slice(at, at + columns.shape[1])
        missed.append(float(value[own] @ np.linalg.solve(covariance[own, own], value[own])) / energy)
        at = own.stop
    return [int(i) for i in np.argsort(-np.array(missed)) if missed[i] >= stop]


METHODS: dict[str, Callable[[Recorded, Cart, float], dict[str, Any]]] = {
    "err": regress,
    "sindy": partial(regress, select=thresholded),
    "everything": partial(regress, select=all_free),
    "sysid": rolled_out,
    "lisdd": localised,
}


def orthonormal(columns: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Directions (n, k or fewer) that columns add, of those that are long enough."""
    scaled = columns / np.maximum(lengths, 1e-12)
    sides, sizes, _ = np.linalg.svd(scaled, full_matrices=False)
    return sides[:, sizes > COLLINEAR]
