"""A closed loop by hand: plan, push, sense, learn. The cart weighs 24 kg, the first guess is 18 kg."""

from functools import partial
from pathlib import Path

import cartgrasp as cg
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from estimation import CartFilter, FilterNoise
from planning import PathReference, WrenchPlanner, build_tracker, chain, pause, speed_change, turn

truth = cg.load_cart(Path(__file__).parent / "cart.yaml")
guess = truth.with_inertia(cg.Inertia(18.0, (0.25, 0.05), 1.5))
holding = partial(cg.Arm, force_limit=(80.0, 60.0, 40.0), moment_limit=(10.0, 10.0, 10.0))
arms = [holding("left", [(-0.25, 0.2, 1.0)]), holding("right", [(-0.25, -0.2, 1.0)])]

path = PathReference(chain(speed_change(0.6), turn(1.2, 0.4), pause(0.5), turn(-1.2, 0.4), speed_change(-0.6)))
plant, sensors = ModelPlant(truth), Sensors(truth, SensorNoise(force=0.5, moment=0.02), seed=1)
planner, tracker = WrenchPlanner(guess, arms), build_tracker(truth.constraints)
cart_filter = CartFilter(guess, ["left", "right"], noise=FilterNoise(force=0.5, moment=0.02))

for _ in range(int(path.duration / 0.01)):
    estimate = cart_filter.update(sensors.motion(plant.time, plant.motion))
    wrench = tracker.wrench_b(path.at(plant.time), estimate.motion, estimate.cart())
    push = planner.plan_or_hold(wrench).contact_wrenches
    cart_filter.update(sensors.wrenches(plant.time, push))
    plant.step(push, 0.01)

for name, parameter in estimate.parameters.items():
    print(f"{name:22s} {parameter.value:7.3f} ± {parameter.std:.3f} {parameter.unit}  taught: {parameter.identifiable}")
mass = estimate.parameters["mass"]
print(f"the truth is {truth.inertia.mass} kg")
assert mass.identifiable
assert abs(mass.value - 24.0) < 0.05 * 24.0
