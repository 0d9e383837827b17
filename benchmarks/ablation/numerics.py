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
    "weak_form.linearized": {
        "MAX_LINEARISATIONS": "of Gauss-Newton",
        "CONVERGENCE_SIGMAS": "of Gauss-Newton",
        "INFORMATION_ROUNDING": "rounding",
    },
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
    "discrepancy.search.candidates": {"UNBOUNDED_LENGTH": "stands for infinity"},
    "discrepancy.search.continuum": {"WAVE_RANK_TOLERANCE": "rounding"},
    "discrepancy.search.form_error": {"MAX_FORM_MODES": "memory"},
    "discrepancy.findings.certainty": {
        "IDENTIFIED_STD_RATIO": "a flag that the report does not tell",
        "MAX_LOG_MASS_CHANGE": "of a linear step",
        "MIN_RESIDUAL_FRACTION": "keeps it solvable",
        "PERIOD_STEP_FRACTION": "first step",
        "SETTING_STEP": "of a finite difference",
        "RELATIVE_SETTING_STEP": "of a finite difference",
        "NEGLIGIBLE_NATS": "range of a grid",
        "MAX_RANGE_DOUBLINGS": "range of a grid",
        "SETTING_GRID_POINTS": "grid",
    },
    "discrepancy.diagnosis.diagnosis": {
        "MASS_DIFFERENCE_SIGMAS": "a warning",
    },
    "discrepancy.where.changes": {
        "CHANGE_POINT_PENALTY": "change points of sentences and figures",
        "MAX_CHANGE_POINT_PLACES": "effort",
    },
    "discrepancy.where.circumstances": {"WRENCH_AVERAGING_INTERVAL": "wrenches in sentences"},
    "discrepancy.clock_offset": {"MAX_OFFSET_STD": "whether a lateness is told"},
    "discrepancy.findings.fast_noise": {
        "FAST_NOISE_ROW_STEP": "grid",
        "THIRD_DIFFERENCE": "third differences",
        "MIN_FAST_NOISE_DIFFERENCES": "differences, to be solvable",
    },
    "discrepancy.diagnosis.drawing": dict.fromkeys(
        ("NO_METADATA", "MODEL_COLOURS", "COMPARED_MODELS", "BAND_STYLE", "ZERO_LINE_STYLE", "FLAT_PATH_RATIO"),
        "of a figure",
    ),
    "discrepancy.diagnosis.figures": {"GAP_BARS": "colours"},
    "discrepancy.diagnosis.residual_figures": dict.fromkeys(
        (
            "MAX_DRAWN_ROWS",
            "CLOSEUP_INTERVAL",
            "WORST_INTERVAL",
            "MAX_CLOSEUP_PERIODS",
            "MIN_DRAWN_FRACTION",
            "BINS_PER_PERIOD",
            "CLIPPING_PERCENTILE",
        ),
        "of a figure",
    ),
    "discrepancy.diagnosis.rollout_figure": dict.fromkeys(
        ("STEPS_PER_CURVE_POINT", "DRAWN_HORIZON_INDEX"), "of a figure"
    ),
    "weak_form.log_segments": {
        "MIN_SEGMENT_DURATION": "parts of a log that are too short to solve",
        "MAX_SEGMENT_POSE_GAP": "effort: a pause that makes two logs of one",
    },
    "discrepancy.findings.gap": {
        "GAP_COORDINATES": "words",
    },
    "discrepancy.findings.held_out": {
        "HELD_OUT_FOLDS": "number of folds",
        "NOISE_DRAWS": "effort",
        "CART_DRAWS": "effort",
        "MAX_LOG_INERTIA_CHANGE": "of a linear step",
    },
    "discrepancy.findings.isolability": {
        "CONFUSABLE_CORRELATION": "table of what is alike",
        "SHOWN_SIGMAS": "table of what is alike",
        "TRACE_RANK_TOLERANCE": "rounding",
    },
    "discrepancy.search.laws": {
        "AT_HANDS": "word",
        "VARIABLE_WORDS": "words",
        "VARIABLE_UNITS": "words",
        "CURVE_KNOTS": "knots of curves",
        "FIELD_KNOTS": "knots of fields",
        "MIN_VARIABLE_SPAN": "keeps knots apart",
    },
    "discrepancy.diagnosis.law_figure": dict.fromkeys(
        ("MIN_UNIT_EFFECT_RATIO", "LAW_CURVE_POINTS", "MAX_FIGURE_DOTS"), "of a figure"
    ),
    "discrepancy.findings.learned_laws": dict.fromkeys(
        (
            "FORCE_PHRASES",
            "TIME_LAW_CAUSES",
            "VARIABLE_LAW_CAUSES",
            "FULL_TURN",
            "WALKING_PERIODS",
            "SLOPE_STEPS_PER_PERIOD",
        ),
        "words",
    ),
    "discrepancy.search.periods": {
        "SCANNED_VARIABLES": "grid of periods",
        "LAW_VARIABLE_OF": "words",
        "SCANNED_FORCES": "words",
        "LAW_HARMONICS": "grid of laws",
        "FOURIER_OVERSAMPLING": "grid of a Fourier transform",
        "INFORMATION_FREQUENCIES": "effort",
        "MAX_SCORED_PERIODS": "effort",
    },
    "discrepancy.diagnosis.sentence": {"REFIT_IMPROVEMENT_RATIO": "whether a sentence tells of the refit"},
    "discrepancy.log_check": {
        "MIN_LOG_ROWS": "refuses a log",
        "MIN_LOG_DURATION": "refuses a log",
        "MIN_LOG_BALANCE_ROWS": "refuses a log",
        "HEADING_SECTORS": "words on the motion",
        "MIN_SECTOR_INTERVAL": "words on the motion",
        "MIN_ROLLING_SPEED": "words on the motion",
        "MIN_TURNING_RATE": "words on the motion",
    },
    "discrepancy.search.model": {"SETTLING_ROUNDS": "effort"},
    "discrepancy.findings.named_effects": {"PRESENT_SIGMAS": "which of an effect's numbers are told"},
    "discrepancy.diagnosis.next_experiments": {
        "INDISTINCT_SIGMAS": "words",
        "NOTHING_OPEN": "words",
        "MODEL_ERROR_FRACTION": "which motion is proposed",
        "MAX_LISTED_NAMES": "words",
    },
    "discrepancy.diagnosis.page": dict.fromkeys(
        (
            "CONTENT_SECURITY_POLICY",
            "PAGE_STYLE",
            "ONE_STD",
            "LOG_SPECIFIC_LAW_TEXTS",
            "NEXT_COMMANDS",
            "SECTION_TEXTS",
        ),
        "of the page",
    ),
    "discrepancy.search.refine": {
        "MAX_STEP_HALVINGS": "effort",
        "MAX_GAIN_EVALUATIONS": "effort",
        "FIRST_TIME_STEP": "first step",
        "FIRST_PLACE_STEP": "first step",
        "FIRST_DELAY_STEP": "first step",
        "FIRST_STEP_RATIO": "first step",
    },
    "discrepancy.findings.refusal": {
        "MIN_ERROR_BLOCKS": "blocks, to be solvable",
        "REFUSAL_HORIZON_INDEX": "the gap's",
        "REFIT_ERROR_SIGMAS": "of `identify`",
    },
    "discrepancy.where.residual": {
        "LATERAL_VELOCITY": "word",
        "RESIDUAL_DIRECTIONS": "words",
        "MIN_CREEP_SPEED": "whether a place is told",
        "RESIDUAL_UNITS": "words",
        "MEAN_STRETCH_INTERVAL": "of means that are told",
        "FINE_ROW_STEP": "of rows that are drawn",
        "STRETCH_EDGE_TOLERANCE": "of a stretch, by rounding",
        "RESIDUAL_EXCESS_SIGMAS": "whether a place is told",
    },
    "discrepancy.where.residual_map": {
        "HEADING": "word",
        "PROFILE_BINS": "grid",
        "HALF_HEADING_BIN": "grid",
        "MIN_STRETCHES_PER_BIN": "stretches in a mean",
    },
    "discrepancy.findings.rollouts": {
        "HORIZONS": "what a gap is",
        "ROLLOUT_START_INTERVAL": "effort",
        "MAX_ROLLOUT_STEP": "of the integrator",
        "MAX_STABLE_STEP_RATE": "of the integrator",
        "DIVERGED_ERROR": "keeps finite",
        "STIFFNESS_SAMPLES": "effort",
    },
    "discrepancy.search.screening": {
        "MAX_KEPT_VARIANTS": "effort",
        "ONSET_GRID_INTERVAL": "grid of times",
        "SPAN_BLOCKS": "grid of times",
        "CELL_SIZE": "grid of places",
        "MAX_CELLS_PER_AXIS": "grid of places",
        "FLOOR_RIM": "grid of places",
        "MIN_HAND_LEVER": "hands that are nearer push at {b}'s x",
        "PERIOD_SEARCH_WIDTH": "grid of laws",
        "PERIOD_SEARCH_TOLERANCE": "effort",
        "MAX_WHITENED_COLUMN": "what ran away in an integrator",
    },
    "discrepancy.search.search": {
        "REFINED_GAIN_FRACTION": "effort",
        "MAX_REFITTED_EFFECTS": "effort",
        "MAX_REFITTED_LAWS": "effort",
        "MAX_SEARCH_STEPS": "effort",
        "MAX_SWAPPED_EFFECTS": "effort",
    },
    "weak_form.wrenches": {
        "WHOLE_GRID": "all of a grid",
        "MIN_WRENCH_DENSITY": "keeps solvable",
        "MIN_COVARIANCE_RATIO": "keeps solvable",
        "MAX_SENSOR_DELAY": "a delay that nobody asks about",
    },
    "discrepancy.findings.alternatives": {"MAX_LOG_ODDS": "keeps finite"},
    "discrepancy.findings.half_sine_push": {"HALF_SINE_LEAD_FRACTION": "geometry of half a sine"},
    "discrepancy.findings.verdicts": dict.fromkeys(
        ("ADDED", "OTHER_SIZE", "WITHDRAWN", "NOT_FITTED", "FORM_ERROR_WORDS"), "words"
    ),
    "discrepancy.where.where": {
        "MIN_CONDITION_FRACTION": "which sentences are told",
        "MIN_CONDITION_LIFT": "which sentences are told",
        "MIN_DEPENDENCE_FRACTION": "which sentences are told",
        "MAX_SENTENCES": "which sentences are told",
        "MAX_OVERLAP_FRACTION": "which sentences are told",
        "MAX_OVERLAP_WIDTH_RATIO": "which sentences are told",
        "SLOW_SPEED": "conditions of sentences",
        "TURNING_RATE": "conditions of sentences",
        "PARTS_PER_PERIOD": "of a period, where it is told",
        "WORST_HALF_INTERVAL": "conditions of sentences",
        "FAST_SPEED_FRACTION": "conditions of sentences",
        "STRONG_WRENCH_FRACTION": "conditions of sentences",
        "WEAK_WRENCH_FRACTION": "conditions of sentences",
        "LARGEST_PERCENTILE": "conditions of sentences",
        "AFTER_REVERSAL_DISTANCE": "conditions of sentences",
        "MAX_LISTED_CONTACTS": "which sentences are told",
        "GATE_WORDS": "words",
    },
}

NUMERICS = tuple(
    Constant(module, name, C, None, why) for module, reasons in REASONS.items() for name, why in reasons.items()
)
