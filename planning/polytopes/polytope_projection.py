"""The shadow of a wrench polytope on two or three components, by its vertices.

The shadow's support in a direction is the polytope's, so it is found without the (many) vertices in six dimensions:
from a first simplex of support points, each facet of the hull of the points found is pushed outwards by one linear
program; a facet that doesn't move is a facet of the shadow. It ends as a polytope has finitely many vertices. A flat
shadow (mu = 0 leaves no fy) is found within its own plane or line.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.linalg import null_space
from scipy.spatial import ConvexHull

from cartgrasp.contacts import WRENCH_NAMES
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from .wrench_polytope import WrenchPolytope

MIN_WIDTH_RATIO = 1e-7
"""Widths below this part of the shadow's largest are flat, and facets this near are proven."""

Support = Callable[[Array], Array]


def project(polytope: WrenchPolytope, components: Sequence[str]) -> Array:
    """Vertices (k, d) of the shadow on d components (`fx` … `tz`), N and N·m; of two components, in counter-clockwise
    order."""
    if not 1 <= len(set(components)) == len(components) <= 3 or not set(components) <= set(WRENCH_NAMES):
        raise UsageError(f"components: {', '.join(components)}: give one to three of {', '.join(WRENCH_NAMES)}")
    columns = [WRENCH_NAMES.index(name) for name in components]

    def support(direction: Array) -> Array:
        towards = np.zeros(6)
        towards[columns] = direction
        return polytope.support(towards).wrench[columns]

    points, basis = _simplex(support, len(columns))
    if basis.shape[1] == 0:
        return points[:1]
    flat = (points - points[0]) @ basis
    if basis.shape[1] == 1:
        return points[[int(flat.argmin()), int(flat.argmax())]]
    size = np.ptp(flat, axis=0)
    grown = _grown(lambda direction: (support(basis @ (direction / size)) - points[0]) @ basis / size, flat / size)
    return np.asarray(points[0] + (size * grown) @ basis.T)


def _simplex(support: Support, dimension: int) -> tuple[Array, Array]:
    """Support points (k, d) that span the shadow, and an orthonormal basis (d, rank) of its directions."""
    points = [support(np.eye(dimension)[0])]
    spanned, flat = np.zeros((dimension, 0)), np.zeros((dimension, 0))
    while spanned.shape[1] + flat.shape[1] < dimension:
        normal = null_space(np.hstack([spanned, flat]).T)[:, 0] if spanned.size + flat.size else np.eye(dimension)[0]
        far, near = support(normal), support(-normal)
        points += [far, near]
        scale = max(1.0, float(np.abs(points).max()))
        if normal @ (far - near) <= MIN_WIDTH_RATIO * scale:
            flat = np.column_stack([flat, normal])
            continue
        outer = far if abs(normal @ (far - points[0])) > abs(normal @ (near - points[0])) else near
        part = outer - points[0]
        for known in (spanned, flat):
            part = part - known @ (known.T @ part)
        spanned = np.column_stack([spanned, part / np.linalg.norm(part)])
    if spanned.shape[1] == dimension and np.linalg.det(spanned) < 0:
        spanned[:, -1] *= -1.0  # right-handed, so that what goes round here goes round there
    return np.array(points), spanned


def _grown(support: Support, points: Array) -> Array:
    """Vertices of a shadow about as wide as 1 in every direction, from support points that span it."""
    proven: set[tuple[float, ...]] = set()
    while True:
        hull = ConvexHull(points)
        points = hull.points[hull.vertices]
        facets = {tuple(np.round(facet[:-1], 9)): facet for facet in hull.equations}
        for normal in facets.keys() - proven:
            found = support(facets[normal][:-1])
            outside = facets[normal][:-1] @ found + facets[normal][-1] > MIN_WIDTH_RATIO
            if outside and np.linalg.norm(points - found, axis=1).min() > MIN_WIDTH_RATIO:
                points = np.vstack([points, found])
            else:
                proven.add(normal)
        if proven >= facets.keys():
            return points
