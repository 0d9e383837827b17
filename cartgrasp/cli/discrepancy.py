"""`cartgrasp discrepancy LOG [LOG …] --cart cart.yaml --out DIR`."""

from __future__ import annotations

from pathlib import Path

from estimation.discrepancy import Diagnosis, diagnose
from estimation.experiments.manoeuvres import Limits

from .inputs_file import Inputs, following
from .log_inputs import Sources, cart_and_logs
from .output import check_writable, print_json, print_table, say, stages
from .sensors import check_logs

MAX_IMPACTS_SHOWN, MAX_PLACES_SHOWN = 5, 2


def run(
    sources: Sources,
    out: Path | None,
    as_json: bool,
    follow: Path | None = None,
    next_file: Path | None = None,
    limits: Limits | None = None,
) -> int:
    """`limits` are of the reference that goes into `next_file`."""
    if follow is not None:
        sources = following(sources, follow)
    if next_file is not None:
        check_writable(next_file, *sources.files, option="--next")
    cart, logs = cart_and_logs(sources, out)
    check_logs(logs, cart, sources.accepted, is_told=not as_json)
    inputs = Inputs.of(sources, out) if out is not None else None
    with stages(f"comparing {cart.name}") as tell:
        found = diagnose(logs, cart, tell, limits=limits)
    if out is not None and inputs is not None:
        found.report.save(out)
        inputs.save(out)
        say(f"the report is {out / 'report.html'}, the extended cart {out / 'cart.yaml'}")
    if next_file is not None:
        _write_next(found, next_file, out)
    if as_json:
        print_json(found.report.as_dict())
    else:
        _print(found, is_written=next_file is not None)
    return 0


def _write_next(found: Diagnosis, path: Path, out: Path | None) -> None:
    """A reference for a robot, or `cartgrasp simulate`; nothing where there is none that would tell."""
    if found.next_reference is None:
        say(f"--next {path}: not written: {found.next_experiment.why_none}")
        return
    found.next_reference.save(path)
    then = f"--follow {out} LOG" if out else "this one's logs and LOG (with --out DIR: --follow DIR LOG)"
    say(f"the reference to run next is {path}: let the robot drive it, then add its log: cartgrasp discrepancy {then}")


def _print(found: Diagnosis, is_written: bool) -> None:
    print(found.sentence)
    for one in found.where[:MAX_PLACES_SHOWN]:
        print(f"  {one.sentence}")
    if len(found.where) > MAX_PLACES_SHOWN:
        more = len(found.where) - MAX_PLACES_SHOWN
        print(f"  and {more} more condition{'s' * (more > 1)}, told with --json and on the page of --out")
    for follows in found.unexplained["depends_on"]:
        print(f"  what is left may follow {follows}")
    _print_impacts(found)
    rows = [
        [f"after {horizon}", *(f"{1e3 * values[k]:.1f}" for k in ("before", "refitted", "after", "noise_floor"))]
        for horizon, values in found.gap.per_horizon.items()
    ]
    refit = "refit, not used" if found.is_refused else "refitted"
    print_table("Rollout error on held-out stretches, mm", ["", "nominal", refit, "extended", "noise alone"], rows)
    rows = [
        [name, f"{nominal:.4g}", f"{one.value:.4g}", f"{one.std:.2g}", one.unit, "yes" if one.identifiable else "no"]
        for name, (nominal, one) in found.file_parameters.items()
    ]
    title = f"The cart, refitted {'(refused: the file stays)' if found.is_refused else 'beside what was added'}"
    print_table(title, ["parameter", "in the file", "value", "sd", "unit", "taught"], rows)
    _print_added(found)
    for hint in found.unlisted_wheels:
        print(f"note: {hint}")
    for experiment in found.next_experiment.words[:MAX_PLACES_SHOWN]:
        print(f"next: {experiment}")
    if found.next_reference is not None and not is_written:
        print(
            "--next next.yaml writes that motion for a robot, or `cartgrasp simulate`; then add its log: --follow DIR"
        )


def _print_impacts(found: Diagnosis) -> None:
    rows = [
        [f"{one.time:.2f}", *(f"{v:.3f}" for v in (*one.pose[:2], one.speed_before, one.speed_after))]
        for one in found.impacts[:MAX_IMPACTS_SHOWN]
    ]
    if rows:
        more = (
            f", the first {MAX_IMPACTS_SHOWN} of {len(found.impacts)}" if len(found.impacts) > MAX_IMPACTS_SHOWN else ""
        )
        title = f"Sudden changes of motion that no wrench explains, left out of the fits{more}"
        print_table(title, ["t, s", "x, m", "y, m", "speed before, m/s", "after, m/s"], rows, left=0)


def _print_added(found: Diagnosis) -> None:
    """Effects with their parameters, then those of whom the law alone is known."""
    rows, laws = [], []
    for e in found.effects:
        called, probability, alike = f"{e.name} {e.label}".strip(), f"{e.probability:.2f}", ", ".join(e.alike)
        if e.law is not None:
            laws.append(f"Added {called} (prob. {probability}): {e.law.words}; likely {e.law.likely}")
            continue
        for name, (value, std, unit) in e.parameters.items():
            rows.append([called, probability, name, f"{value:.4g}", f"{std:.2g}", unit, alike])
    if rows:
        print_table("Added", ["effect", "prob.", "parameter", "value", "sd", "unit", "not told apart from"], rows)
    for law in laws:
        print(law)
