"""`cartgrasp study safety`."""

from functools import partial

from ..studies import safety_report
from ..studies.safety import run_seeds
from .study_report import run_study

run = partial(run_study, ("safety", "Carts that are not known yet, driven hard"), run_seeds, safety_report)
