"""The recorded wrenches of a log as reduced wrenches `Sᵀ Σ G F`, with the noise that the contacts give them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.frames import Array
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from ..noise import FilterNoise

FLOOR_SHARE = 0.002
"""Of the forces at work: what a model leaves out at every sample."""
FORCE_FLOOR = 1e-3
ROUNDED, ROUNDING = 0.3, 0.03
"""Of a wrench's jump: what a smoothed motion, which rounds corners, misses of it; s: over which that fades."""
NO_NOISE = 5.5
"""Standard deviations: a jump between two rows that is larger is none of noise's."""
NEIGHBOURS, OWN = 0.15, 0.03
"""s: how far around a row neighbours count, and how near they share its noise."""


@dataclass(frozen=True)
class WrenchRecord:
    """Rows `seen` (n,) have every arm. Reduced grasp maps (arms, n, f, 6), wrenches in {a} (arms, n, 6), and the noise
    covariance (n, f, f) of their sum; 0 where not seen. `rounded` (n, f) is the standard deviation of what a smoothed
    motion misses of their jumps."""

    arms: tuple[str, ...]
    seen: np.ndarray
    grasps: Array
    recorded: Array
    covariance: Array
    rounded: Array

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
        std = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
        rounded = ROUNDED * _jumps(log.time, np.where(seen[:, None], total, np.nan), std)
        return cls(tuple(log.arms), seen, maps, wrenches, covariance, rounded)

    def of_neighbours(self, step: float) -> WrenchRecord:
        """What the rows around each row say of its wrenches, without its own noise."""
        reach, near = max(2, round(NEIGHBOURS / step)), max(1, round(OWN / step))
        kernel = np.ones(2 * reach + 1)
        kernel[reach - near : reach + near + 1] = 0.0
        count = np.maximum(np.convolve(self.seen.astype(float), kernel, "same"), 1.0)
        recorded = np.apply_along_axis(np.convolve, 1, self.recorded, kernel, "same") / count[:, None]
        return replace(self, recorded=recorded)

    def reduced(self, cart: CartModel) -> Array:
        """The true wrench behind what is recorded, (n, f)."""
        value = np.zeros(self.covariance.shape[:2])
        for arm, grasp, recorded in zip(self.arms, self.grasps, self.recorded, strict=True):
            value += (grasp @ cart.corrected_wrench(arm, recorded)[0][..., None])[..., 0]
        return value

    def slopes(self, cart: CartModel, total: Array) -> Array:
        """Slopes (n, f, p) of `reduced` by the parameters, at the wrenches nearest to those recorded that add up to a
        model's `total` (n, f). By a gain or an angle they are in proportion to wrenches: to recorded ones, they would
        have their noise, and all that the model leaves out, on both sides (errors in variables)."""
        n, f = self.covariance.shape[:2]
        found = np.zeros((n, f, len(cart.parameters)))
        if not cart.sensor_effects:
            return found
        missing = np.where(self.seen[:, None], total - self.reduced(cart), 0.0)
        spread = np.einsum("anfi,angi->nfg", self.grasps, self.grasps) + np.eye(f) * ~self.seen[:, None, None]
        share = np.linalg.solve(spread, missing[..., None])
        for arm, grasp, recorded in zip(self.arms, self.grasps, self.recorded, strict=True):
            nearest = recorded + (np.swapaxes(grasp, 1, 2) @ share)[..., 0]
            found += grasp @ cart.corrected_wrench(arm, nearest)[1]
        return found


def _jumps(time: Array, wrench: Array, std: Array) -> Array:
    """How far (n, f) a wrench jumps beyond its noise from one row to the next, near each row."""
    jump = np.maximum(np.nan_to_num(np.abs(np.diff(wrench, axis=0))) - NO_NOISE * std[1:], 0.0)
    found = np.zeros_like(wrench)
    for row in np.flatnonzero(jump.any(axis=1)):
        near = slice(*np.searchsorted(time, (time[row] - 5 * ROUNDING, time[row + 1] + 5 * ROUNDING)))
        away = np.maximum(np.maximum(time[row] - time[near], time[near] - time[row + 1]), 0.0)
        found[near] = np.maximum(found[near], np.exp(-away / ROUNDING)[:, None] * jump[row])
    return found


def _held(contact: Array) -> Array:
    """The last contact that was seen holds; before the first, none (NaN)."""
    known: np.ndarray = np.asarray(np.isfinite(contact).all(axis=1))
    last = np.maximum.accumulate(np.where(known, np.arange(len(contact)), 0))
    return np.where(known[last][:, None], contact[last], np.nan)
