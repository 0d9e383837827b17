"""What the floor gives a cart, in the letters of `cartgrasp/floor_reaction.py`."""

from __future__ import annotations

from cartgrasp.frames import PLANAR, Array

from . import rigid_body
from .dynamics import Point, hold, lifted, mass_matrix, situation, solve, sum_effects
from .jit import compiled
from .wheel_loads import fill_map
from .workspace import Workspace

STILL = (0.0, 0.0, 0.0)


@compiled
def react(m: Workspace, point: Point, height: float, into: tuple[Array, Array]) -> None:
    """`into`: room for f² + 3 f numbers; rows (n + 1, 7) over W with an offset behind it, of the wheels' loads and of
    the lateral force."""
    (room, rows), n_free = into, m.basis.shape[1]
    twist = lifted(m.basis, point.state[3:])
    sum_effects(m, point, situation(m, point, twist))
    hold(m, m.phi_by_parameters[:0])
    turned = room[n_free * n_free : n_free * (n_free + 3)].reshape((n_free, 3))
    _invert(m, room[: n_free * n_free].reshape((n_free, n_free)), turned)
    m.standing[:] = 1.0
    fill_map(m.wheels, m.standing, m.gravity, m.carried)
    mass, rigid, rows[:] = mass_matrix(m), rigid_body.regressor(twist, STILL), 0.0
    wheels, lateral = rows[: len(m.wheels)], rows[len(m.wheels)]
    across = -m.basis[1, 0], m.basis[0, 0]  # the first free velocity is along the wheels
    for k in range(len(wheels)):
        share = m.carried[k]
        wheels[k, 2], wheels[k, 3], wheels[k, 4] = -share[0] / m.gravity, -share[2] / m.gravity, share[1] / m.gravity
        wheels[k, 6] = share[0] * m.phi[0] + share[1] * m.phi[1] + share[2] * m.phi[2]
    for i in range(2):
        bias = _bias(rigid[i], m.phi)
        for j in range(3):
            inertial = 0.0
            for a in range(n_free):
                for c in range(3):
                    inertial -= mass[i][c] * m.basis[c, a] * turned[a, j]
            push = m.wrench[j, 0] - _bias(rigid[j], m.phi)
            for k in range(len(wheels)):
                lever = height * m.carried[k, 1 + i] / m.gravity
                wheels[k, PLANAR[j]] -= lever * inertial
                wheels[k, 6] -= lever * inertial * push
            constraint = across[i] * (inertial - 1.0 if i == j else inertial)
            lateral[PLANAR[j]] += constraint
            lateral[6] += constraint * push
        for k in range(len(wheels)):
            wheels[k, 6] -= height * m.carried[k, 1 + i] / m.gravity * bias


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
