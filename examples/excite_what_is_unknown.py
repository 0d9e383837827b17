"""Hold and weave so as to learn what is known least, for a stated extra effort.

On a straight line at constant speed nothing can be learned about the load, however the contacts are switched. A weave
of 3 cm to either side teaches all of it, and where the hands hold says how far the sensors' noise hides it.
"""

import numpy as np

import cartgrasp as cg
from cartgrasp import WrenchNoise
from cartgrasp.effects import ViscousDrag
from planning import Allowance, ExcitationChooser, PathReference, pause, speed_change

cart = cg.CartModel(cg.Inertia(20.0, (-0.4, 0.0), 2.0), effects=(ViscousDrag(3.0, 1.2),))
places = [(-0.9, 0.2, 1.0), (-0.45, 0.3, 0.8), (0.0, 0.3, 0.8)]
arms = [cg.Arm("left", places), cg.Arm("right", [(x, -y, z) for x, y, z in places])]
path = PathReference((*speed_change(0.6), *pause(4.0), *speed_change(-0.6)))
known = np.diag(1.0 / np.array([8.0, 4.0, 4.0, 3.0, 1e-3, 1e-3]) ** 2)  # standard deviations of phi and of both drags
cruise = (1.2, 5.2)  # s

allowances = (Allowance(30.0, 0.0), Allowance(10.0, 0.03), Allowance(100.0, 0.03))
for allowance in allowances:
    found = ExcitationChooser(cart, arms, WrenchNoise(1.0, 0.05), allowance).choose(path, cruise, known)
    spent = found.effort - found.least_effort
    print(f"allowed {allowance.effort:g} N² and {100 * allowance.offset:g} cm: spent {spent:.1f} N²")
    print(f"  sd of the least known direction {found.before:.3f} -> {found.after:.3f}, best of {found.tried} ways")
    print("  hold", ", ".join(f"{name} at x = {point[0]:g}" for name, point in found.contacts.items()))
    if allowance is allowances[0]:
        nothing = found

assert np.isclose(nothing.after, nothing.before)
assert found.after < 0.1 * found.before
assert found.effort <= found.least_effort + 100.0 + 1e-6
assert found.internal_force < 1e-9
