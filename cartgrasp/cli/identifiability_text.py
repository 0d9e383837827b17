"""What tables say of parameters that were taught, under an estimate's last health."""

from __future__ import annotations

from estimation.health import Health


def identifiable_word(is_identifiable: bool, health: str = Health.OK) -> str:
    """`yes` only under a health that is ok."""
    return "yes" if is_identifiable and health == Health.OK else "no"


def print_health(health: str, model: str = "the model") -> None:
    """What follows of one that is not ok, of the model that is so called."""
    if health == Health.INCONSISTENT:
        print(f"- {model} does not fit this log, so it taught nothing: `cartgrasp discrepancy` tells what is missing")
    elif health != Health.OK:
        print(f"- health: {health}, so nothing counts as taught")
