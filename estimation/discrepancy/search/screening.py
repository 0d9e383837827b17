"""Every variant of a candidate at once, by what its columns take away of a model's residual: gates by sums over blocks
of time, places by sums over cells of the floor."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from itertools import combinations, product

import numpy as np
from scipy.optimize import minimize_scalar

from cartgrasp.effects import ConstraintEffect, Effect, LearnedForce
from cartgrasp.effects.effect import Gate
from cartgrasp.effects.time_delay import TimeDelay
from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ...weak_form.balances import Balances
from ...weak_form.rows import wrench_covariance
from ...weak_form.score import log_evidence
from ...weak_form.wheel_tracks import wheel_tracks
from .candidates import Family, amplitudes_of
from .laws import Law, seen_values, smooth_laws
from .model import Model, by_log
from .periods import coarse_columns, is_like_a_scans, scanned

MAX_KEPT_VARIANTS = 3
"""Variants of a candidate whose score is worked out."""
ONSET_GRID_INTERVAL = 0.2
"""Blocks of time (s) between which onsets and ends are tried."""
SPAN_BLOCKS = (1, 2, 3, 5, 8, 12, 18, 28)
"""Numbers of blocks that something may last."""
MIN_CHANGE_MARGIN = 1.0
"""Least time (s) before and after a lasting change."""
CELL_SIZE, MAX_CELLS_PER_AXIS, FLOOR_RIM = 0.4, 10, 0.05
"""Size of a cell (m), most cells along an axis, and rim (m) around all wheels' tracks."""
MIN_HAND_LEVER = 0.02
"""Least lever (m): hands that are nearer push at {b}'s x."""
PERIOD_SEARCH_WIDTH, PERIOD_SEARCH_TOLERANCE = 0.5, 0.02
"""Most periods in a log that a scan may be off by; and how exactly the period is told, as a share of that."""
MAX_WHITENED_COLUMN = 1e12
"""Largest whitened column: beyond, an effect's memory ran away in the integrator's steps, at settings that no cart
has."""

ScoredVariant = tuple[float, Effect]


# Many methods: one for each kind of candidate (constant, timed, placed, late, laws); all ask the same products.
class Screen:
    """Gains of candidates beside one model."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self._scale = model.score.scale
        rows = model.rows / self._scale[:, None]
        self._base, self._left = rows[..., :-1], rows[..., -1]
        flat = self._base.reshape(-1, self._base.shape[2])
        self._covariance = np.linalg.inv(flat.T @ flat + np.diag(model.prior_std**-2.0))
        self._fit = self._covariance @ (flat.T @ self._left.ravel())

    # --- gains ---------------------------------------------------------------------------------------------------

    def gain(self, effect: Effect, share: Callable[[Array], Array] | None = None) -> float:
        """Log of the Bayes factor of one setting, about, with all amplitudes free; of a `share` of it at each time."""
        if isinstance(effect, TimeDelay):
            return self._delayed(effect)
        columns, std = self.model.columns_of(effect, share)
        if not (np.abs(columns) < MAX_WHITENED_COLUMN).all():
            return -np.inf
        return float(self.gains(columns[None], std, is_one_sided(effect))[0])

    def gains(self, columns: Array, std: Array, one_sided: bool = False) -> Array:
        """Log of the Bayes factor (v,), about, of variants' whitened columns (v, k, c, q)."""
        own = (columns / self._scale[:, None]).reshape(len(columns), -1, columns.shape[3])
        across = own.swapaxes(1, 2)
        products = across @ own, across @ self._base.reshape(own.shape[1], -1), across @ self._left.ravel()
        return self._factor(products, std, one_sided)

    def _factor(self, products: tuple[Array, Array, Array], std: Array, one_sided: bool) -> Array:
        """Log of the Bayes factor (v,) from products with themselves (v, q, q), with the base (v, q, p), with the
        residual (v, q). A `one_sided` amplitude that would be negative gains nothing."""
        own, to_base, pull = products
        information = own - to_base @ self._covariance @ to_base.swapaxes(-1, -2) + np.diag(std**-2.0)
        pull = pull - to_base @ self._fit
        best = np.linalg.solve(information, pull[..., None])[..., 0]
        size = np.linalg.slogdet(information)[1] / 2 + np.log(std).sum()
        gain = 0.5 * (pull * best).sum(axis=-1)
        if one_sided:
            gain = np.where(best[..., 0] > 0, gain, 0.0)
        return np.asarray(gain - size)

    def _delayed(self, effect: TimeDelay) -> float:
        """Log of the Bayes factor, about, of a log whose wrenches were felt earlier."""
        late = self.model.felt_by(self.model.cart.with_effect(effect))
        evidence = [
            log_evidence(m.folds.sums(m.rows).sum(axis=1), m.prior_std, self._scale, 0.0 * self._scale)
            for m in (late, self.model)
        ]
        return float(evidence[0] * len(self.model.rows) / len(late.rows) - evidence[1])

    # --- variants ------------------------------------------------------------------------------------------------

    def best(self, family: Family) -> tuple[list[Effect], int]:
        """The best few variants, and of how many; of one that is there all the time, none has to be chosen."""
        if len(family.variants) == 1 and family.variants[0].gate is Gate.ALWAYS:
            return list(family.variants), 1
        found: list[ScoredVariant] = []
        for effect in family.variants:
            if effect.gate is Gate.INSIDE:
                found += self._placed(effect)
            elif effect.gate.passes:
                found += self._timed(effect)
            else:
                found.append((self.gain(effect), effect))
        found = [one for one in found if np.isfinite(one[0])]
        found.sort(key=lambda one: -one[0])
        return [effect for _, effect in found[:MAX_KEPT_VARIANTS]], len(found)

    def _timed(self, effect: Effect) -> list[ScoredVariant]:
        """Variants that act from or between blocks of time, with their gains."""
        columns, std = self.model.columns_of(effect)
        parts = (by_log(part, self.model.logs) for part in (columns / self._scale[:, None], self._base, self._left))
        found = list[ScoredVariant]()
        for balances, *own in zip(self.model.logs, *parts, strict=True):
            size = max(1, round(ONSET_GRID_INTERVAL / balances.row_step))
            n = len(balances.used) // size
            spans = _spans(n, effect.gate, max(1, round(MIN_CHANGE_MARGIN / (size * balances.row_step))))
            if n < 2 or not len(spans):
                continue
            edges = np.append(balances.time[: n * size : size], balances.time[n * size - 1] + balances.row_step)
            own_sums, base_sums, pulls = (s[spans[:, 1]] - s[spans[:, 0]] for s in _running(own, n, size))
            gains = self._factor((own_sums, base_sums, pulls), std, is_one_sided(effect))
            starts, ends = edges[spans[:, 0]] - balances.row_step / 2, edges[spans[:, 1]] - balances.row_step / 2
            gates = starts[:, None] if effect.gate is Gate.FROM else np.column_stack([starts, ends - starts])
            found += _gated(effect, gains, gates)
        return found

    def _placed(self, effect: Effect) -> list[ScoredVariant]:
        """Variants that act in boxes of cells, with their gains."""
        x, y = self._cells
        cells = list(product(range(len(x) - 1), range(len(y) - 1)))
        columns = []
        for i, j in cells:
            inside = effect.with_values(np.r_[x[i], x[i + 1], y[j], y[j + 1], effect.values[4:]])
            own, std = self.model.columns_of(inside)
            columns.append((own[..., 0] / self._scale).ravel())
        each = np.array(columns)
        spans = [list(combinations(range(len(edges)), 2)) for edges in (x, y)]
        boxes = list(product(*spans))
        chosen = np.zeros((len(boxes), len(x) - 1, len(y) - 1))
        for k, ((left, right), (low, high)) in enumerate(boxes):
            chosen[k, left:right, low:high] = 1.0
        pick = chosen.reshape(len(boxes), -1)
        within = np.einsum("vi,ij,vj->v", pick, each @ each.T, pick, optimize=True)[:, None, None]
        base, pull = each @ self._base.reshape(each.shape[1], -1), each @ self._left.ravel()
        gains = self._factor((within, (pick @ base)[:, None], (pick @ pull)[:, None]), std, is_one_sided(effect))
        return _gated(effect, gains, np.array([(x[a], x[b], y[c], y[d]) for (a, b), (c, d) in boxes]))

    @cached_property
    def _cells(self) -> tuple[Array, Array]:
        """Edges of cells in x and y over all wheels' tracks."""
        wheels = self.model.cart.wheel_set
        tracks = np.concatenate([wheel_tracks(b.motion.pose, wheels).reshape(2, -1) for b in self.model.logs], axis=1)
        low, high = tracks.min(axis=1) - FLOOR_RIM, tracks.max(axis=1) + FLOOR_RIM
        counts = np.clip(np.ceil((high - low) / CELL_SIZE), 1, MAX_CELLS_PER_AXIS).astype(int)
        return np.linspace(low[0], high[0], counts[0] + 1), np.linspace(low[1], high[1], counts[1] + 1)

    # --- laws ----------------------------------------------------------------------------------------------------

    def laws(self) -> Iterator[tuple[Law, int]]:
        """Each proposed law and each smooth one that the model does not have, and the best periods with one or more
        harmonics; with how many were tried."""
        model = self.model
        proposed = [Law.free("as proposed", one) for one in model.candidates if isinstance(one, LearnedForce)]
        smooth, taken = smooth_laws(model.motions, model.cart, self._hands), {law.key for law in model.laws}
        yield from ((law, 1) for law in (*proposed, *smooth) if law.key not in taken)
        found, count = scanned(model, self._pulls, self.gains, self._hands)
        found.sort(key=lambda best: -best[0][0])
        for _, scan, period, harmonics in (one for best in found[:MAX_KEPT_VARIANTS] for one in best):
            law = self.tuned(scan.law(period, harmonics))
            for has_mean in (False, True):
                yield scan.law(law.period or period, harmonics, has_mean), count

    @cached_property
    def _hands(self) -> float:
        """The lever (m) at which a force is felt as force sensors' noise is; none where it is next to nothing."""
        cart = self.model.cart
        if cart.constraints.n_free == 1:
            return 0.0
        noise = [wrench_covariance(balances, cart) for balances in self.model.logs]
        lever = -float(np.mean([one[-1, 0] / one[0, 0] for one in noise]))
        return lever if abs(lever) > MIN_HAND_LEVER else 0.0

    @cached_property
    def _pulls(self) -> list[Array]:
        """Pulls (n, f) of the residual on forces and moments along each log's grid."""
        rest = self._left - self._base @ self._fit
        free, logs = self.model.cart.constraints.n_free, self.model.logs
        parts = zip(logs, self.model.whitenings, by_log(rest / self._scale, logs), strict=True)
        return [balances.integrals.spread(whiten.transposed(own))[:, :free] for balances, whiten, own in parts]

    def tuned(self, law: Law) -> Law:
        """The law at the period nearby that gains most."""
        if law.period is None or not (highest := max(law.effects[0].harmonics)):
            return law
        longest = max(float(np.ptp(seen_values(law.effects[0], [motion]))) for motion in self.model.motions)
        width = PERIOD_SEARCH_WIDTH * law.period / (longest / law.period * highest)
        columns = coarse_columns if is_like_a_scans(law.effects[0]) else Law.columns
        best = minimize_scalar(
            lambda period: -self.of_law(law.repeating(period), columns),
            bounds=(law.period - width, law.period + width),
            method="bounded",
            options={"xatol": PERIOD_SEARCH_TOLERANCE * width},
        )
        return law.repeating(float(best.x)) if -best.fun > self.of_law(law, columns) else law

    def of_law(self, law: Law, columns: Callable[[Law, Balances, CartModel], Array] = Law.columns) -> float:
        """Log of the Bayes factor of a law, about; by its columns, or as coarse ones."""
        white = self.model.whitened([columns(law, balances, self.model.cart) for balances in self.model.logs])
        return float(self.gains(white[None], law.std)[0])


def is_one_sided(effect: Effect) -> bool:
    """Whether it has one amplitude, and none but positive ones are possible."""
    if isinstance(effect, ConstraintEffect | TimeDelay):
        return False
    own = [effect.parameters[i] for i in amplitudes_of(effect)]
    return len(own) == 1 and own[0].lower >= own[0].absent


def _running(parts: Sequence[Array], n: int, size: int) -> list[Array]:
    """Sums (n + 1, ...) up to each of n blocks of so many rows: of products of columns with themselves, with the base
    and with the residual, of which the rows are given."""
    columns, base, left = (part[: n * size].reshape(n, -1, *part.shape[2:]) for part in parts)
    across = columns.swapaxes(1, 2)
    products = across @ columns, across @ base, (across @ left[..., None])[..., 0]
    return [np.concatenate([np.zeros((1, *one.shape[1:])), np.cumsum(one, axis=0)]) for one in products]


def _gated(effect: Effect, gains: Array, gates: Array) -> list[ScoredVariant]:
    """Variants with gates (v, g), which gain so much (v,); those that are not among the best only count."""
    best = set(np.argsort(-gains)[:MAX_KEPT_VARIANTS].tolist())
    return [
        (gain, effect.with_values(np.r_[gate, effect.values[len(gate) :]]) if i in best else effect)
        for i, (gain, gate) in enumerate(zip(gains.tolist(), gates, strict=True))
    ]


def _spans(n: int, gate: Gate, side: int) -> np.ndarray:
    """Spans of blocks (v, 2), first and one past the last."""
    if gate is Gate.FROM:
        first = np.arange(side, n - side)
        return np.column_stack([first, np.full(len(first), n)])
    return np.array([(i, i + size) for size in SPAN_BLOCKS for i in range(n - size + 1)]).reshape(-1, 2)
