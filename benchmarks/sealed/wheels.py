"""What the floor does to each wheel: loads, rolling friction, casters, tyres."""

from __future__ import annotations

import math

from .compiling import compiled
from .world import BRISTLE, CASTER, SIDE, THETA, WAY, R, U, W, X, Y

BRISTLE_TIME = 0.02
"""s: damping over stiffness of a bristle."""
SWIVEL_RATE = 0.15
"""rad/s, of tanh."""
GRIP = 0.9
CARCASS = 60.0
"""N s/m, damping of the tyres' deflection sideways."""


@compiled
def loads(weight, x, y, world):
    """Of four wheels (N): axles by the lever along x, sides of both axles shifted in the same proportion."""
    front = weight * x / world.caster_x
    front = min(max(front, 0.0), weight)
    rear = weight - front
    shift = weight * y / (world.half_track * rear + world.caster_y * front)
    shift = min(max(shift, -1.0), 1.0)
    left, right = 0.5 * (1.0 + shift), 0.5 * (1.0 - shift)
    return rear * left, rear * right, front * left, front * right


@compiled
def ramp(depth, half_width):
    return min(max(0.5 + 0.5 * depth / half_width, 0.0), 1.0)


@compiled
def on_patch(x, y, world):
    """How much of a wheel at (x, y) in {s} is on the carpet, 0 to 1."""
    w = world.patch_ramp
    along = ramp(x - world.patch_x_min, w) * ramp(world.patch_x_max - x, w)
    return along * ramp(y - world.patch_y_min, w) * ramp(world.patch_y_max - y, w)


@compiled
def rolling_drag(i, speed, load, weight, place, state, rate, world):
    """Force against rolling of wheel i at `place` in {s}; bristles' rates are written to `rate`."""
    brake = world.brake_left if i == 0 else (world.brake_right if i == 1 else 0.0)
    level = world.rolling * load + brake
    if world.patch_rolling > 0.0:
        level += world.patch_rolling * on_patch(place[0], place[1], world) * load
    if world.stiction > 0.0:
        level += world.stiction * load / weight * math.exp(-abs(speed) / world.stiction_speed)
    if world.bristle > 0.0:
        z = state[BRISTLE + i]
        stretching = speed - abs(speed) / world.bristle * z
        rate[BRISTLE + i] = stretching
        return -level * (z + BRISTLE_TIME * stretching) / world.bristle
    return -level * math.tanh(speed / world.width)


@compiled
def wheel_forces(weight, x, y, state, rate, world):
    """Wrench of the floor at {b}'s origin, by wheels under `weight` at (x, y) in {b}."""
    u, w, r = state[U], state[W], state[R]
    load = loads(weight, x, y, world)
    cosine, sine = math.cos(state[THETA]), math.sin(state[THETA])
    fx, fy, tau = 0.0, 0.0, 0.0
    ex, ey = math.cos(world.toe), math.sin(world.toe)
    for i in range(2):
        side = world.half_track if i == 0 else -world.half_track
        px, py = -ey * side, ex * side
        speed = (u - py * r) * ex + (w + px * r) * ey
        place = (state[X] + cosine * px - sine * py, state[Y] + sine * px + cosine * py)
        drag = rolling_drag(i, speed, load[i], weight, place, state, rate, world)
        if i == 0:
            rate[WAY] = speed
            if world.flat_force != 0.0:
                drag -= flat_spot(state[WAY], world)
        fx, fy, tau = fx + drag * ex, fy + drag * ey, tau + (px * ey - py * ex) * drag
    if world.cornering > 0.0:
        sliding = -ey * u + ex * w
        along = abs(ex * u + ey * w)
        most = GRIP * (load[0] + load[1])
        stiffness = world.cornering / world.relaxation
        held = most * math.tanh(stiffness * state[SIDE] / most) if most > 0.0 else 0.0  # pushed on its nose
        rate[SIDE] = sliding - along / world.relaxation * state[SIDE]
        push = -held - CARCASS * rate[SIDE]
        fx, fy = fx - push * ey, fy + push * ex
    for k in range(2):
        i = 2 + k
        px, py = world.caster_x, world.caster_y * (1 - 2 * k)
        hx, hy = math.cos(state[CASTER + k]), math.sin(state[CASTER + k])
        vx, vy = u - py * r, w + px * r
        turning = 0.0 if world.rail > 0.0 else (vy * hx - vx * hy) / world.trail - r
        rate[CASTER + k] = turning
        qx, qy = px - world.trail * hx, py - world.trail * hy
        place = (state[X] + cosine * qx - sine * qy, state[Y] + sine * qx + cosine * qy)
        along = rolling_drag(i, vx * hx + vy * hy, load[i], weight, place, state, rate, world)
        share = 4.0 * load[i] / weight
        swivel = world.swivel * share * math.tanh(turning / SWIVEL_RATE)
        scrub = world.scrub * share * math.tanh((turning + r) / SWIVEL_RATE)
        across = -(swivel + scrub) / world.trail
        gx, gy = along * hx - across * hy, along * hy + across * hx
        fx, fy, tau = fx + gx, fy + gy, tau + qx * gy - qy * gx - scrub
    return fx, fy, tau


@compiled
def flat_spot(way, world):
    """Against the wheel as it climbs the edge of its flat, with it as it falls: a fifth of a turn."""
    phase = (way / world.flat_period) % 1.0
    return world.flat_force * math.sin(2.0 * math.pi * phase / 0.2) if phase < 0.2 else 0.0
