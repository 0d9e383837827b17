"""What the compiled loop is given, keeps, and leaves behind: arrays by name, which a call hands over as they are.

n steps, a arms, s places where they hold in turn, f free velocities, N states and P parameters of the true cart, p
parameters of the believed one.
"""

from __future__ import annotations

from typing import NamedTuple

from ...frames import Array
from ...kernels.jit import Ints


class RunInputs(NamedTuple):
    """The same for runs of one scenario: times (n,); poses (n, 3), nu and nu' (n, f) of the reference; which place is
    held (n,); points (s, a, 3), grasp maps (s, 3, 6 a), and what takes wrenches to reduced ones, with the noise of that
    (s, f, 6 a + f); `along` (f, 3) of the free velocities; and the tracker's law (7,): axle and angle of the wheels,
    and its gains with their reach."""

    time: Array
    pose: Array
    velocity: Array
    acceleration: Array
    place: Ints
    points: Array
    grasp: Array
    grip: Array
    basis: Array
    along: Array
    law: Array


class Workspaces(NamedTuple):
    """Workspaces of kernels, floats and ints of each: the true cart, the believed one with its floor, the planner; the
    driven motion with its plan; rows and constants of the moments that are tracked."""

    plant: Array
    plant_ints: Ints
    cart: Array
    cart_ints: Ints
    planner: Array
    planner_ints: Ints
    driven: Array
    plan: Ints
    rows: Array
    known: Array


class LoopState(NamedTuple):
    """What goes on from step to step: the true state (N,); the parameters (p,) as they are believed, and that as
    `measured_wrench.MeasuredWrench` has it; wrenches planned (6 a,) and wanted (3,); what is `seen` (6,), and felt
    beside it, `unfelt` (1,).

    Behind them room for what is asked of kernels and found by them: the true cart's, `given` and `found` (`nothing`
    where that isn't asked for); the believed one's with an acceleration, `asked`, two states of it, and what is
    `told`."""

    state: Array
    theta: Array
    believed: Array
    wrenches: Array
    wanted: Array
    seen: Array
    unfelt: Array
    given: Array
    found: Array
    nothing: Array
    asked: Array
    states: Array
    told: Array


class RunHistory(NamedTuple):
    """What happened: true states (n, N) before each step, wrenches given (n, 6 a); and what sensors said: pose and
    velocity (n, 3), wrenches (n, 6 a). The latter hold noise to begin with, NaN where no sample is due."""

    state: Array
    wrenches: Array
    pose: Array
    velocity: Array
    felt: Array
