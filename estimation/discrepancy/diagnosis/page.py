"""report.html: one page that opens from disk and loads nothing.

Names come from logs and cart files, so every text is escaped; the page has no script, and its policy lets none run.
"""

from __future__ import annotations

import html
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from ..findings.named_effects import grouped, with_unit, words_of
from ..findings.verdicts import verdict
from ..log_check import HEADING_SECTORS, LogCheck
from ..where.residual import RESIDUAL_UNITS
from ..where.where import short

if TYPE_CHECKING:
    from .diagnosis import Diagnosis
    from .report import Report

CONTENT_SECURITY_POLICY = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"
PAGE_STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #1c2430; }
h1 { font-size: 1.4rem; } h2 { font-size: 1.1rem; margin-top: 2rem; } pre { background: #f1f5f9; padding: .5rem; }
.verdict { font-size: 1.15rem; padding: .8rem 1rem; border-left: .3rem solid #0072b2; background: #f1f5f9; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: .2rem .8rem; border-bottom: 1px solid #dde3ea; vertical-align: top; }
th:first-child, td:first-child, .text td, .text th { text-align: left; } td { white-space: pre-line; }
svg { max-width: 100%; height: auto; }
.wide { overflow-x: auto; }
"""
ONE_STD = "(± one standard deviation)"
LOG_SPECIFIC_LAW_TEXTS = {
    "time": "The law of time counts by this log's clock: another log tells its own.",
    "travelled_distance": "The law of the way counts from where this log began: another log begins at another turn of "
    "a wheel, and tells its own.",
}
"""What is said of laws that several logs share only if they begin alike."""
NEXT_COMMANDS = """cartgrasp discrepancy NEXT_LOG.csv --cart cart.yaml --out next
cartgrasp simulate --cart cart.yaml --path straight --out run"""
SECTION_TEXTS = {
    "added": "The probability is that of the name, among all that was tried: on logs whose truth is known, so many "
    "such names are true. What is not told apart explains about as much, by more numbers. The gap is that of squared "
    "rollout errors above noise, which each closed when it was added, before all were fitted together.",
    "drive": "Then drive, to decide what these logs leave open. With --next next.yaml the command that made this page "
    "writes that motion as a reference, and --follow DIR, this folder, takes its log beside these:",
    "residuals": "What the arms gave, less what the model needs, row by row. Refitted is the cart of the file with its "
    "numbers fitted to these logs, extended is that with what was added. Grey: ± one standard deviation of noise.",
    "follows": "Dots are rows, lines their means in bins; bars are ± one standard deviation.",
    "laws": "Left the forces that rows ask for, all else taken away, with the law's curve and its band (± one standard "
    "deviation of its numbers and its phase, not of what finer ones would add); right what it leaves of them. Rows are "
    "means over some 0.2 s, which round off what is shorter.",
    "rollouts": "Simulated from where the cart was, with the recorded wrenches, by what was learned from other "
    "stretches; nominal is the cart as its file has it.",
    "gap": "Root mean square over all unseen stretches.",
    "isolability": "What effects of usual size would do on this motion, in standard deviations that the rest can't do.",
    "steps": "Gain of the expected log predictive density, less what oddness costs; without ± where it was looked at "
    "alone, and not fitted with all else.",
    "impacts": "Sudden changes of motion that no wrench explains; fits leave them out. Three at one place are a stop.",
}


def page(report: Report, drawn: dict[str, str]) -> str:
    found = report.diagnosis
    name = html.escape(found.nominal_cart.name)
    logs = html.escape(", ".join(check.name for check in found.checks))
    parts = [
        "<!doctype html>",
        '<html lang="en"><head><meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{CONTENT_SECURITY_POLICY}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{name}: simulation against measurement</title><style>{PAGE_STYLE}</style></head><body>",
        f"<h1>{name}: simulation against measurement</h1><p>{logs}</p>",
        f'<p class="verdict">{html.escape(found.sentence)}</p>',
        *(f"<h2>{heading}</h2>\n{text}" for heading, text in _sections(found, drawn) if text),
        "</body></html>",
    ]
    return "\n".join(parts) + "\n"


def _sections(found: Diagnosis, drawn: dict[str, str]) -> Iterator[tuple[str, str]]:
    """Headings with what stands below; nothing, where there is nothing to tell."""
    nowhere = "Whenever it moves, about as much." if found.disagrees else "Nowhere: the model fits these logs."
    yield "What to do next", _next(found)
    yield "What was added", _effects(found)
    yield "Where they disagree", _list([one.sentence for one in found.where], nowhere) + _drawn(drawn, "residuals")
    yield "What the residual follows", _drawn(drawn, "follows") + drawn.get("places", "")
    yield "The law" if len(found.final.laws) == 1 else "The laws", _drawn(drawn, "laws")
    yield "Unseen stretches, measured and simulated", _drawn(drawn, "rollouts")
    yield "How far simulation goes astray", _drawn(drawn, "gap") + _gap_table(found)
    yield "Where it was hit", _impacts(found)
    yield "What remains", _rest(found)
    yield "Parameters", _parameters(found)
    yield "What was tried", _steps(found)
    yield "What this motion can show", _isolability(found)
    yield "The logs", "".join(_table(["", check.name], _check_rows(check)) for check in found.checks)


def _next(found: Diagnosis) -> str:
    """What a reader does next: sensors first, then the cart, then what to drive."""
    if found.is_refused or not found.is_moved:
        what = "the cart as it was given: these logs teach nothing better"
    else:
        what = "the extended cart" if found.effects else "the cart with refitted numbers, and nothing added"
    use = (
        f"cart.yaml beside this page is {what}. Every command takes it. In this folder, the first of these holds it "
        "against your next log, and the second simulates it:"
    )
    own = dict.fromkeys(LOG_SPECIFIC_LAW_TEXTS[law.of] for law in found.final.laws if law.of in LOG_SPECIFIC_LAW_TEXTS)
    first = "<p>Look at this first: where a sensor is wrong, so is all below.</p>" if found.warnings else ""
    words = found.next_experiment.words
    drive = SECTION_TEXTS["drive"] if words else "Nothing is left open."
    told = f"<p>{' '.join((*own, use))}</p><pre>{NEXT_COMMANDS}</pre><p>{drive}</p>{_list(words)}"
    return first + _list(found.warnings) + told


def _drawn(drawn: dict[str, str], name: str) -> str:
    return f"<p>{SECTION_TEXTS[name]}</p>{drawn[name]}" if name in drawn else ""


def _gap_table(found: Diagnosis) -> str:
    errors = {f"distance after {horizon}, mm": values for horizon, values in found.gap.per_horizon.items()}
    for coordinate, values in found.gap.per_coordinate.items():
        errors[f"{coordinate} after 1 s, {'mrad' if coordinate == 'heading' else 'mm'}"] = values
    told = ("before", "refitted", "after", "noise_floor")
    rows = [[name, *(f"{1e3 * values[k]:.1f}" for k in told)] for name, values in errors.items()]
    heads = [
        "",
        "nominal: as in the file",
        "refitted",
        "extended by what was added, or given another size",
        "noise of a perfect model",
    ]
    return _table(heads, rows)


def _effects(found: Diagnosis) -> str:
    rows = []
    for group in grouped(found.effects):
        one, law = group[0], group[0].law
        told = [_valued(name, *numbers) for name, numbers in one.parameters.items()]
        size = [words_of(group, alike=False), f"likely {law.likely}"] if law else told
        names, alike = ", ".join(each.called for each in group), ", ".join(one.alike) or "-"
        chance = f"{100 * one.probability:.0f} %" if one.probability < 0.99 else "> 99 %"  # none is certain
        rows.append([names, "\n".join(size), chance, alike, f"{100 * one.gap_share:.0f} %"])
    columns = ["effect", f"size {ONE_STD}", "probability", "not told apart from", "gap closed"]
    return f"<p>{SECTION_TEXTS['added']}</p>{_table(columns, rows, 'text')}" if rows else "<p>Nothing.</p>"


def _valued(name: str, value: float, std: float, unit: str) -> str:
    return with_unit(f"{name} {value:.4g}" + (f" ± {short(std)}" if std else ""), unit)


def _impacts(found: Diagnosis) -> str:
    told = [(one.time, (*one.pose[:2], one.speed_before, one.speed_after)) for one in found.impacts]
    rows = [[f"{time:.2f}", *(f"{value:.3f}" for value in values)] for time, values in told]
    columns = ["t, s", "x, m", "y, m", "speed before, m/s", "speed after, m/s"]
    return f"<p>{SECTION_TEXTS['impacts']}</p>" + _table(columns, rows) if rows else ""


def _rest(found: Diagnosis) -> str:
    is_told = found.verdict in ("no_discrepancy", "explained")
    sizes = found.unexplained["size"].items()
    rest = [f"{size:.2g} {RESIDUAL_UNITS[of]} of {of.replace('_', ' ')}" for of, size in sizes if size]
    follows = [f"it may follow {words}" for words in found.unexplained["depends_on"]]
    none = "Nothing that stands out of the noise." if is_told else "Rollouts go astray, and rows do not tell of what."
    return _list([*rest, *follows], none)


def _parameters(found: Diagnosis) -> str:
    rows = [
        [name, f"{nominal:.4g}", f"{one.value:.4g} ± {short(one.std)} {one.unit}", "yes" if one.identifiable else "no"]
        for name, (nominal, one) in found.file_parameters.items()
    ]
    words = "Fitted together with what was added." if found.effects else "Refitted."
    if found.is_refused:
        words += " A refit predicts unseen stretches no better, and the file's values stay."
    fitted = "extended" if found.effects else "refitted"
    table = _table(["parameter", "in the file", f"{fitted} {ONE_STD}", "taught by these logs"], rows)
    return f"<p>{words}</p>{table}"


def _steps(found: Diagnosis) -> str:
    parts = [f"<p>{SECTION_TEXTS['steps']}</p>"] if found.steps else []
    for i, step in enumerate(found.steps, 1):
        gains = ((one, f"{one.gain:.1f}" + (f" ± {one.error:.1f}" if one.error else "")) for one in step.attempts)
        rows = [[one.key, gain, verdict(step, one, found.final)] for one, gain in gains]
        parts.append(f"<h3>Step {i}</h3>" + _table(["candidate", f"gain, nats {ONE_STD}", "verdict"], rows, "text"))
    return "".join(parts)


def _isolability(found: Diagnosis) -> str:
    rows = [[key, f"{one.z:.1f}", ", ".join(one.alike) or "-"] for key, one in found.isolability.items()]
    columns = ["effect of usual size", "stands out by", "looks like"]
    return f"<p>{SECTION_TEXTS['isolability']}</p>{_table(columns, rows, 'text')}" if rows else ""


def _check_rows(check: LogCheck) -> list[list[str]]:
    late, speeds = check.clock_offset, ", ".join(f"{speed:.2f}" for speed in check.speeds)
    units = ("m/s²", "rad/s²") if len(check.accelerations) < 3 else ("m/s²", "m/s²", "rad/s²")
    hard = ", ".join(f"{a:.2g} {unit}" for a, unit in zip(check.accelerations, units, strict=False))
    return [
        ["rows, with every wrench", f"{check.rows}, {check.rows_with_wrenches}"],
        ["poses written twice, left out", f"{check.stale_poses}"],
        ["duration", f"{check.duration:.1f} s at {check.rate:.0f} Hz, longest gap {check.longest_gap:.3f} s"],
        ["noise of position, heading", f"{1e3 * check.noise.position:.2g} mm, {1e3 * check.noise.heading:.2g} mrad"],
        ["noise of force, moment, sample to sample", f"{check.noise.force:.2g} N, {check.noise.moment:.2g} N·m"],
        [
            f"wrenches late by {ONE_STD}",
            f"{1e3 * late.value:.1f} ± {short(1e3 * late.std)} ms" if late else "not known",
        ],
        ["way, turning", f"{check.distance:.1f} m, {check.turned:.1f} rad, {check.reversals} reversals"],
        ["time on the move", f"{100 * check.moving:.0f} %"],
        ["speeds (a tenth, half, nine tenths slower)", f"{speeds}, at most {check.fastest:.2f} m/s"],
        ["headings", f"{check.headings} of {HEADING_SECTORS} directions"],
        ["accelerations (nineteen of twenty less)", hard],
    ]


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]], kind: str = "numbers") -> str:
    head = "".join(f"<th>{html.escape(c)}</th>" for c in columns)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f'<div class="wide {kind}"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def _list(lines: Sequence[str], none: str = "") -> str:
    if not lines:
        return f"<p>{none}</p>" if none else ""
    return "<ul>" + "".join(f"<li>{html.escape(line)}</li>" for line in lines) + "</ul>"
