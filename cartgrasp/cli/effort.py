"""`cartgrasp study effort`."""

from functools import partial

from ..studies import effort_report
from ..studies.effort import run_seeds
from .study_report import run_study

run = partial(run_study, ("effort", "What hands pay at equal tracking error"), run_seeds, effort_report)
