"""All that acts on a true cart, as one flat tuple of floats: what compiled functions take.

{b} has its origin in the middle of the fixed wheels' axle. Wheels 0 and 1 are fixed (left, right), 2 and 3 are
casters. Every default but the first ones means absent.
"""

from __future__ import annotations

from typing import NamedTuple

GRAVITY = 9.81


class World(NamedTuple):
    mass: float
    com_x: float
    com_y: float
    inertia: float  # kg m², about the CoM
    com_height: float
    half_track: float  # m, of fixed wheels
    caster_x: float
    caster_y: float
    trail: float
    linear: float = 0.0  # N s/m
    angular: float = 0.0  # N m s/rad
    rolling: float = 0.0  # drag over load
    width: float = 0.008  # m/s, of tanh
    bristle: float = 0.0  # m, deflection at which a LuGre bristle slides; 0: tanh
    stiction: float = 0.0  # N, fades exponentially
    stiction_speed: float = 0.05
    quadratic: float = 0.0  # N s²/m²
    forward: float = 0.0  # N s/m
    backward: float = 0.0
    grade_x: float = 0.0
    grade_y: float = 0.0
    bow: float = 0.0  # share by which the grade waves over the floor
    patch_x_min: float = 0.0
    patch_x_max: float = 0.0
    patch_y_min: float = 0.0
    patch_y_max: float = 0.0
    patch_rolling: float = 0.0
    patch_ramp: float = 0.03  # m, half of the width of its edge
    swivel: float = 0.0  # N m, at a caster with mean load
    scrub: float = 0.0  # N m, of its tyre on the floor
    brake_left: float = 0.0  # N
    brake_right: float = 0.0
    toe: float = 0.0  # rad
    cornering: float = 0.0  # N/rad, of the axle; 0: no slip
    relaxation: float = 0.05  # m
    load_time: float = 0.0
    load_mass: float = 0.0
    load_x: float = 0.0
    load_y: float = 0.0
    load_ramp: float = 0.1  # s, while it is put on
    bob_mass: float = 0.0  # a part of `mass`, at com_x when it hangs still
    bob_length: float = 0.2
    bob_damping: float = 0.0  # of critical
    push_start: float = 0.0
    push_duration: float = 1.0
    push_force: float = 0.0
    push_moment: float = 0.0
    push_half_sine: float = 0.0
    flat_force: float = 0.0  # N, at wheel 0
    flat_period: float = 0.4  # m
    wind_x: float = 0.0  # N, in {s}, after `wind_time`
    wind_y: float = 0.0
    wind_time: float = 60.0
    quake: float = 0.0  # m/s²
    quake_frequency: float = 0.5
    quake_heading: float = 0.0
    rail: float = 0.0  # 1: wheels and casters are held straight, so there is no yaw either
    lean_mass: float = 0.0  # a part of `mass`: a rider, whose CoM is the cart's while nobody pushes
    lean_per_force: float = 0.0  # m/N, how far it leans ahead under a steady push
    lean_frequency: float = 1.0  # Hz
    lean_damping: float = 0.7  # of critical
    law: float = 0.0  # kind of a force without a name (`foreign.py`), its size and two numbers
    law_size: float = 0.0
    law_a: float = 1.0
    law_b: float = 0.0


X, Y, THETA, U, W, R, CASTER, BOB, BOB_RATE, BRISTLE, SIDE, WAY = 0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 14, 15
LEAN, LEAN_RATE, SIZE = 16, 17, 18
"""Places in a state: pose, velocity in {b}, two caster headings in {b}, the bob's angle and rate, four bristles,
sideways deflection of the tyres, way rolled by wheel 0, how far ahead the rider leans and its rate."""
