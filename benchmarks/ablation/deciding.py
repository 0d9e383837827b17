"""Constants that decide which names are told, or what verdict; what switches each off."""

from __future__ import annotations

from math import inf

from .constants import Constant, Group

A = Group.DECIDES
NEVER = 1e9
"""s: as long as no log is."""

DECIDING = (
    # the band in which the search is made
    Constant("weak_form.band", "BAND_MASS_SIGMAS", A, inf, "deviations by which a narrower band's mass is another"),
    Constant("weak_form.band", "BAND_MASS_RATIO", A, 0.0, "share of the mass by which a narrower band's is another"),
    Constant("weak_form.band", "MAX_MASS_STD_RATIO", A, inf, "scatter of the mass beyond which a band says nothing"),
    Constant(
        "weak_form.band", "COMPARABLE_STD_RATIO", A, inf, "times the least deviation of a mass, in a band that is taken"
    ),
    # what is tried
    Constant("discrepancy.search.screening", "MIN_CHANGE_MARGIN", A, 0.0, "time before and after a lasting change"),
    # what is added and dropped
    Constant(
        "discrepancy.search.gains",
        "MIN_GAIN_NATS",
        A,
        0.0,
        "least gain of what is added, kept, or less simple than another",
    ),
    Constant("discrepancy.search.search", "MIN_GAIN_FRACTION", A, 0.0, "least gain as a share of the largest so far"),
    Constant(
        "discrepancy.search.form_error", "FORM_MODE_STD", A, 0.0, "of an effect, by which its form is wrong in a mode"
    ),
    Constant(
        "discrepancy.search.search", "MIN_RESIZING_NATS", A, 0.0, "least gain of another size of an effect of the file"
    ),
    Constant("discrepancy.search.gains", "GAIN_SIGMAS", A, 0.0, "least gain in standard errors over stretches"),
    Constant(
        "discrepancy.search.model",
        "LONG_MEAN_INTERVAL",
        A,
        NEVER,
        "means whose size divides the gain of what lasts for a while",
    ),
    Constant(
        "discrepancy.search.model", "MIN_LONG_MEANS", A, 1, "means, of which shorter ones are where a log is short"
    ),
    # what may be called so
    Constant("discrepancy.search.plausibility", "MIN_NAMED_SIZE_RATIO", A, 0.0, "least size of a named effect"),
    Constant(
        "discrepancy.search.plausibility",
        "BOUND_SLACK_RATIO",
        A,
        inf,
        "times what is plausible that estimates may be",
    ),
    Constant(
        "discrepancy.search.plausibility",
        "ESSENTIAL_SIGMAS",
        A,
        0.0,
        "deviations from nought of what makes an effect what it is",
    ),
    Constant(
        "discrepancy.findings.refusal",
        "MAX_REFIT_ERROR_RATIO",
        A,
        inf,
        "times the error on unseen stretches that speaks against a name",
    ),
    Constant(
        "discrepancy.findings.validation",
        "MIN_GAP_CLOSED_FRACTION",
        A,
        1.0,
        "share of the gap that is told though it gains little",
    ),
    # what is said
    Constant(
        "discrepancy.search.gains", "CONFUSABLE_NATS", A, 0.0, "nats by which less a rival explains that is told beside"
    ),
    Constant(
        "discrepancy.findings.gap",
        "DISAGREEMENT_NOISE_RATIO",
        A,
        inf,
        "times noise, from which on a gap is a disagreement",
    ),
    Constant(
        "discrepancy.findings.gap",
        "MAX_GAP_LEFT_FRACTION",
        A,
        inf,
        "share of the gap that may be left where effects explain it",
    ),
)
