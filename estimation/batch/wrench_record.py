"""The recorded wrenches of a log as reduced wrenches `Sᵀ Σ G F`, with the noise that the contacts give them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.frames import Array
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from ..noise import FilterNoise

FLOOR_SHARE = 0.002
"""Of the forces at work: what a model leaves out at every sample."""
FORCE_FLOOR = 1e-3


@dataclass(frozen=True)
class WrenchRecord:
    """Rows `seen` (n,) have every arm. Reduced grasp maps (arms, n, f, 6), wrenches in {a} (arms, n, 6), and the noise
    covariance (n, f, f) of their sum; 0 where not seen."""

    arms: tuple[str, ...]
    seen: np.ndarray
    grasps: Array
    recorded: Array
    covariance: Array

    @classmethod
    def of(cls, log: RunLog, cart: CartModel, noise: FilterNoise) -> WrenchRecord:
        seen = np.ones(len(log), dtype=bool)
        grasps, recorded = [], []
        for arm in log.arms.values():
            contact = _held(arm.contact)
            seen &= np.isfinite(contact).all(axis=1) & np.isfinite(arm.wrench).all(axis=1)
            grasps.append(cart.basis_b.T @ grasp_map_planar(contact))
            recorded.append(arm.wrench)
        maps = np.where(seen[:, None, None], np.array(grasps), 0.0)
        wrenches = np.where(seen[:, None], np.array(recorded), 0.0)
        covariance = np.einsum("anfi,ij,angj->nfg", maps, noise.wrench_covariance, maps)
        total = np.einsum("anfi,ani->nf", maps, wrenches)
        size = max(float(np.sqrt((total**2).mean(axis=0).max())), FORCE_FLOOR)
        covariance[:] += (FLOOR_SHARE * size) ** 2 * np.eye(total.shape[1])
        return cls(tuple(log.arms), seen, maps, wrenches, covariance)

    def reduced(self, cart: CartModel, parameters: Array) -> tuple[Array, Array]:
        """The true wrench behind what is recorded, (n, f), and its partials (n, f, p)."""
        _, n, f, _ = self.grasps.shape
        value, by_parameters = np.zeros((n, f)), np.zeros((n, f, len(parameters)))
        for arm, grasp, recorded in zip(self.arms, self.grasps, self.recorded, strict=True):
            true, true_by_parameters = cart.corrected_wrench(arm, recorded, parameters)
            value += (grasp @ true[..., None])[..., 0]
            by_parameters += grasp @ true_by_parameters
        return value, by_parameters


def _held(contact: Array) -> Array:
    """The last contact that was seen holds; before the first, none (NaN)."""
    known: np.ndarray = np.asarray(np.isfinite(contact).all(axis=1))
    last = np.maximum.accumulate(np.where(known, np.arange(len(contact)), 0))
    return np.where(known[last][:, None], contact[last], np.nan)
