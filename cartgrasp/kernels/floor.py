"""What the floor gives a cart, in the letters of `cartgrasp/floor_reaction.py`."""

from __future__ import annotations

from cartgrasp.frames import PLANAR, Array

from . import rigid_body
from .dynamics import Point, hold, lifted, mass_matrix, situation, solve, sum_effects
from .jit import compiled
from .situation import HIGH_ROWS, SWINGING_ROW
from .wheel_loads import fill_map
from .workspace import MEMORY_COLUMN, PHI_COLUMN, Workspace

ZERO_ACCELERATION = (0.0, 0.0, 0.0)


@compiled
def react(m: Workspace, point: Point, height: float, into: tuple[Array, Array, Array]) -> None:
    """`into`: room for f² + 3 f + 18 numbers; rows (n + 1, 7) over W with an offset behind it, of the wheels' loads and
    of the lateral force; and their partials by the parameters (p, n + 1, 7), if there is room for them."""
    (room, rows, slopes), n_free = into, m.basis.shape[1]
    twist = lifted(m.basis, point.state[3:])
    sum_effects(m, point, situation(m, point, twist))
    hold(m, m.phi_by_parameters[:0])
    first = n_free * n_free + 3 * n_free
    turned = room[n_free * n_free : first].reshape((n_free, 3))
    mobility, inertial = room[first : first + 9].reshape((3, 3)), room[first + 9 : first + 18].reshape((3, 3))
    _invert(m, room[: n_free * n_free].reshape((n_free, n_free)), turned)
    mass = mass_matrix(m)
    for i in range(3):
        for j in range(3):
            mobility[i, j] = 0.0
            for a in range(n_free):
                mobility[i, j] -= m.basis[i, a] * turned[a, j]
    for i in range(3):
        for j in range(3):
            inertial[i, j] = mass[i][0] * mobility[0, j] + mass[i][1] * mobility[1, j] + mass[i][2] * mobility[2, j]
    m.standing[:] = 1.0
    fill_map(m.wheels, m.standing, m.gravity, m.carried)
    rigid, wheels, lateral = rigid_body.regressor(twist, ZERO_ACCELERATION), rows[: len(m.wheels)], rows[len(m.wheels)]
    rows[:] = 0.0
    across = -m.basis[1, 0], m.basis[0, 0]  # the first free velocity is along the wheels
    for k in range(len(wheels)):
        share = m.carried[k]
        wheels[k, 2], wheels[k, 3], wheels[k, 4] = -share[0] / m.gravity, -share[2] / m.gravity, share[1] / m.gravity
        wheels[k, 6] = share[0] * m.phi[0] + share[1] * m.phi[1] + share[2] * m.phi[2]
    for i in range(2):
        offset = _bias(rigid[i], m.phi)
        for j in range(3):
            push = m.wrench[j, 0] - _bias(rigid[j], m.phi)
            offset += inertial[i, j] * push
            _feel(m, wheels, height, (i, PLANAR[j]), inertial[i, j])
            constraint = across[i] * (inertial[i, j] - 1.0 if i == j else inertial[i, j])
            lateral[PLANAR[j]] += constraint
            lateral[6] += constraint * push
        _feel(m, wheels, height, (i, 6), offset - m.wrench[HIGH_ROWS[i], 0])
    for q in range(len(slopes)):
        _slope(m, (mobility, inertial), rigid, (q, height), slopes[q])


@compiled
def _slope(
    m: Workspace,
    maps: tuple[Array, Array],
    rigid: tuple[rigid_body.Row, rigid_body.Row, rigid_body.Row],
    by: tuple[int, float],
    rows: Array,
) -> None:
    """The partials (n + 1, 7) of the rows by one parameter; `by`: which, and the CoM's height."""
    (mobility, inertial), (q, height) = maps, by
    own, first = m.phi_by_parameters[:, q], MEMORY_COLUMN + len(m.memory_rate)
    wheels, lateral = rows[: len(m.wheels)], rows[len(m.wheels)]
    across = -m.basis[1, 0], m.basis[0, 0]
    mass = rigid_body.mass_matrix(own)
    swung = m.wrench[SWINGING_ROW, first + q]
    rows[:] = 0.0
    for k in range(len(wheels)):
        share = m.carried[k]
        wheels[k, 6] = share[0] * own[0] + share[1] * own[1] + share[2] * own[2]
    for c in range(3):  # of dM G, the row c, and what it makes of what pushes
        bias, felt = _bias(rigid[c], own), m.wrench[c, first + q]
        for d in range(4):
            felt += m.wrench[c, PHI_COLUMN + d] * own[d]
        changed = bias
        for j in range(3):
            along = mass[c][0] * mobility[0, j] + mass[c][1] * mobility[1, j] + mass[c][2] * mobility[2, j]
            if c == 0:
                along -= swung * mobility[0, j]
            changed += along * (m.wrench[j, 0] - _bias(rigid[j], m.phi))
            for i in range(2):
                rate = (1.0 - inertial[i, c] if i == c else -inertial[i, c]) * along
                _feel(m, wheels, height, (i, PLANAR[j]), rate)
                lateral[PLANAR[j]] += across[i] * rate
        for i in range(2):
            kept = 1.0 - inertial[i, c] if i == c else -inertial[i, c]
            offset = kept * changed + inertial[i, c] * felt
            _feel(m, wheels, height, (i, 6), offset)
            lateral[6] += across[i] * (offset - felt if i == c else offset)
    for i in range(2):
        high = m.wrench[HIGH_ROWS[i], first + q]
        for d in range(4):
            high += m.wrench[HIGH_ROWS[i], PHI_COLUMN + d] * own[d]
        _feel(m, wheels, height, (i, 6), -high)


@compiled
def _feel(m: Workspace, wheels: Array, height: float, at: tuple[int, int], momentum: float) -> None:
    """Adds to the loads, in a column, what a change of the momentum along x (0) or y (1) takes from or gives them."""
    axis, column = at
    for k in range(len(wheels)):
        wheels[k, column] -= height * m.carried[k, 1 + axis] / m.gravity * momentum


@compiled
def _invert(m: Workspace, mass: Array, turned: Array) -> None:
    """-(Sᵀ M S)⁻¹ Sᵀ (f, 3) into `turned`; `mass` (f, f) is room."""
    own = mass_matrix(m)
    for a in range(len(mass)):
        for i in range(3):
            turned[a, i] = m.basis[i, a]
        for b in range(len(mass)):
            mass[a, b] = 0.0
            for i in range(3):
                for j in range(3):
                    mass[a, b] += m.basis[i, a] * own[i][j] * m.basis[j, b]
    solve(mass, turned)


@compiled
def _bias(row: rigid_body.Row, phi: Array) -> float:
    return float(row[0] * phi[0] + row[1] * phi[1] + row[2] * phi[2] + row[3] * phi[3])
