"""Constants of numerics, grids, effort, refusals of logs that can't be read, and words: no verdict depends on them
but by resolution."""

from __future__ import annotations

from .constants import Constant, Group

C = Group.WORKS_OUT

REASONS: dict[str, dict[str, str]] = {
    "weak_form.balances": {
        "REGION_RIM_WIDTH": "beyond it a soft edge is nought",
        "POSE_STEP": "of a difference",
    },
    "weak_form.integrals": {
        "GRID_CHUNK_POINTS": "memory",
        "SPLINE_SUPPORT": "of a cubic B-spline",
        "GRID_STRIDE": "effort",
    },
    "weak_form.band": {
        "ROW_STEPS": "grid of bands",
        "MIN_SPARE_ROWS": "rows, to be solvable",
        "MIN_COLUMN_RATIO": "columns that are nought",
        "ALL_ROWS": "all rows",
    },
    "weak_form.fit": {
        "MAX_LINEARISATIONS": "of Gauss-Newton",
        "CONVERGENCE_SIGMAS": "of Gauss-Newton",
    },
    "weak_form.linearized": {"INFORMATION_ROUNDING": "rounding"},
    "weak_form.motion": {
        "GRID_STEP": "grid",
        "MAX_GRID_POINTS": "refuses a log",
        "MAX_CACHED_MEMORIES": "memory",
        "MIN_GRID_STEP": "grid",
        "KNOT_STEPS": "knots of splines",
        "MIN_SAMPLES_PER_KNOT": "knots of splines",
        "MIN_POSES": "refuses a log",
    },
    "weak_form.rows": {
        "BISECTIONS": "effort",
        "MIN_EXCESS_NOISE": "keeps logs without noise solvable",
        "MIN_FORCE_DENSITY": "keeps logs without noise solvable",
        "MIN_VELOCITY_DENSITY": "keeps logs without noise solvable",
        "HUBER_SIGMAS": "of a robust mean",
    },
    "weak_form.standstill_forces": {"MIN_TURNING_SPEED": "keeps finite"},
    "weak_form.score": {
        "N_SCORE_FOLDS": "number of folds",
        "MAX_PIECES": "memory",
        "MAX_STRETCHES": "effort",
        "MIN_RESIDUAL_SCALE": "keeps logs without noise finite",
    },
    "weak_form.splines": {
        "SPLINE_DEGREE": "of the motion's splines",
        "PENALTY_ORDER": "of their penalty",
        "MIN_PENALTY_RATIO": "bridges gaps",
        "DIFFERENCE_ROUNDING": "bridges gaps",
        "MIN_PENALTY_DECADES": "range of the penalty",
        "MAX_PENALTY_DECADES": "range of the penalty",
        "N_REWEIGHTINGS": "effort",
    },
    "discrepancy.search.candidates": {"EVER": "stands for infinity"},
    "discrepancy.search.continuum": {"LEAST": "rounding"},
    "discrepancy.search.form_error": {"MOST_MODES": "memory"},
    "discrepancy.findings.certainty": {
        "TAUGHT": "a flag that the report does not tell",
        "MOST_MOVED": "of a linear step",
        "LEAST_LEFT": "keeps it solvable",
        "PERIOD_STEP": "first step",
        "SETTING_STEP": "of a finite difference",
        "RELATIVE_STEP": "of a finite difference",
        "FAINT": "range of a grid",
        "DOUBLINGS": "range of a grid",
        "POINTS": "grid",
    },
    "discrepancy.where.acting": {"WORDS": "words"},
    "discrepancy.diagnosis.diagnosis": {
        "OTHER_CART": "a warning",
    },
    "discrepancy.where.changes": {"PENALTY": "change points of sentences and figures", "MOST": "effort"},
    "discrepancy.where.circumstances": {"SMOOTHED": "wrenches in sentences"},
    "discrepancy.clock_offset": {"UNKNOWN": "whether a lateness is told"},
    "discrepancy.findings.fast_noise": {
        "ROW_STEP": "grid",
        "THIRD": "third differences",
        "FEWEST": "differences, to be solvable",
    },
    "discrepancy.diagnosis.drawing": dict.fromkeys(
        ("NO_METADATA", "KINDS", "SIDES", "BAND", "ZERO", "FLAT"), "of a figure"
    ),
    "discrepancy.diagnosis.figures": {"BARS": "colours"},
    "discrepancy.diagnosis.residual_figures": dict.fromkeys(
        ("MOST_ROWS", "CLOSER", "WORST", "PERIODS", "LEAST_FOLLOWED", "FOLDED", "CUT"), "of a figure"
    ),
    "discrepancy.diagnosis.rollout_figure": dict.fromkeys(("EVERY", "LAST"), "of a figure"),
    "weak_form.log_segments": {
        "MIN_SEGMENT_DURATION": "parts of a log that are too short to solve",
        "MAX_SEGMENT_POSE_GAP": "effort: a pause that makes two logs of one",
    },
    "discrepancy.findings.gap": {
        "COORDINATES": "words",
    },
    "discrepancy.findings.held_out": {
        "FOLDS": "number of folds",
        "DRAWS": "effort",
        "MOST_MOVED": "of a linear step",
    },
    "discrepancy.findings.isolability": {
        "ALIKE": "table of what is alike",
        "SHOWN": "table of what is alike",
        "PARALLEL": "rounding",
    },
    "discrepancy.search.laws": {
        "AT_HANDS": "word",
        "VARIABLES": "words",
        "UNITS": "words",
        "FINE": "knots of curves",
        "PLACES": "knots of fields",
        "LEAST_SPAN": "keeps knots apart",
    },
    "discrepancy.diagnosis.law_figure": dict.fromkeys(("LEAST_UNIT", "POINTS", "MOST_DOTS"), "of a figure"),
    "discrepancy.findings.learned": dict.fromkeys(("FORCES", "OF_TIME", "USUAL", "TURN", "WALK", "FINE"), "words"),
    "discrepancy.search.periods": {
        "SCANNED": "grid of periods",
        "OF": "words",
        "SCANNED_FORCES": "words",
        "HARMONICS": "grid of laws",
        "OVERSAMPLED": "grid of a Fourier transform",
        "KNOWN": "effort",
        "LIKELY": "effort",
    },
    "discrepancy.diagnosis.sentence": {"REFITTED": "whether a sentence tells of the refit"},
    "discrepancy.log_check": {
        "FEWEST_ROWS": "refuses a log",
        "SHORTEST": "refuses a log",
        "FEWEST_USED": "refuses a log",
        "EIGHTHS": "words on the motion",
        "LEAST_HEADED": "words on the motion",
        "ROLLING": "words on the motion",
        "STILL_TURNING": "words on the motion",
    },
    "discrepancy.search.model": {"ROUNDS": "effort"},
    "discrepancy.findings.named": {"SURE": "which of an effect's numbers are told"},
    "discrepancy.diagnosis.next_experiments": {
        "ALIKE": "words",
        "NOTHING_OPEN": "words",
        "FORM": "which motion is proposed",
        "MOST_TOLD": "words",
    },
    "discrepancy.diagnosis.page": dict.fromkeys(
        ("POLICY", "STYLE", "ONE_STD", "OWN", "COMMANDS", "WORDS"), "of the page"
    ),
    "discrepancy.search.refine": {
        "HALVINGS": "effort",
        "EVALUATIONS": "effort",
        "TIME_STEP": "first step",
        "PLACE_STEP": "first step",
        "DELAY_STEP": "first step",
        "FACTOR": "first step",
    },
    "discrepancy.findings.refusal": {
        "FEWEST": "blocks, to be solvable",
        "HORIZON": "the gap's",
        "SURE": "of `identify`",
    },
    "discrepancy.where.residual": {
        "LATERAL": "word",
        "DIRECTIONS": "words",
        "LEAST_CREEP": "whether a place is told",
        "UNITS": "words",
        "STRETCH": "of means that are told",
        "FINE": "of rows that are drawn",
        "EDGE": "of a stretch, by rounding",
        "SURE": "whether a place is told",
    },
    "discrepancy.where.residual_map": {
        "HEADING": "word",
        "BINS": "grid",
        "HALF": "grid",
        "FEWEST": "stretches in a mean",
    },
    "discrepancy.findings.rollouts": {
        "HORIZONS": "what a gap is",
        "EVERY": "effort",
        "STEP": "of the integrator",
        "STABLE": "of the integrator",
        "LOST": "keeps finite",
        "SAMPLED": "effort",
    },
    "discrepancy.search.screening": {
        "KEPT": "effort",
        "BLOCK": "grid of times",
        "LENGTHS": "grid of times",
        "CELL": "grid of places",
        "MOST_CELLS": "grid of places",
        "RIM": "grid of places",
        "LEAST_LEVER": "hands that are nearer push at {b}'s x",
        "NEARBY": "grid of laws",
        "EXACT": "effort",
        "LARGEST": "what ran away in an integrator",
    },
    "discrepancy.search.search": {
        "NEAR": "effort",
        "MOST_REFITTED": "effort",
        "MOST_LAWS": "effort",
        "MOST_STEPS": "effort",
        "MOST_SWAPPED": "effort",
    },
    "weak_form.wrenches": {
        "WHOLE_GRID": "all of a grid",
        "MIN_WRENCH_DENSITY": "keeps solvable",
        "MIN_COVARIANCE_RATIO": "keeps solvable",
        "MAX_SENSOR_DELAY": "a delay that nobody asks about",
    },
    "discrepancy.findings.rivals": {"LONGEST": "keeps finite"},
    "discrepancy.findings.soft_push": {"EARLIER": "geometry of half a sine"},
    "discrepancy.findings.verdicts": dict.fromkeys(("ADDED", "OTHER_SIZE", "WITHDRAWN", "ROUGHLY", "FORMS"), "words"),
    "discrepancy.where.where": {
        "LEAST_SHARE": "which sentences are told",
        "LEAST_LIFT": "which sentences are told",
        "LEAST_ALONG": "which sentences are told",
        "MOST": "which sentences are told",
        "MOST_KNOWN": "which sentences are told",
        "WIDER": "which sentences are told",
        "SLOW": "conditions of sentences",
        "TURNING": "conditions of sentences",
        "PARTS": "of a period, where it is told",
        "AROUND": "conditions of sentences",
        "FAST_SHARE": "conditions of sentences",
        "STRONG_SHARE": "conditions of sentences",
        "WEAK_SHARE": "conditions of sentences",
        "LARGEST": "conditions of sentences",
        "AFTER_REVERSAL": "conditions of sentences",
        "MOST_CONTACTS": "which sentences are told",
    },
}

NUMERICS = tuple(
    Constant(module, name, C, None, why) for module, reasons in REASONS.items() for name, why in reasons.items()
)
