"""The stretches of a log from which a cart's parameters can be learned, each in the band in which the model foretells
its motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.logs import RunLog
from cartgrasp.logs.coasting import without_idle_arms
from cartgrasp.model import CartModel

from ..impacts.impacts import impacts
from ..log_noise.glitches import without_glitches
from ..noise import FilterNoise
from ..sensor_check.heading import heading_drift, without_drift
from ..sensor_check.jumps import jump_times
from ..sensor_check.recording_artefacts import blank_columns
from ..sensor_check.repeated_rows import without_repeats
from ..sensor_check.sizes import check_jumps, check_sizes
from ..weak_form.balances import Balances
from ..weak_form.band import Band, bands, sharp
from ..weak_form.log_segments import segment_logs, split_at_gaps
from ..weak_form.sensor_noise import MotionNoise

MIN_BALANCE_ROWS = 3
"""Fewest rows of a log's balances: fewer say nothing of how large their noise is."""
ISOLATED_OUTLIER_SIGMAS = 5.0
"""Times the noise from which on a sample that stands alone is off: one in two million is by chance."""
MAX_PART_POSE_GAP = 1.0
"""s without a pose, from which on a log is two."""
FINE_SAMPLES_PER_KNOT, MAX_FINE_DURATION = 12.0, 120.0
"""Behind each coefficient of a finer motion, that its noise is averaged out of it; s, up to which a log has that."""


@dataclass(frozen=True, eq=False)
class LogPart:
    """A stretch of a log, by its index, in its band."""

    log: int
    balances: Balances
    band: Band | None


class NothingSaidError(Exception):
    """Why a log says nothing."""


def learnable_parts(index: int, log: RunLog, cart: CartModel, noise: FilterNoise | None) -> list[LogPart]:
    known = without_glitches(without_repeats(without_idle_arms(log)), ISOLATED_OUTLIER_SIGMAS)
    check_sizes(known)
    known = without_drift(known, heading_drift(known, cart))
    found, why = list[LogPart](), ""
    with np.errstate(all="ignore"):  # numbers beyond reason are told as such
        for piece in split_at_gaps(known, MAX_PART_POSE_GAP):
            check_jumps(piece, float(MotionNoise.of(piece).pose[0]))
            try:
                hits, lost = impacts(piece, cart), jump_times(piece)
                between = segment_logs(piece, hits, lost) if hits or len(lost) else [piece]
                found += [_part(index, own, cart, noise) for own in between]
            except DataError as error:
                why = why or str(error)
    found = [part for part in found if len(part.balances.used) >= MIN_BALANCE_ROWS]
    if not found:
        raise NothingSaidError(
            why or f"{log.name}: poses and wrenches come together nowhere for long enough to learn from{_blank(log)}"
        )
    return found


def _blank(log: RunLog) -> str:
    """Which columns are to blame."""
    names = [name for of_arm in blank_columns(log).values() for name in of_arm]
    return f": {', '.join(names)} {'is' if len(names) == 1 else 'are'} blank in every row" if names else ""


def _part(index: int, log: RunLog, cart: CartModel, noise: FilterNoise | None) -> LogPart:
    fine = FINE_SAMPLES_PER_KNOT if log.duration < MAX_FINE_DURATION else None
    balances = Balances.of(log, cart, told=noise, samples_per_knot=fine)
    band = sharp(bands(balances, cart)) if len(balances.used) >= MIN_BALANCE_ROWS else None
    return LogPart(index, balances if band is None else balances.every(band.row_step), band)
