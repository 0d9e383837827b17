"""Whether a probable effect is worth naming: it must be plausible, steady, sure, and gain where no fit looked."""

from __future__ import annotations

from dataclasses import dataclass

from cartgrasp.effects import Effect, ForceEffect, SensorEffect
from cartgrasp.effects.effect import Gate

from .evidence import Finding
from .fitted import Fitted
from .held_out import HeldOut
from .strange_carts import drives_itself, takes_too_much

ENOUGH, ENOUGH_SEARCHED, ENOUGH_PASSING = 7.0, 12.0, 20.0
"""Logs of the Bayes factor of an effect that is named; of one whose speed or frequency was searched for, which finds
what a smoothed motion lacks; of one that acts for a while, which any accident is like."""
LEAST_GAIN = 0.05
"""Of the gap above the noise floor, on stretches that no fit saw."""
BESIDE = {Gate.WHILE: 0.15, Gate.FROM: 0.02, Gate.INSIDE: 0.01, Gate.ALWAYS: 0.01}
"""Of the log of the strongest earlier Bayes factor: what another form of that effect leaves looks like accidents, but
hardly like a lasting change, or like what always acts."""
BESIDE_LATE = 0.05
"""The same, of what swings beside a sensor that is late: one that lags rounds what it records, too."""
MOST_BESIDE = 180.0
"""Log of a Bayes factor: no form of an effect leaves more than that behind it."""
LEAST_LIKELIHOOD = 4.0
"""Log of a likelihood ratio on stretches that no fit saw: enough for what moves a rollout by less than noise does, and
beyond what rollouts say against it, which is little where they are all noise."""
NO_WORSE = 0.005
"""Of the gap above the noise floor: what noise may make of it at least."""
LEAST_OF_REST = 0.3
"""Of what is left of the gap, where that is more than noise: enough where other effects closed most of it."""
MOST_CHANGE, MOST_DRIFT, MOST_DRIFT_REMEMBERED = 0.5, 0.5, 1.0
"""Of its size: what an effect may change by when a quarter of the log is left out; from all to one quarter, beyond
noise; the same of one with a memory, which in one quarter may have been another."""
ABUTS = 0.2
"""m: a second place of one effect that is nearer to the first may be the ramp at its edge, or a part of it where it is
thicker; half a cell, by which places are first moved."""
ADDED, UNSTEADY = "added", "its size is another in another part of the log"
OUTSIDE, OUTSIDE_FLOOR, OUTSIDE_PASSING, LEAST_FORETOLD = 1.0, 1.15, 0.5, 0.1
"""Times the chi-squared that an effect takes away: what time or way foretell better is none of the vocabulary; nor what
heading or place do, by more than they foretell of a slope. What acts for a while takes away some turns of anything
periodic, and some of what follows the heading. Of the squares: what foretells less is any."""


@dataclass(frozen=True)
class Verdict:
    """Whether an effect is added; if not, why; the share of the gap above the noise floor that it closes on held-out
    stretches, where it came to that; whether there is something like it that has no name, so that nothing that explains
    less is its name; and whether it is only not proven, so that no accident that explains less is."""

    is_added: bool
    reason: str
    held_out_gain: float | None = None
    is_nameless: bool = False
    is_unproven: bool = False


@dataclass(frozen=True)
class Judge:
    """At a step of a search that has come to `fitted`; `strongest` is the largest log of a Bayes factor so far."""

    fitted: Fitted
    held_out: HeldOut
    strongest: float

    def may_be(self, absent: Effect) -> bool:
        """Whether a search may begin from a setting: one that its grid offers, but no cart like this has, is left."""
        searched = absent.gate is Gate.ALWAYS and any(absent.grids(self.fitted.cart.wheel_set))
        return not (searched and absent.implausible(*self.held_out.rolling))

    def is_odd(self, effect: Effect) -> bool:
        """Whether a search keeps away from a setting. A place may grow until it is everywhere, and a speed until no
        friction fades below it: that is none then, and not one at the limit."""
        return effect.is_bounded and bool(effect.implausible(*self.held_out.rolling))

    def implausible(self, effect: Effect) -> str:
        """Why nobody would call it so on these logs; empty where they would."""
        nowhere_else = "it would be nearly everywhere" if self.held_out.covers(effect) else ""
        return effect.implausible(*self.held_out.rolling) or nowhere_else or self._simpler(effect)

    def _simpler(self, effect: Effect) -> str:
        """A cart that has the simpler one already has fitted it, and this is what it lacks."""
        has = effect.simpler in {one.name for one in self.fitted.cart.effects}
        return f"at these values, it is {effect.simpler}" if effect.simpler and not has else ""

    def verdict(self, found: Finding, score: float, model: Fitted) -> Verdict:
        """Of an effect that was found, with the log of its Bayes factor, and the fit with it as the last added."""
        effect = next(one for one in model.cart.effects if one.key == found.effect.key)
        strange = self.implausible(effect) or takes_too_much(effect, model.cart) or self._bends_mass(effect, model)
        if strange:  # of a sensor: wrenches, spoiled by what no sensor does
            return Verdict(False, strange, is_nameless=isinstance(effect, SensorEffect))
        nameless = self._held(effect, model) or self._unsteady(found, effect) or self._outside(effect, score)
        if nameless:
            return Verdict(False, nameless, is_nameless=True)
        reason = self._unsure(effect, score) or drives_itself(model.cart, self.held_out.rolling[1])
        return Verdict(False, reason) if reason else self._proven(effect, model)

    def _proven(self, effect: Effect, model: Fitted) -> Verdict:
        """By what it gains on stretches that no fit saw."""
        proof = self.held_out.everywhere if effect.gate.ends else self.held_out
        gain = proof.gain(self.fitted, model)
        share, others = gain.share, [one for one in model.cart.effects if one.key != effect.key]
        is_form = any(_abut(effect, other) for other in others)
        if share >= LEAST_GAIN or (gain.of_rest >= LEAST_OF_REST and not is_form):
            return Verdict(True, ADDED, share)
        least = LEAST_LIKELIHOOD + 0.5 * (min(share, 0.0) / max(gain.noise, NO_WORSE)) ** 2
        if not (effect.gate.ends or is_form) and self.held_out.likelihood(self.fitted, model) > least:
            return Verdict(True, ADDED, share)
        reason = f"closes {100 * share:.1f} % of the gap on held-out stretches, less than {100 * LEAST_GAIN:g} %"
        return Verdict(False, reason, share, is_unproven=True)

    def _bends_mass(self, effect: Effect, model: Fitted) -> str:
        """A sensor that is read rightly again brings the mass back to what was believed of it, if anywhere."""
        if not isinstance(effect, SensorEffect):
            return ""
        believed = self.fitted.prior_cart.inertia.mass
        without, found = (abs(each.cart.inertia.mass - believed) for each in (self.fitted, model))
        if found <= max(without, self.fitted.prior.mass * believed):
            return ""
        return f"with it, the mass would be {model.cart.inertia.mass:.3g} kg, far from {believed:.3g} kg"

    def _held(self, effect: Effect, model: Fitted) -> str:
        late = effect.lateness
        if 0 < late < _longest_step(model):
            return f"{1e3 * late:.0f} ms is less than a sample, as wrenches may be late that are held or averaged"
        return ""

    def _unsteady(self, found: Finding, effect: Effect) -> str:
        wheels = self.held_out.rolling[0]
        far = abs(effect.lateness - found.effect.lateness) > _longest_step(self.fitted)
        if effect.lateness > 0 and (self.fitted.is_late or far):
            return ""  # it was found where no linear fit looks
        remembers = isinstance(effect, ForceEffect) and effect.memory_names(wheels)
        most = MOST_DRIFT_REMEMBERED if remembers else MOST_DRIFT
        return UNSTEADY if found.change > MOST_CHANGE or found.drift > most else ""

    def _outside(self, effect: Effect, score: float) -> str:
        follows, closed = self.fitted.follows(not effect.gate.passes), 2 * score * self.fitted.excess
        if follows is None or follows.foretold < LEAST_FORETOLD:
            return ""
        lasting = OUTSIDE_FLOOR if follows.is_of_the_floor else OUTSIDE
        enough = OUTSIDE_PASSING if effect.gate.passes else lasting
        if follows.foretold * self.fitted.misfit(follows.direction) <= enough * closed:
            return ""
        period = f" ({follows.period:.3g} {follows.unit})" if follows.period is not None else ""
        return f"the residual follows {follows.name}{period} better"

    def _unsure(self, effect: Effect, score: float) -> str:
        is_searched = any(effect.grids(self.fitted.cart.wheel_set))
        usual = effect.doubt * (ENOUGH_PASSING if effect.gate.passes else ENOUGH_SEARCHED if is_searched else ENOUGH)
        beside = BESIDE[effect.gate]
        if is_searched and any(one.lateness > 0 for one in self.fitted.added):
            beside = max(beside, BESIDE_LATE)
        enough = max(usual, min(beside * self.strongest, MOST_BESIDE))
        return f"log of the Bayes factor {score:.1f} is below {enough:g}" if score < enough else ""


def _abut(effect: Effect, other: Effect) -> bool:
    """Whether they are one thing at one place: the second is as well another form of the first, which is as likely on
    any part of a log, and moves a rollout but little."""
    if effect.gate is not Gate.INSIDE or type(effect) is not type(other):
        return False
    (x, right, y, top), (other_x, other_right, other_y, other_top) = effect.values[:4], other.values[:4]
    apart = max(x - other_right, other_x - right, y - other_top, other_y - top)
    return bool(apart < ABUTS)


def _longest_step(fitted: Fitted) -> float:
    """Between rows of the logs (s)."""
    return max((regression.step for regression in fitted.regressions), default=0.0)
