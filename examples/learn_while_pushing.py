"""A controller in its loop: plan, push, sense, learn. The cart weighs 24 kg, the first guess is 18 kg."""

from functools import partial
from pathlib import Path

import cartgrasp as cg
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from estimation import CartFilter, FilterNoise
from planning import Controller, PathReference, chain, pause, speed_change, turn

truth = cg.load_cart(Path(__file__).parent / "cart.yaml")
guess = truth.with_inertia(cg.Inertia(18.0, (0.25, 0.05), 1.5))
holding = partial(cg.Arm, force_limit=(80.0, 60.0, 40.0), moment_limit=(10.0, 10.0, 10.0))
arms = [holding("left", [(-0.25, 0.2, 1.0)]), holding("right", [(-0.25, -0.2, 1.0)])]

path = PathReference(chain(speed_change(0.6), turn(1.2, 0.4), pause(0.5), turn(-1.2, 0.4), speed_change(-0.6)))
plant, sensors = ModelPlant(truth), Sensors(truth, SensorNoise(force=0.5, moment=0.02), seed=1)
cart_filter = CartFilter(guess, ["left", "right"], noise=FilterNoise(force=0.5, moment=0.02))
controller = Controller(guess, arms, path, estimator=cart_filter, period=0.01)

while plant.time < path.duration:
    step = controller.step(sensors.motion(plant.time, plant.motion))
    estimate = controller.observe(sensors.wrenches(plant.time, step.given))
    plant.step(step.given, controller.period)

for name, parameter in estimate.parameters.items():
    print(f"{name:22s} {parameter.value:7.3f} ± {parameter.std:.3f} {parameter.unit}  taught: {parameter.identifiable}")
mass = estimate.parameters["mass"]
print(f"the truth is {truth.inertia.mass} kg")
assert mass.identifiable
assert abs(mass.value - 24.0) < 0.05 * 24.0
