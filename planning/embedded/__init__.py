"""The allocation as C for a controller in hard real time: `export_c` writes a folder that stands alone.

OSQP's code generation gives a solver without memory allocation, which proposes; our C (`c/`) finishes a proposal
on its active set and accepts it only with the same proof as `WrenchPlanner`: KKT residuals, or a certificate.
"""

from __future__ import annotations

from .export import check_free, export_c
from .problem_code import EmbeddedProblem

__all__ = ["EmbeddedProblem", "check_free", "export_c"]
