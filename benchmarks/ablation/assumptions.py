"""Constants that say how wrong models and sensors are, and what is believed beforehand: they enter likelihoods."""

from __future__ import annotations

from math import inf

from .constants import Constant, Group

B = Group.ASSUMES


def _of(module: str, reasons: dict[str, str], is_diagnosed: bool = True) -> tuple[Constant, ...]:
    return tuple(Constant(module, name, B, None, why, is_diagnosed) for name, why in reasons.items())


ASSUMPTIONS = (
    *_of(
        "weak_form.balances",
        {
            "STILL_SPEED_SIGMAS": "of the smooth speed: a cart that seems to go slower may stand",
        },
    ),
    *_of(
        "weak_form.band",
        {
            "NEWEY_WEST_LAGS": "rows over which residuals are correlated",
            "NUISANCE_EFFECTS": "forms of force that say nothing of the mass",
        },
    ),
    *_of("weak_form.motion", {"MAX_GAP_STEPS": "beyond it nobody knows what happened"}),
    *_of(
        "weak_form.rows",
        {
            "BODY_FORM_ERROR_RATIO": "of wrenches, by which the form of a body is wrong",
            "EFFECT_FORM_ERROR_RATIO": "of an effect, by which its form is wrong",
            "DRY_FRICTION_SPEED": "below it dry friction takes any value",
            "CASTER_SWING_DISTANCE": "way on which casters swing round",
            "CASTER_WEIGHT_FRACTION": "of the weight",
            "SOFT_EDGE_WIDTH": "width of a place's edge",
            "PUSH_RISE_FRACTION": "of its duration, in which a push rises",
            "LOAD_ONSET_TIME": "time in which a load is put on",
            "MIN_FORM_ERROR_RATIO": "share by which forms are wrong at least",
            "POISED_YAW_RATE_SIGMAS": (
                "deviations of the yaw rate by which casters that a reversal left poised may be off"
            ),
            "MAX_POISED_TIME": "for how long casters may stay on their turning point",
            "PRIOR_FRICTION_ROWS": "rows near standstill that count as if friction were as wrong there as it may be",
            "MAX_NOISE_CORRELATION_TIME": "of sensors' noise",
            "MAX_NOISE_SCALE": "times the noise from sample to sample: how loud a sensor may be over a row",
        },
    ),
    *_of(
        "weak_form.score",
        {
            "MIN_PIECE_DURATION": "as long as what is left out belongs together that happens once",
            "MIN_STRETCH_DURATION": "as long as what is left out belongs together that holds everywhere",
        },
    ),
    *_of(
        "weak_form.sensor_noise",
        {
            "AVERAGING_TIMES": "blocks over which a sensor's noise remembers",
        },
    ),
    *_of("weak_form.splines", {"OUTLIER_SIGMAS": "deviations from which on a sample counts for less"}),
    *_of(
        "weak_form.quantisation",
        {
            "WHOLE_STEP_TOLERANCE": "of a step, how far a change is from whole ones",
            "MIN_WHOLE_STEP_FRACTION": "share of changes that are whole steps",
            "MAX_COUNTED_STEPS": "steps that are counted at most",
        },
    ),
    *_of(
        "weak_form.standstill_forces",
        {
            "MAX_REVERSAL_TIME": "who turns back does not stand for as long",
            "GRAVITY": "gravity",
            "HELD_WEIGHT_FRACTION": "of the weight, what a hand or a chock holds",
            "FRICTION_COEFFICIENT": "half of a usual coefficient of rolling resistance: dry friction at rest",
        },
    ),
    *_of(
        "discrepancy.findings.certainty",
        {
            "SIZE_FORM_FRACTION": "of an effect's size, what its form leaves open",
            "MIN_TIME_STD": "half a sample: no onset is known better",
            "MIN_PLACE_STD": "what an edge of the floor is: none is known better",
            "LENGTH_FORM_FRACTION": "of a length, what the form of its effect leaves open",
        },
    ),
    *_of(
        "discrepancy.search.form_error",
        {
            "FORM_DELAY": "how late an effect comes whose form is wrong by its whole size",
            "FORM_SPEED_SCALES": "speeds below which forms of drag differ",
            "FORM_DISTANCE_SCALES": "way after a reversal on which forms of drag differ",
        },
    ),
    *_of(
        "discrepancy.search.continuum",
        {
            "NEIGHBOURS_PER_SIDE": "how wide noise is alike about a frequency, in steps of what a log resolves",
            "NOISE_HUMP_NATS": "nats beforehand against louder noise there",
        },
    ),
    *_of(
        "discrepancy.search.covariates",
        {"MIN_DIRECTED_SPEED": "speed from which on a motion has a direction, in drags of laws"},
    ),
    *_of(
        "discrepancy.findings.fast_noise",
        {"MAX_FAST_NOISE_RATIO": "times a sensor's white noise: how far its noise may remember"},
    ),
    *_of(
        "weak_form.log_segments",
        {"IMPACT_MARGIN": "how long a touch lasts", "MIN_STOP_DISTANCE": "how near a stop a cart leans on it"},
    ),
    *_of(
        "discrepancy.search.laws",
        {
            "DRAG_ONSET_FRACTIONS": "speeds from which on a drag may grow",
            "REVERSAL_KNOTS": "ways since a reversal over which a drag may change",
            "SCRUB_SATURATION_FRACTION": "yaw rate from which on a moment no longer grows",
            "SPLINE_COEFFICIENTS": "of a spline: how a drag or a wind may change with time",
        },
    ),
    *_of(
        "discrepancy.search.model",
        {
            "LOG_MASS_PRIOR_STD": "prior of the logarithms of mass and inertia",
            "COM_PRIOR_STD": "prior of the CoM",
            "SCREENING_PRIOR_RATIO": "prior of a candidate's amplitude, of its usual size",
            "AMPLITUDE_PRIOR_RATIO": "prior of an added effect, of its usual size",
            "FILE_PRIOR_VALUE_FRACTION": "prior of an effect of the file, of its value",
            "FILE_PRIOR_SIZE_FRACTION": "prior of an effect of the file, of its usual size",
            "FORCE_LEVER_STD": "how far from where the model says a force may act",
            "TIMING_STD_FRACTION": "of a step, how late a sensor's samples may be",
        },
    ),
    *_of("discrepancy.findings.alternatives", {"NATS_PER_NUMBER": "nats for each number that a rival takes less"}),
    *_of(
        "discrepancy.findings.named_effects",
        {
            "NAME_BASE_LOG_ODDS": "log odds that a name is true which gains what a name is worth and closes some of "
            "the gap",
            "NAME_GAIN_SLOPE": "by what more, for each time e as many nats",
            "NAME_LARGEST_GAIN_SLOPE": "by what less, for each time e that the largest gain is larger",
            "ALTERNATIVE_ODDS_WEIGHT": "of the odds of what explains about as much",
            "UNTRIED_NAME_PROBABILITY": "probability of a name that no step added",
        },
    ),
    *_of("discrepancy.findings.refusal", {"ERROR_BLOCK_INTERVAL": "time over which errors of rollouts are related"}),
    *_of(
        "discrepancy.findings.rollouts", {"MAX_REST_FRACTION": "of a rollout, in which anything may have held the cart"}
    ),
    # what is usual: the table of priors
    Constant(
        "discrepancy.search.plausibility",
        "PRIOR_LOG_ODDS[rolling_resistance]",
        B,
        0.0,
        "log odds of rolling resistance before data",
    ),
    Constant("discrepancy.search.plausibility", "MIN_SETTINGS[time_delay.delay]", B, 0.0, "least delay with a name"),
    Constant("discrepancy.search.plausibility", "MIN_SETTINGS[load_slosh.damping]", B, 0.0, "least damping of a load"),
    Constant("discrepancy.search.plausibility", "MAX_SETTINGS[time_delay.delay]", B, inf, "largest delay with a name"),
    Constant(
        "discrepancy.search.plausibility", "MAX_SETTINGS[load_slosh.damping]", B, inf, "largest damping of a load"
    ),
    Constant(
        "discrepancy.search.plausibility", "MAX_SETTINGS[load_slosh.frequency]", B, inf, "highest frequency of a load"
    ),
    Constant("discrepancy.search.plausibility", "MAX_SETTINGS[external_push.duration]", B, inf, "longest push"),
    Constant(
        "discrepancy.search.plausibility",
        "MAX_SETTINGS[stribeck_friction.speed]",
        B,
        inf,
        "largest speed of Stribeck friction",
    ),
    Constant(
        "discrepancy.search.plausibility", "MAX_SETTINGS[caster_realignment.trail]", B, inf, "longest trail of a caster"
    ),
    Constant("discrepancy.search.plausibility", "MIN_SETTINGS[force_scale.gain]", B, 0.0, "least gain of a sensor"),
    Constant("discrepancy.search.plausibility", "MAX_SETTINGS[force_scale.gain]", B, inf, "largest gain of a sensor"),
    Constant(
        "discrepancy.search.plausibility", "MAX_SETTINGS[force_misalignment.angle]", B, inf, "largest angle of a sensor"
    ),
    Constant(
        "discrepancy.search.plausibility",
        "MAX_SETTINGS[contact_offset.y]",
        B,
        inf,
        "farthest of a hand from its contact",
    ),
    Constant(
        "discrepancy.search.plausibility", "UBIQUITOUS_EFFECTS", B, (), "what every cart has, or every chain of sensors"
    ),
    Constant(
        "discrepancy.search.plausibility", "ESSENTIAL_PARAMETERS", B, {}, "what makes an effect what its name says"
    ),
    Constant(
        "discrepancy.search.plausibility", "MOMENT_BY_FORCE", B, {}, "effects whose moment is their force at a wheel"
    ),
    Constant("weak_form.band", "INERTIAL_EFFECTS", B, (), "names that nobody gets who does not push"),
    Constant("discrepancy.search.candidates", "DRAGS_TOLD_BY_TURNING", B, (), "names that no cart on a rail gets"),
)
