"""Which parameters are estimated: all that are in a file, but for those that only fits of logs can learn."""

import pytest

from cartgrasp.effects import CasterRealignment, RollingResistance, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation import Prior
from estimation.discrepancy.search.model import structure_prior
from estimation.prior import report_names

CASTERS = "caster_realignment"


@pytest.mark.parametrize(
    ("casters", "online"),
    [
        (CasterRealignment(), {"swivel_torque"}),
        (CasterRealignment(0.1, scrub_torque=0.02), {"swivel_torque", "scrub_torque"}),
        (CasterRealignment(0.1, smoothing_rate=0.05), {"swivel_torque"}),
    ],
)
def test_filters_learn_what_is_optional_where_it_is_there(casters, online):
    cart = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), effects=(ViscousDrag(), RollingResistance(), casters))
    names = report_names(cart)
    others = {*names[:4], "viscous_drag.linear", "viscous_drag.angular", "rolling_resistance.coefficient"}
    assert {names[i] for i in Prior().free(cart)} == others | {f"{CASTERS}.{name}" for name in online}


def test_fits_of_logs_learn_it_anyway_and_are_unsure_where_a_file_says_nothing():
    silent, told = (
        structure_prior(cart, cart)
        for casters in (CasterRealignment(0.1), CasterRealignment(0.1, scrub_torque=0.02, smoothing_rate=0.1))
        for cart in [CartModel(Inertia(24.0, (0.3, 0.0), 2.0), effects=(casters,))]
    )
    assert silent.free.tolist() == told.free.tolist() == [True] * 4 + [True, False, False, True, True]
    assert (silent.std[[7, 8]] > 10 * told.std[[7, 8]]).all()
