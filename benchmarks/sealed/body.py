"""What acts on the body as a whole, and how its masses answer: Newton and Euler for each mass, then summed."""

from __future__ import annotations

import math

import numpy as np

from .compiling import compiled
from .foreign import foreign_wrench
from .wheels import wheel_forces
from .world import BOB, BOB_RATE, GRAVITY, LEAN, LEAN_RATE, THETA, R, U, W, X, Y


@compiled
def add_mass(mass, x, y, state, matrix, bias):
    """A mass fixed at (x, y) in {b}: matrix @ acceleration + bias is the wrench that it needs."""
    u, w, r = state[U], state[W], state[R]
    ax, ay = -w * r - x * r * r, u * r - y * r * r
    matrix[0, 0] += mass
    matrix[1, 1] += mass
    matrix[2, 2] += mass * (x * x + y * y)
    matrix[0, 2] -= mass * y
    matrix[2, 0] -= mass * y
    matrix[1, 2] += mass * x
    matrix[2, 1] += mass * x
    bias[0] += mass * ax
    bias[1] += mass * ay
    bias[2] += mass * (x * ay - y * ax)


@compiled
def add_bob(state, matrix, bias, world):
    """A pendulum that hangs over (com_x, 0) and swings along {b}'s x: its angle obeys
    L phi'' = -g sin phi - a cos phi - 2 zeta omega L phi', a that of the place below it."""
    m, length, phi, rate = world.bob_mass, world.bob_length, state[BOB], state[BOB_RATE]
    u, w, r = state[U], state[W], state[R]
    sine, cosine = math.sin(phi), math.cos(phi)
    damping = 2.0 * world.bob_damping * math.sqrt(GRAVITY / length) * length * rate
    x, x_rate = world.com_x + length * sine, length * rate * cosine
    pull = GRAVITY * sine * cosine + damping * cosine + length * rate * rate * sine
    matrix[0, 0] += m * sine * sine
    bias[0] += m * (sine * sine * (-w * r - x * r * r) - pull)
    across = u * r + 2.0 * r * x_rate
    matrix[1, 1] += m
    matrix[1, 2] += m * x
    matrix[2, 1] += m * x
    matrix[2, 2] += m * x * x
    bias[1] += m * across
    bias[2] += m * x * across


@compiled
def lean_acceleration(force, state, world):
    """Of the rider against the cart: a spring and a damper draw it to where the push `force` makes it lean."""
    own = 2.0 * math.pi * world.lean_frequency
    return own * own * (world.lean_per_force * force - state[LEAN]) - 2.0 * world.lean_damping * own * state[LEAN_RATE]


@compiled
def add_rider(leaning, state, matrix, bias, world):
    """A mass that stands at the CoM, but for what it leans ahead, and is accelerated against the cart by `leaning`."""
    m, x, y = world.lean_mass, world.com_x + state[LEAN], world.com_y
    add_mass(m, x, y, state, matrix, bias)
    across = 2.0 * m * state[R] * state[LEAN_RATE]
    bias[0] += m * leaning
    bias[1] += across
    bias[2] += x * across - y * m * leaning


@compiled
def bob_acceleration(state, acceleration, world):
    length, phi, rate = world.bob_length, state[BOB], state[BOB_RATE]
    x, r = world.com_x + length * math.sin(phi), state[R]
    a = acceleration[0] - state[W] * r - x * r * r
    damping = 2.0 * world.bob_damping * math.sqrt(GRAVITY / length) * rate
    return -(GRAVITY * math.sin(phi) + a * math.cos(phi)) / length - damping


@compiled
def load_at(time, world):
    return world.load_mass * min(max((time - world.load_time) / world.load_ramp, 0.0), 1.0)


@compiled
def field_acceleration(time, state, world):
    """Of gravity and of a shaking floor, in {s}: it pulls at every mass."""
    wave_x = 1.0 + world.bow * math.sin(0.7 * state[X])
    wave_y = 1.0 + world.bow * math.sin(0.7 * state[Y])
    shake = world.quake * math.sin(2.0 * math.pi * world.quake_frequency * time)
    ax = -GRAVITY * math.sin(math.atan(world.grade_x * wave_x)) + shake * math.cos(world.quake_heading)
    ay = -GRAVITY * math.sin(math.atan(world.grade_y * wave_y)) + shake * math.sin(world.quake_heading)
    return ax, ay


@compiled
def air_and_hands(time, state, world):
    """Drags of the whole cart, wind and a push, at {b}'s origin."""
    u, w, r = state[U], state[W], state[R]
    fx, fy, tau = -world.linear * u, -world.linear * w, -world.angular * r
    ahead = min(max(0.5 + u / 0.06, 0.0), 1.0)
    fx -= (world.forward * ahead + world.backward * (1.0 - ahead)) * u
    if world.quadratic > 0.0:
        vx, vy = u - world.com_y * r, w + world.com_x * r
        gust = -world.quadratic * math.sqrt(vx * vx + vy * vy)
        fx, fy, tau = fx + gust * vx, fy + gust * vy, tau + gust * (world.com_x * vy - world.com_y * vx)
    if world.wind_x != 0.0 or world.wind_y != 0.0:
        grown = time / world.wind_time * (1.0 + 0.3 * math.sin(0.9 * time) + 0.2 * math.sin(2.3 * time + 1.0))
        cosine, sine = math.cos(state[THETA]), math.sin(state[THETA])
        wx = grown * (cosine * world.wind_x + sine * world.wind_y)
        wy = grown * (cosine * world.wind_y - sine * world.wind_x)
        fx, fy, tau = fx + wx, fy + wy, tau + 0.5 * world.caster_x * wy
    since = (time - world.push_start) / world.push_duration
    if world.push_force != 0.0 and 0.0 <= since < 1.0:
        shape = math.sin(math.pi * since) if world.push_half_sine > 0.0 else 1.0
        fx, tau = fx + shape * world.push_force, tau + shape * world.push_moment
    if world.law > 0.0:
        gx, gy, turn = foreign_wrench(time, state, world)
        fx, fy, tau = fx + gx, fy + gy, tau + turn
    return fx, fy, tau


@compiled
def find_rate(time, state, wrench, world, rate):
    """Writes the rate of the state. `wrench` is (fx, fy, tau, fz, pitch): of all arms at {b}'s origin, their
    force upwards, and their moment that presses the front down."""
    rate[:] = 0.0
    cosine, sine = math.cos(state[THETA]), math.sin(state[THETA])
    rate[X] = cosine * state[U] - sine * state[W]
    rate[Y] = sine * state[U] + cosine * state[W]
    rate[THETA] = state[R]
    load, bob, rider = load_at(time, world), world.bob_mass, world.lean_mass
    mass = world.mass + load
    moment_x = world.mass * world.com_x + load * world.load_x
    moment_y = world.mass * world.com_y + load * world.load_y
    matrix, bias = np.zeros((3, 3)), np.zeros(3)
    rigid = world.mass - bob - rider
    rigid_x, rigid_y = world.com_x, (world.mass - rider) * world.com_y / rigid
    add_mass(rigid, rigid_x, rigid_y, state, matrix, bias)
    spread = bob * world.com_y**2 + rigid * (rigid_y - world.com_y) ** 2
    matrix[2, 2] += world.inertia - spread
    if load != 0.0:
        add_mass(load, world.load_x, world.load_y, state, matrix, bias)
    if bob > 0.0:
        add_bob(state, matrix, bias, world)
    if rider > 0.0:
        leaning = lean_acceleration(wrench[0], state, world)
        rate[LEAN], rate[LEAN_RATE] = state[LEAN_RATE], leaning
        moment_x += rider * state[LEAN]
        add_rider(leaning, state, matrix, bias, world)
    weight = mass * GRAVITY - wrench[3]
    x = (moment_x * GRAVITY + wrench[4]) / weight
    floor = wheel_forces(weight, x, moment_y * GRAVITY / weight, state, rate, world)
    body = air_and_hands(time, state, world)
    ax, ay = field_acceleration(time, state, world)
    gx, gy = cosine * ax + sine * ay, cosine * ay - sine * ax
    force = np.empty(3)
    force[0] = wrench[0] + floor[0] + body[0] + mass * gx - bias[0]
    force[1] = wrench[1] + floor[1] + body[1] + mass * gy - bias[1]
    force[2] = wrench[2] + floor[2] + body[2] + moment_x * gy - moment_y * gx - bias[2]
    rate[U], rate[W], rate[R] = accelerate(matrix, force, world)
    rate[BOB] = state[BOB_RATE]
    if bob > 0.0:
        rate[BOB_RATE] = bob_acceleration(state, rate[U:], world)


@compiled
def accelerate(matrix, force, world):
    """(u', w', r'), along the rolling direction of wheels that don't slip, or along a rail."""
    if world.cornering > 0.0:
        p, q = matrix[0, 2] / matrix[0, 0], matrix[1, 2] / matrix[1, 1]
        turning = force[2] - p * force[0] - q * force[1]
        turn = turning / (matrix[2, 2] - p * matrix[0, 2] - q * matrix[1, 2])
        return force[0] / matrix[0, 0] - p * turn, force[1] / matrix[1, 1] - q * turn, turn
    if world.rail > 0.0:
        return force[0] / matrix[0, 0], 0.0, 0.0
    ex, ey = math.cos(world.toe), math.sin(world.toe)
    a = ex * ex * matrix[0, 0] + 2.0 * ex * ey * matrix[0, 1] + ey * ey * matrix[1, 1]
    b = ex * matrix[0, 2] + ey * matrix[1, 2]
    c = matrix[2, 2]
    along = ex * force[0] + ey * force[1]
    determinant = a * c - b * b
    forward = (c * along - b * force[2]) / determinant
    return ex * forward, ey * forward, (a * force[2] - b * along) / determinant
