"""All constants of the discrepancy engine."""

from __future__ import annotations

from .assumptions import ASSUMPTIONS
from .constants import Constant
from .deciding import DECIDING
from .numerics import NUMERICS

CONSTANTS: tuple[Constant, ...] = (*DECIDING, *ASSUMPTIONS, *NUMERICS)
