"""The mass that is told: a fit's, moved to the middle of what its bands of frequencies leave open."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...weak_form.band import Band, pooled


def reported_mass(own: float, std: float, bands: Sequence[Band]) -> tuple[float, float]:
    """Logarithm of the mass, and its standard deviation: of a fit (`own`, `std`), in the middle of what its bands leave
    open, and of the band alone that tells it best, beside forces of many forms; each as sure as it is, both no surer
    than they agree."""
    bracket = pooled([(band, band.bracket / band.mass) for band in bands])
    own, std = own + float(np.log1p(bracket)), float(np.hypot(std, bracket))
    best = min(bands, key=lambda band: band.share, default=None)
    if best is None:
        return own, std
    other, its = float(np.log(best.middle)), best.deviation / best.middle
    weight = its**2 / (std**2 + its**2)
    return weight * own + (1 - weight) * other, max(min(std, its), abs(own - other) / 2)
