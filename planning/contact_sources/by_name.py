"""The source of contacts of a name."""

from __future__ import annotations

from collections.abc import Sequence

from cartgrasp.arms import Arm
from cartgrasp.checks import check_known
from cartgrasp.model import CartModel
from cartgrasp.roles import ContactSource, ReferencePath

from ..control.hand import RegraspTimes
from ..planner import WrenchPlanner
from ..tick.terms import possible_contacts
from .by_time import FixedContacts, PeriodicContacts
from .choosing import Choosing
from .least_effort import LeastEffortContacts
from .scheduled import ScheduledContacts
from .strategies import LEAST_EFFORT, PERIODIC, SCHEDULE, STRATEGIES, TEACH
from .teaching import TeachingContacts


def contact_source(
    way: str, cart: CartModel, arms: Sequence[Arm], reference: ReferencePath, choosing: Choosing, regrasp: RegraspTimes
) -> ContactSource:
    """The source called `way`, for a cart that is first believed to be `cart`. Contacts are judged over seconds, so
    rates of the arms don't count; candidates that an arm can't hold are left out."""
    check_known("contacts", [way], STRATEGIES)
    arms = [arm.without_rate().holding_at(possible_contacts(arm)) for arm in arms]
    if way == PERIODIC:
        return PeriodicContacts(arms, choosing.every, choosing.min_hand_distance)
    if way == LEAST_EFFORT:
        planner = WrenchPlanner(cart, arms, min_hand_distance=choosing.min_hand_distance)
        return LeastEffortContacts(planner, arms, choosing.every)
    if way == TEACH:
        return TeachingContacts(cart, arms, reference, choosing, regrasp)
    if way == SCHEDULE:
        return ScheduledContacts(cart, arms, reference, choosing, regrasp)
    return FixedContacts(arms, choosing.min_hand_distance)
