"""When something begins that has a place of its own: what a load weighs and where it lies hang on when it is put on,
and a linear fit, in which it lies where loads usually do, finds another time."""

from __future__ import annotations

import numpy as np

from .fitted import Fitted

STEPS, MOST_FITS = (1.0, 0.5, 0.25), 14
"""s: by which an onset is moved; and how many fits that may take."""
BETTER = 0.5
"""By how much the log of the likelihood is to grow: less is no reason to move."""


def with_best_onset(fitted: Fitted, model: Fitted) -> Fitted:
    """`model`, which is `fitted` with one more effect, with this begun when whole fits say so."""
    effect = next(one for one in model.cart.effects if one.key == model.added[-1].key)
    others = {one.key for one in fitted.added}
    start, least, left = float(effect.values[0]), model.chi_squared(others), MOST_FITS
    for step in STEPS:
        for way in (-step, step):
            while left > 0:
                left -= 1
                tried = fitted.tried(effect.with_values(np.r_[start + way, effect.values[1:]]))
                found = tried.chi_squared(others)
                if found > least - 2 * BETTER:
                    break
                start, least, model = start + way, found, tried
    return model
