"""What a pose and a velocity say of the motion and of the observed wrench (`disturbance/observer.py`). Beliefs are of
pose, nu and d (n = 3 + 2 k,)."""

from __future__ import annotations

import math

from cartgrasp.frames import Array
from cartgrasp.kernels.workspace import copy

from ..first_motion import MAX_TRACKING_GAP
from .correction import add_congruence, carved, eliminate, normalised_square, put, wrapped
from .free_directions import raised, to_free
from .jit import compiled, entry
from .observed_wrench import MAX_OBSERVER_STEP, Constants
from .relocalisation import (
    MAX_DRIFT_SPEED,
    MAX_RELOCALISATION_SPEED,
    MIN_MOVED_SOURCE_DURATION,
    MIN_RUN_DURATION,
    POSE_AGREEMENT_SIGMAS,
    RESTART_VELOCITY_STD,
    agrees,
)

SURPRISE_CHI2 = 20.5
"""Normalised square of pose and velocity from which a sample surprises: five numbers of white noise are beyond it once
in a thousand times."""
MAX_POSE = 1e9
MAX_PUSH_DOUBLINGS = 5
"""Times at most that the push which may have set in is taken to be twice as strong."""
MAX_PUSH_ACCELERATION = 30.0
"""m/s²: three times that of gravity."""
MAX_VELOCITY_AGE = 0.1
"""s for which a velocity that was as believed tells of poses without one."""
S_MOVED, S_AGREED, S_BELIEVED, S_LEFT_OUT = 3, 4, 5, 6
"""Entries of a `source` of poses (7,), after by how much it seems to have moved (3,): since when (inf: it has not);
when the velocity was last as believed; since when the pose is believed; and 1 while the velocity is left out."""


@entry
def see(
    c: Constants,
    belief: tuple[Array, Array],
    seen: tuple[Array, Array],
    surprises: tuple[int, float, float],
    source: Array,
    room: Array,
) -> int:
    """Takes in a pose (3,) and a velocity (3,) in {s}, `seen`, NaN where they are missing; `surprises` are how many
    samples in a row have surprised before, since when (s ago) they may have, and the time. Returns how many have by
    now, beginning anew with one that a push explains, or -1 where nothing is there. Each one more that the push does
    not explain speaks for one that is twice as strong. No push moves a cart whose velocity is as believed: then the
    source of poses has moved, and is believed again when that has stayed for as long as what is believed, 2 s at most;
    until then the velocity alone is taken in. Poses that go on to go elsewhere contradict the velocity, and so do those
    that are as believed while it jumps as no push makes it: it is left out until it is as believed again. `source` (7,)
    is changed."""
    (surprised, since, time), (pose, velocity) = surprises, seen
    (mean, covariance), k = belief, len(c.walk)
    n, most = len(mean), 3 + k
    residual, room = room[:most], room[most:]
    rows, room = room[:most], room[most:]
    R, room = carved(room, most, most)
    m = _measured(c, mean, pose, velocity, (residual, rows, R), room)
    if m == 0:
        return -1
    opened, room = carved(room, n, n)
    if m >= k and rows[m - k] == 3.0:
        _compare_velocity(c, belief, velocity, (rows[:m], residual[:m], R), (since, time), source, room)
        m -= k if source[S_LEFT_OUT] > 0.0 else 0
        if m == 0:
            return -1
    square = _square(covariance, (rows[:m], residual[:m], R), room)
    is_surprise, is_pose = square > SURPRISE_CHI2, m >= 3 and rows[2] == 2.0
    surprised = surprised + 1 if is_surprise else 0
    if is_pose and is_surprise and source[S_LEFT_OUT] == 0.0 and time - source[S_AGREED] < MAX_VELOCITY_AGE:
        if source[S_MOVED] > time:
            copy(residual[:3], source[:3])
            source[S_MOVED] = time
        if not _goes_on(c, residual, source, time):
            if m > 3:
                _update(mean, covariance, (rows[3:m], residual[3:m], R[3:m, 3:m]), room)
            return surprised
        if source[S_LEFT_OUT] == 0.0:
            _move(c, belief, pose, velocity, room)
            source[S_MOVED], source[S_BELIEVED] = math.inf, time
            return 0
        m = 3
        square = _square(covariance, (rows[:m], residual[:m], R), room)
    elif is_pose:
        source[S_MOVED] = math.inf
    if surprised > 1:
        put(covariance, opened)
        stronger = 2.0 ** min(surprised - 2, MAX_PUSH_DOUBLINGS)
        _open(c, (mean[3 + k :], stronger), max(surprised * MAX_OBSERVER_STEP, min(since, MAX_TRACKING_GAP)), opened)
        if _square(opened, (rows[:m], residual[:m], R), room) <= SURPRISE_CHI2:
            put(opened, covariance)
            surprised, square, source[S_BELIEVED] = 1, 0.0, time
    if square > SURPRISE_CHI2:
        _widen(covariance, rows[:m], square / SURPRISE_CHI2, R)
    _update(mean, covariance, (rows[:m], residual[:m], R), room)
    return surprised


# Many parameters: what a kernel is given, which takes no values with fields.
@compiled
def _compare_velocity(
    c: Constants,
    belief: tuple[Array, Array],
    velocity: Array,
    measured: tuple[Array, Array, Array],
    times: tuple[float, float],
    source: Array,
    room: Array,
) -> None:
    """Notes in `source` whether a velocity is as believed, and whether it is to be left out; `times`: since when (s
    ago) it may be otherwise, and now."""
    (mean, covariance), (rows, residual, R), (since, time) = belief, measured, times
    k, m = len(c.walk), len(rows)
    first = m - k
    nu, rest = room[:k], room[k:]
    for a in range(k):
        nu[a] = mean[3 + a] + residual[first + a]
    sideways = MAX_DRIFT_SPEED + POSE_AGREEMENT_SIGMAS * math.sqrt(c.velocity[0, 0] + c.velocity[1, 1])
    free = rows[first:], residual[first:], R[first:, first:]
    if _speed_beside(c, mean[2], nu, velocity, rest) < sideways and _square(covariance, free, rest) <= SURPRISE_CHI2:
        source[S_AGREED], source[S_LEFT_OUT] = time, 0.0
        return
    source[S_AGREED] = -math.inf
    jumps = _speed_beside(c, mean[2], mean[3 : 3 + k], velocity, rest) > MAX_PUSH_ACCELERATION * since
    if first == 3 and jumps and _square(covariance, (rows[:3], residual[:3], R), rest) <= SURPRISE_CHI2:
        source[S_LEFT_OUT] = 1.0


@compiled
def _speed_beside(c: Constants, heading: float, nu: Array, velocity: Array, room: Array) -> float:
    """How far (m/s) a velocity (3,) in {s} is from nu (k,)."""
    twist_b = room[:3]
    raised(c.basis, nu, twist_b)
    cosine, sine = math.cos(heading), math.sin(heading)
    x, y = cosine * twist_b[0] - sine * twist_b[1], sine * twist_b[0] + cosine * twist_b[1]
    return math.hypot(velocity[0] - x, velocity[1] - y)


@compiled
def _goes_on(c: Constants, off: Array, source: Array, time: float) -> bool:
    """Whether poses that are off by (3,), since their source seems to have moved, are to be believed by now: since it
    stays, or since they have gone as far again, as a cart may go, and the velocity is left out."""
    lasting, far = time - source[S_MOVED], max(math.hypot(source[0], source[1]), abs(source[2]))
    goes_elsewhere = lasting >= MIN_RUN_DURATION and not _is_near(c, off, source, far)
    if goes_elsewhere and _is_near(c, off, source, MAX_RELOCALISATION_SPEED * lasting):
        source[S_MOVED], source[S_AGREED], source[S_LEFT_OUT] = math.inf, -math.inf, 1.0
        return True
    if lasting <= min(source[S_MOVED] - source[S_BELIEVED], MIN_MOVED_SOURCE_DURATION):
        return False
    if _is_near(c, off, source, MAX_DRIFT_SPEED * lasting):
        return True
    copy(off[:3], source[:3])
    source[S_MOVED] = time
    return False


@compiled
def _is_near(c: Constants, off: Array, other: Array, most: float) -> bool:
    """Whether differences of poses are one another to within so many m or rad, and the noise of both."""
    apart = off[0] - other[0], off[1] - other[1], wrapped(off[2] - other[2])
    return agrees(apart, (c.pose[0, 0], c.pose[1, 1], c.pose[2, 2]), most)


@compiled
def _move(c: Constants, belief: tuple[Array, Array], pose: Array, velocity: Array, room: Array) -> None:
    """To a pose (3,), known as its source tells it; with the velocity (3,), if that is there, in its frame."""
    mean, covariance = belief
    n_moved, turned = 3, room[: 3 * len(c.walk)].reshape((len(c.walk), 3))
    for i in range(3):
        mean[i] = pose[i]
    if math.isfinite(velocity[0] + velocity[1] + velocity[2]):
        to_free(c.project, pose[2], turned)
        n_moved = 3 + len(c.walk)
        for a in range(len(c.walk)):
            mean[3 + a] = turned[a, 0] * velocity[0] + turned[a, 1] * velocity[1] + turned[a, 2] * velocity[2]
    for i in range(n_moved):
        covariance[i, :], covariance[:, i] = 0.0, 0.0
        covariance[i, i] = RESTART_VELOCITY_STD**2
    put(c.pose, covariance[:3, :3])


@compiled
def _widen(covariance: Array, rows: Array, scale: float, R: Array) -> None:
    """Changes the noise so that the residual's covariance is so many times what it is: an outlier may pull no harder
    than one at the limit, however little is known."""
    for p in range(len(rows)):
        for q in range(len(rows)):
            R[p, q] = scale * R[p, q] + (scale - 1.0) * covariance[int(rows[p]), int(rows[q])]


@compiled
def _open(c: Constants, push: tuple[Array, float], since: float, opened: Array) -> None:
    """Adds to a covariance what a push, so many times as strong as a usual one, may have done that set in at any moment
    of so many s, in place of the wrench (k,) that was believed, which may be over: it has gone on for a time of the
    moments since/2, since²/3 and, of the square, since⁴/5."""
    k, (wrench, stronger) = len(c.walk), push
    for a in range(k):
        change = stronger**2 * c.usual[a] + wrench[a] ** 2
        opened[3 + k + a, 3 + k + a] += change
        across = change / c.inertias[a] * since / 2.0
        opened[3 + a, 3 + k + a] += across
        opened[3 + k + a, 3 + a] += across
        rate = change / c.inertias[a] ** 2
        opened[3 + a, 3 + a] += rate * since**2 / 3.0
        linear, turning = c.project[a, 0] ** 2 + c.project[a, 1] ** 2, c.project[a, 2] ** 2
        moved = rate * since**4 / 20.0 / (linear + turning) ** 2
        for i in range(3):  # x and y alike, since nobody knows where it heads by then
            opened[i, i] += moved * (turning if i == 2 else linear)


@compiled
def _measured(
    c: Constants, mean: Array, pose: Array, velocity: Array, out: tuple[Array, Array, Array], room: Array
) -> int:
    """Residuals, the numbers of the mean that they are of, and their noise; returns how many there are."""
    (residual, rows, R), k, m = out, len(c.walk), 0
    for i in range(3):
        off = pose[i] - mean[i]
        off = wrapped(off) if i == 2 and math.isfinite(off) else off
        if abs(pose[i]) < MAX_POSE and abs(off) < MAX_POSE:
            residual[m], rows[m] = off, i
            m += 1
    n_pose = m
    turned, _ = carved(room, k, 3)
    to_free(c.project, mean[2], turned)
    for a in range(k):
        off = -mean[3 + a]
        for j in range(3):
            off += turned[a, j] * velocity[j]
        if abs(off) < MAX_POSE:
            residual[m], rows[m] = off, 3 + a
            m += 1
    for p in range(m):
        for q in range(m):
            i, j = int(rows[p]), int(rows[q])
            R[p, q] = 1e-12 if p == q else 0.0
            if p < n_pose and q < n_pose:
                R[p, q] += c.pose[i, j]
            elif p >= n_pose and q >= n_pose:
                for a in range(3):
                    for b in range(3):
                        R[p, q] += turned[i - 3, a] * c.velocity[a, b] * turned[j - 3, b]
    return m


@compiled
def _spread(covariance: Array, rows: Array, R: Array, S: Array) -> None:
    """The covariance (m, m) of residuals of those numbers of the mean, with the noise R."""
    for p in range(len(rows)):
        for q in range(len(rows)):
            S[p, q] = covariance[int(rows[p]), int(rows[q])] + R[p, q]


@compiled
def _square(covariance: Array, measured: tuple[Array, Array, Array], room: Array) -> float:
    """The residual's normalised square."""
    rows, residual, R = measured
    S, room = carved(room, len(rows), len(rows))
    _spread(covariance, rows, R, S)
    return normalised_square(residual, S, room)


@compiled
def _update(mean: Array, covariance: Array, measured: tuple[Array, Array, Array], room: Array) -> None:
    """(18)-(19) and Joseph's form."""
    (rows, residual, R), n = measured, len(mean)
    m = len(rows)
    S, room = carved(room, m, m)
    gain, room = carved(room, m, n)  # of which the columns are solved for
    _spread(covariance, rows, R, S)
    for p in range(m):
        copy(covariance[int(rows[p])], gain[p])
    eliminate(S, gain)
    keep, room = carved(room, n, n)
    total, room = carved(room, n, n)
    total[:] = 0.0
    for i in range(n):
        for j in range(n):
            keep[i, j] = 1.0 if i == j else 0.0
        for p in range(m):
            mean[i] += gain[p, i] * residual[p]
            keep[i, int(rows[p])] -= gain[p, i]
    add_congruence(keep, covariance, total, room)
    for i in range(n):
        for j in range(i + 1):
            value = total[i, j]
            for p in range(m):
                for q in range(m):
                    value += gain[p, i] * R[p, q] * gain[q, j]
            covariance[i, j] = covariance[j, i] = value
