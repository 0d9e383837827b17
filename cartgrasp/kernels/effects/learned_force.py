"""`effects/learned_force.py`: parameters are the amplitudes; the memory, if any, is a way; the constants stand at the
places below, then the harmonics or the knots, and those along y."""

from __future__ import annotations

import math

from cartgrasp.frames import Array

from ..jit import compiled
from ..situation import EffectValues, KernelSituation, Parts, Twist
from ..smooth import smooth_ramp, smooth_sign, smooth_step

ON_FORWARD_FORCE, ON_LATERAL_FORCE, ON_YAW_MOMENT, ON_DRAG, ON_WORLD_FORCE, ON_VISCOUS_DRAG = range(6)
"""What a law acts on."""
OF_TIME, OF_TRAVELLED_DISTANCE, OF_HEADING, OF_SPEED, OF_YAW_RATE, OF_PLACE, OF_SINCE_REVERSAL = range(7)
"""What it is a function of."""
(
    I_ACTS_ON,
    I_VARIABLE,
    I_DIRECTION,
    I_LEVER,
    I_AHEAD,
    I_PERIOD,
    I_ROUNDING_X,
    I_ROUNDING_Y,
    I_REVERSAL_LENGTH,
    I_COUNT,
    I_FIRST,
) = range(11)
"""Where constants stand: a period of 0 for none; how far knots of x and of y are rounded; over which way a reversal is
told; how many knots of x there are, and where the first one is."""
ZERO_VECTOR = (0.0, 0.0, 0.0)


@compiled
def wrench(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    lever = own.constants[I_LEVER]
    unit, turned, braked = _unit(at, own.constants)
    value, by_pose, by_velocity, by_memory = _variable(at, own)
    force = slope = slope_y = 0.0
    for k in range(len(own.parameters)):
        share, by_value, by_y = _share(own.constants, k, value, at.pose[1])
        strength = own.parameters[k]
        force, slope, slope_y = force + strength * share, slope + strength * by_value, slope_y + strength * by_y
        for i in range(3):
            out.by_parameters[i, k] += unit[i] * share
    for i in range(3):
        out.value[i] += unit[i] * force
        out.by_pose[i, 1] += unit[i] * slope_y
        out.by_pose[i, 2] += turned[i] * force
        out.by_velocity[i, 0] += braked[i] * force
        out.by_velocity[i, 2] -= lever * braked[i] * force
        for j in range(3):
            out.by_pose[i, j] += unit[i] * slope * by_pose[j]
            out.by_velocity[i, j] += unit[i] * slope * by_velocity[j]
        if len(own.memory) > 0:
            out.by_memory[i, 0] += unit[i] * slope * by_memory


@compiled
def memory_rate(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    lever = own.constants[I_LEVER]
    speed, way = at.velocity[0] - lever * at.velocity[2], own.memory[0]
    rate, by_speed = speed, 1.0
    if own.constants[I_VARIABLE] == OF_SINCE_REVERSAL:
        turn = own.constants[I_REVERSAL_LENGTH]
        forward, bend = smooth_step(speed, at.smoothing_speed)
        below, below_slope = smooth_ramp(-way, turn)
        above, above_slope = smooth_ramp(way, turn)
        pull = (forward * below + (1.0 - forward) * above) / turn
        rate, by_speed = speed * (1.0 + pull), 1.0 + pull + speed * bend * (below - above) / turn
        out.by_memory[0, 0] += speed * ((1.0 - forward) * above_slope - forward * below_slope) / turn
    out.value[0] += rate
    out.by_velocity[0, 0] += by_speed
    out.by_velocity[0, 2] -= lever * by_speed


@compiled
def stiction(at: KernelSituation, own: EffectValues, columns: Array) -> int:
    """Fills the column of a law that is a drag, and returns 1; other laws have no column, and it returns 0."""
    if own.constants[I_ACTS_ON] != ON_DRAG:
        return 0
    lever = own.constants[I_LEVER]
    sign, _ = smooth_sign(at.velocity[0] - lever * at.velocity[2], at.smoothing_speed)
    value, _, _, _ = _variable(at, own)
    level = 0.0
    for k in range(len(own.parameters)):
        share, _, _ = _share(own.constants, k, value, at.pose[1])
        level += (1.0 - sign * sign) * own.parameters[k] * share
    columns[0, 0], columns[0, 2] = level, -lever * level
    return 1


@compiled
def _unit(at: KernelSituation, constants: Array) -> tuple[Twist, Twist, Twist]:
    """The wrench of one newton, and its partials by the heading and by the forward speed where it acts."""
    acts_on, lever, ahead = constants[I_ACTS_ON], constants[I_LEVER], constants[I_AHEAD]
    if acts_on == ON_LATERAL_FORCE:
        return (0.0, 1.0, ahead), ZERO_VECTOR, ZERO_VECTOR
    if acts_on == ON_YAW_MOMENT:
        return (0.0, 0.0, 1.0), ZERO_VECTOR, ZERO_VECTOR
    if acts_on == ON_WORLD_FORCE:
        x, y = math.cos(constants[I_DIRECTION] - at.pose[2]), math.sin(constants[I_DIRECTION] - at.pose[2])
        return (x, y, ahead * y), (y, -x, -ahead * x), ZERO_VECTOR
    if acts_on == ON_DRAG:
        sign, slope = smooth_sign(at.velocity[0] - lever * at.velocity[2], at.smoothing_speed)
        return (-sign, 0.0, sign * lever), ZERO_VECTOR, (-slope, 0.0, slope * lever)
    if acts_on == ON_VISCOUS_DRAG:
        speed = at.velocity[0] - lever * at.velocity[2]
        return (-speed, 0.0, speed * lever), ZERO_VECTOR, (-1.0, 0.0, lever)
    return (1.0, 0.0, -lever), ZERO_VECTOR, ZERO_VECTOR


@compiled
def _variable(at: KernelSituation, own: EffectValues) -> tuple[float, Twist, Twist, float]:
    """What the law is a function of, with partials by pose, velocity and memory; of places with knots along y, x."""
    c, of = own.constants, own.constants[I_VARIABLE]
    if of == OF_TRAVELLED_DISTANCE:
        return own.memory[0], ZERO_VECTOR, ZERO_VECTOR, 1.0
    if of == OF_SINCE_REVERSAL:
        sign, bend = smooth_sign(own.memory[0], c[I_REVERSAL_LENGTH])
        return own.memory[0] * sign, ZERO_VECTOR, ZERO_VECTOR, sign + own.memory[0] * bend
    if of == OF_HEADING:
        return at.pose[2], (0.0, 0.0, 1.0), ZERO_VECTOR, 0.0
    if of == OF_YAW_RATE:
        return at.velocity[2], ZERO_VECTOR, (0.0, 0.0, 1.0), 0.0
    if of == OF_SPEED:
        speed, slope = at.velocity[0] - c[I_LEVER] * at.velocity[2], 1.0
        if c[I_ACTS_ON] == ON_DRAG:
            sign, bend = smooth_sign(speed, at.smoothing_speed)
            speed, slope = speed * sign, sign + speed * bend
        return speed, ZERO_VECTOR, (slope, 0.0, -c[I_LEVER] * slope), 0.0
    if of == OF_PLACE:
        x, y = math.cos(c[I_DIRECTION]), math.sin(c[I_DIRECTION])
        if len(c) > I_FIRST + c[I_COUNT] + 1:
            x, y = 1.0, 0.0
        return x * at.pose[0] + y * at.pose[1], (x, y, 0.0), ZERO_VECTOR, 0.0
    return at.time, ZERO_VECTOR, ZERO_VECTOR, 0.0


@compiled
def _share(c: Array, k: int, x: float, y: float) -> tuple[float, float, float]:
    """What amplitude k counts for at a value of the variable, with its partials by it and by y."""
    n = int(c[I_COUNT])
    if c[I_PERIOD] > 0.0:
        pace = 2.0 * math.pi * c[I_FIRST + k // 2] / c[I_PERIOD]
        cosine, sine = math.cos(pace * x), math.sin(pace * x)
        return (sine, pace * cosine, 0.0) if k % 2 else (cosine, -pace * sine, 0.0)
    n_y = len(c) - I_FIRST - n
    along, slope = _hat(c[I_FIRST : I_FIRST + n], k // n_y, x, c[I_ROUNDING_X])
    across, slope_y = _hat(c[I_FIRST + n :], k % n_y, y, c[I_ROUNDING_Y])
    return along * across, slope * across, along * slope_y


@compiled
def _hat(knots: Array, k: int, x: float, width: float) -> tuple[float, float]:
    """1 at its knot, 0 at its neighbours, linear between, with rounded corners; and its derivative."""
    risen, rising = 1.0, 0.0
    if k > 0:
        risen, rising = _climb(knots[k - 1], knots[k], x, width)
    fallen, falling = 0.0, 0.0
    if k + 1 < len(knots):
        fallen, falling = _climb(knots[k], knots[k + 1], x, width)
    return risen - fallen, rising - falling


@compiled
def _climb(low: float, high: float, x: float, width: float) -> tuple[float, float]:
    """A ramp from 0 to 1 between two knots, and its derivative."""
    if x >= high + width:
        return 1.0, 0.0
    begun, begun_slope = smooth_ramp(x - low, width)
    ended, ended_slope = smooth_ramp(x - high, width)
    return (begun - ended) / (high - low), (begun_slope - ended_slope) / (high - low)
