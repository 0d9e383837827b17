"""report.html: one page that opens from disk and loads nothing.

Names come from logs and cart files, so every text is escaped; the page has no script, and its policy lets none run.
"""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import TYPE_CHECKING

from .log_check import EIGHTHS, LogCheck
from .residual import UNITS
from .verdicts import verdict
from .where import short

if TYPE_CHECKING:
    from .diagnosis import Diagnosis
    from .report import Report

POLICY = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"
STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #1c2430; }
h1 { font-size: 1.4rem; } h2 { font-size: 1.1rem; margin-top: 2rem; }
.verdict { font-size: 1.15rem; padding: .8rem 1rem; border-left: .3rem solid #0072b2; background: #f1f5f9; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: .2rem .8rem; border-bottom: 1px solid #dde3ea; }
th:first-child, td:first-child, .text { text-align: left; }
svg { max-width: 100%; height: auto; }
.wide { overflow-x: auto; }
"""


ONE_STD = "(± one standard deviation)"


def page(report: Report, drawn: dict[str, str]) -> str:
    found = report.diagnosis
    name = html.escape(found.nominal_cart.name)
    logs = html.escape(", ".join(check.name for check in found.checks))
    parts = [
        "<!doctype html>",
        '<html lang="en"><head><meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{name}: simulation against measurement</title><style>{STYLE}</style></head><body>",
        f"<h1>{name}: simulation against measurement</h1><p>{logs}</p>",
        f'<p class="verdict">{html.escape(found.sentence)}</p>',
        *(f"<h2>{heading}</h2>\n{text}" for heading, text in _sections(found, drawn).items() if text),
        "</body></html>",
    ]
    return "\n".join(parts) + "\n"


def _sections(found: Diagnosis, drawn: dict[str, str]) -> dict[str, str]:
    """By heading; empty where there is nothing to tell."""
    nowhere = "Everywhere about as much." if found.disagrees else "Nowhere: the model fits these logs."
    agrees = "Nothing: the model fits these logs."
    sizes = found.unexplained["size"].items()
    rest = [f"{size:.2g} {UNITS[of]} of {of.replace('_', ' ')}" for of, size in sizes if size]
    is_told = found.verdict in ("no_discrepancy", "explained")
    noise = "Nothing that stands out of the noise." if is_told else "Rollouts go astray, and rows do not tell of what."
    return {
        "What the sensors seem to do": _list(found.warnings),
        "How far simulation goes astray": drawn["gap"] + _gap_table(found),
        "What was added": _effects(found) + drawn.get("laws", ""),
        "Where they disagree": _list([one.sentence for one in found.where], nowhere)
        + drawn["residuals"]
        + "<p>Means over half a second, of the refitted nominal model and of the extended one; dotted where the size "
        "of the former changes.</p>" + drawn["places"],
        "What the residual depends on": drawn.get("maps", "")
        + "<p>Means ± one standard deviation, in bins that hold as many stretches each.</p>",
        "Where it was hit": _impacts(found),
        "What remains": _list([*rest, *found.unexplained["depends_on"]], noise),
        "Parameters": _parameters(found),
        "What was tried": _steps(found),
        "What to measure next": _list(found.next_experiment.words, agrees),
        "What this motion can show": drawn.get("isolability", "")
        + "<p>How much effects of usual size look like one another on this motion (dark: alike), beside the deviations "
        "by which each stands out; grey ones do not show. Of two that are marked (=) the log can't tell which.</p>"
        + _isolability(found),
        "The logs": "".join(_table(["", check.name], _check_rows(check)) for check in found.checks),
    }


def _gap_table(found: Diagnosis) -> str:
    errors = {f"distance after {horizon}, mm": values for horizon, values in found.gap.per_horizon.items()}
    for coordinate, values in found.gap.per_coordinate.items():
        errors[f"{coordinate} after 1 s, {'mrad' if coordinate == 'heading' else 'mm'}"] = values
    told = ("before", "refitted", "after", "noise_floor")
    rows = [[name, *(f"{1e3 * values[k]:.1f}" for k in told)] for name, values in errors.items()]
    return _table(["", "nominal", "refitted", "extended", "noise alone"], rows)


def _effects(found: Diagnosis) -> str:
    rows = []
    for effect in found.effects:
        name, rest = f"{effect.name} {effect.label}".strip(), ", ".join(effect.confusable_with) or "-"
        head = [name, f"{100 * effect.probability:.1f} %", rest]
        share = f"{100 * effect.gap_share:.0f} %"
        if effect.law is not None:
            rows.append(
                [
                    *head,
                    f"{len(effect.parameters)} amplitudes",
                    f"{effect.law.words}; likely {effect.law.likely}",
                    share,
                ]
            )
            continue
        for parameter, (value, std, unit) in effect.parameters.items():
            rows.append([*head, parameter, f"{value:.4g} ± {std:.2g} {unit}".rstrip(" -"), share])
            head, share = ["", "", ""], ""
    columns = ["effect", "probability", "not told apart from", "parameter", f"value {ONE_STD}", "gap closed"]
    return _table(columns, rows) if rows else "<p>Nothing.</p>"


def _impacts(found: Diagnosis) -> str:
    """Where the cart was hit, if it was."""
    told = [(one.time, (*one.pose[:2], one.speed_before, one.speed_after)) for one in found.impacts]
    rows = [[f"{time:.2f}", *(f"{value:.3f}" for value in values)] for time, values in told]
    words = "Sudden changes of motion that no wrench explains; fits leave them out. Three at one place are a stop."
    columns = ["t, s", "x, m", "y, m", "speed before, m/s", "speed after, m/s"]
    return f"<p>{words}</p>" + _table(columns, rows) if rows else ""


def _parameters(found: Diagnosis) -> str:
    rows = [
        [name, f"{nominal:.4g}", f"{one.value:.4g} ± {one.std:.2g} {one.unit}", "yes" if one.identifiable else "no"]
        for name, (nominal, one) in found.file_parameters.items()
    ]
    words = "Refitted beside what was added. A refit predicts unseen stretches no better, and the file's values stay."
    table = _table(["parameter", "in the file", f"refitted {ONE_STD}", "taught by these logs"], rows)
    return f"<p>{words if found.is_refused else words.partition('. ')[0] + '.'}</p>{table}"


def _steps(found: Diagnosis) -> str:
    parts = []
    for i, step in enumerate(found.steps):
        rows = [[one.key, f"{one.gain:.1f}", verdict(step, one)] for one in step.attempts]
        parts.append(f"<h3>Step {i + 1}</h3>" + _table(["candidate", "score gain (nats)", "verdict"], rows))
    return "".join(parts)


def _isolability(found: Diagnosis) -> str:
    rows = [[key, f"{one.z:.1f}", ", ".join(one.alike) or "-"] for key, one in found.isolability.items()]
    return _table(["effect of usual size", "stands out by (deviations)", "looks like"], rows)


def _check_rows(check: LogCheck) -> list[list[str]]:
    late, speeds = check.clock_offset, ", ".join(f"{speed:.2f}" for speed in check.speeds)
    units = ("m/s²", "rad/s²") if len(check.accelerations) < 3 else ("m/s²", "m/s²", "rad/s²")
    hard = ", ".join(f"{a:.2g} {unit}" for a, unit in zip(check.accelerations, units, strict=False))
    return [
        ["rows, with every wrench", f"{check.rows}, {check.rows_with_wrenches}"],
        ["poses written twice, left out", f"{check.stale_poses}"],
        ["duration", f"{check.duration:.1f} s at {check.rate:.0f} Hz, longest gap {check.longest_gap:.3f} s"],
        ["noise of position, heading", f"{1e3 * check.noise.position:.2g} mm, {1e3 * check.noise.heading:.2g} mrad"],
        ["noise of force, moment", f"{check.noise.force:.2g} N, {check.noise.moment:.2g} N·m"],
        [
            f"wrenches late by {ONE_STD}",
            f"{1e3 * late.value:.1f} ± {short(1e3 * late.std)} ms" if late else "not known",
        ],
        ["way, turning", f"{check.distance:.1f} m, {check.turned:.1f} rad, {check.reversals} reversals"],
        ["time on the move", f"{100 * check.moving:.0f} %"],
        ["speeds (a tenth, half, nine tenths slower)", f"{speeds}, at most {check.fastest:.2f} m/s"],
        ["headings", f"{check.headings} of {EIGHTHS} directions"],
        ["accelerations (nineteen of twenty less)", hard],
    ]


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{html.escape(c)}</th>" for c in columns)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def _list(lines: Sequence[str], none: str = "") -> str:
    if not lines:
        return f"<p>{none}</p>" if none else ""
    return "<ul>" + "".join(f"<li>{html.escape(line)}</li>" for line in lines) + "</ul>"
