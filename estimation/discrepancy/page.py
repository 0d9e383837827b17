"""report.html: one page that opens from disk and loads nothing, and the figures in it.

Names come from logs and cart files, so every text is escaped; the page has no script, and its policy lets none run.
"""

from __future__ import annotations

import html
import io
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cartgrasp.frames import Array

from .where import DIRECTIONS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
UNITS = {"forward_force": "N", "side_force": "N", "yaw_moment": "N·m"}
NO_METADATA = dict.fromkeys(("Creator", "Date", "Format", "Type"))
BEFORE, AFTER, FLOOR = "#d55e00", "#0072b2", "#999999"


def figures(diagnosis: Diagnosis) -> dict[str, str]:
    """SVG texts by name."""
    return {"gap": _svg(_gap(diagnosis)), "residuals": _svg(_residuals(diagnosis)), "places": _svg(_places(diagnosis))}


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
        "<h2>How far simulation goes astray</h2>",
        drawn["gap"],
        _gap_table(found),
        "<h2>What was added</h2>",
        _effects(found),
        "<h2>Where they disagree</h2>",
        _list(
            [one.condition + f" ({one.coordinate.replace('_', ' ')})" for one in found.where], "Nowhere in particular."
        ),
        drawn["residuals"],
        drawn["places"],
        "<h2>What remains</h2>",
        _list(found.unexplained["depends_on"], "Nothing that stands out of the noise."),
        "<h2>Parameters</h2>",
        _parameters(found),
        "<h2>What was tried</h2>",
        _steps(found),
        "<h2>What to measure next</h2>",
        _list(found.next_experiments, "Nothing: the model fits these logs."),
        "<h2>What this motion can show</h2>",
        _isolability(found),
        "<h2>The logs</h2>",
        _checks(found),
        "</body></html>",
    ]
    return "\n".join(parts) + "\n"


def _gap_table(found: Diagnosis) -> str:
    rows = [
        [f"distance after {horizon}, mm", *(f"{1e3 * values[k]:.1f}" for k in _ORDER)]
        for horizon, values in found.gap.per_horizon.items()
    ]
    for coordinate, values in found.gap.per_coordinate.items():
        unit = "mrad" if coordinate == "heading" else "mm"
        rows.append([f"{coordinate} after 1 s, {unit}", *(f"{1e3 * values[k]:.1f}" for k in _ORDER)])
    return _table(["", "nominal", "refitted", "extended", "noise alone"], rows)


_ORDER = ("before", "refitted", "after", "noise_floor")


def _effects(found: Diagnosis) -> str:
    if not found.effects:
        return "<p>Nothing.</p>"
    rows = []
    for effect in found.effects:
        rest = ", ".join(effect.confusable_with) or "-"
        for k, (parameter, (value, std, unit)) in enumerate(effect.parameters.items()):
            first = [f"{effect.name} {effect.label}".strip(), f"{100 * effect.probability:.1f} %", rest]
            interval = f"{value:.4g} ± {1.96 * std:.2g} {unit}"
            rows.append(
                [
                    *(first if k == 0 else ["", "", ""]),
                    parameter,
                    interval,
                    f"{100 * effect.gap_share:.0f} %" if k == 0 else "",
                ]
            )
    return _table(["effect", "probability", "not told apart from", "parameter", "95 % interval", "gap closed"], rows)


def _parameters(found: Diagnosis) -> str:
    rows = [
        [name, f"{one['nominal']:.4g}", f"{one['refitted']:.4g}", f"{1.96 * one['std']:.2g}"]
        for name, one in found.parameter_mismatch.items()
    ]
    return _table(["parameter", "nominal", "refitted", "±95 %"], rows)


def _steps(found: Diagnosis) -> str:
    parts = []
    for i, step in enumerate(found.selection.steps):
        rows = [
            [
                a.key,
                f"{a.log_factor:.1f}",
                "" if a.held_out_gain is None else f"{100 * a.held_out_gain:.1f} %",
                a.verdict,
            ]
            for a in step.attempts
        ]
        parts.append(
            f"<h3>Step {i + 1}</h3>" + _table(["candidate", "log of Bayes factor", "held-out gain", "verdict"], rows)
        )
    return "".join(parts)


def _isolability(found: Diagnosis) -> str:
    rows = [[key, f"{one.z:.1f}", ", ".join(one.alike) or "-"] for key, one in found.selection.isolability.items()]
    return _table(["effect of usual size", "stands out by (deviations)", "looks like"], rows)


def _checks(found: Diagnosis) -> str:
    rows = [
        [
            c.name,
            str(c.rows),
            f"{c.duration:.1f}",
            f"{c.rate:.0f}",
            f"{c.longest_gap:.3f}",
            f"{c.distance:.1f}",
            str(c.reversals),
            f"{c.noise.force:.2g}",
        ]
        for c in found.checks
    ]
    return _table(["log", "rows", "s", "Hz", "longest gap, s", "m", "reversals", "force noise, N"], rows)


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{html.escape(c)}</th>" for c in columns)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def _list(lines: Sequence[str], none: str) -> str:
    if not lines:
        return f"<p>{html.escape(none)}</p>"
    return "<ul>" + "".join(f"<li>{html.escape(line)}</li>" for line in lines) + "</ul>"


def _svg(figure: Figure) -> str:
    import matplotlib as mpl

    buffer = io.StringIO()
    with mpl.rc_context({"svg.hashsalt": "cartgrasp", "svg.fonttype": "none"}):
        figure.savefig(buffer, format="svg", metadata=NO_METADATA, bbox_inches="tight")
    text = buffer.getvalue()
    return text[text.index("<svg") :]


def _gap(found: Diagnosis) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 2.2))
    ax = figure.subplots()
    horizons = found.gap.per_horizon
    names = {"before": ("nominal", "#e69f00"), "refitted": ("refitted", BEFORE), "after": ("extended", AFTER)}
    names["noise_floor"] = ("noise alone", FLOOR)
    place = np.arange(len(horizons))
    for k, (key, (label, colour)) in enumerate(names.items()):
        values = [1e3 * one[key] for one in horizons.values()]
        ax.bar(place + 0.2 * (k - 1.5), values, 0.18, label=label, color=colour)
    ax.set_xticks(place, [f"after {h}" for h in horizons])
    if any(0 < value < np.inf for one in horizons.values() for value in one.values()):
        ax.set_yscale("log")
    ax.set_ylabel("rollout error (mm)")
    ax.legend(frameon=False, ncols=2, fontsize=8)
    return figure


def _residuals(found: Diagnosis) -> Figure:
    from matplotlib.figure import Figure

    coordinates = DIRECTIONS[found.before[0].mean.shape[1]]
    figure = Figure(figsize=(7.2, 1.7 * len(coordinates)))
    axes = figure.subplots(len(coordinates), 1, sharex=True, squeeze=False)[:, 0]
    for i, (ax, coordinate) in enumerate(zip(axes, coordinates, strict=True)):
        for (scatter, _), colour, label in ((found.before, BEFORE, "refitted"), (found.after, AFTER, "extended")):
            ax.plot(scatter.start, scatter.mean[:, i], ".-", lw=0.8, ms=3, color=colour, label=label)
        ax.axhline(0, color="0.6", lw=0.6)
        ax.set_ylabel(f"{coordinate.replace('_', ' ')}\n({UNITS[coordinate]})")
    axes[0].legend(frameon=False, fontsize=8)
    axes[-1].set_xlabel("t (s)")
    return figure


def _places(found: Diagnosis) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 3.0))
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    top = max(float(np.abs(found.before[0].mean[:, 0]).max()), 1e-9)
    shown: Any = None
    for ax, (scatter, course), title in zip(axes, (found.before, found.after), ("refitted", "extended"), strict=True):
        values: Array = scatter.mean[:, 0]
        shown = ax.scatter(*course.place.T, c=values, s=14, cmap="PuOr", vmin=-top, vmax=top)
        ax.set_title(title, fontsize=9)
        ax.set_xlabel("x (m)")
        ax.set_aspect("equal")
    axes[0].set_ylabel("y (m)")
    bar = figure.colorbar(shown, ax=axes, label="forward residual (N)")
    if bar.solids is not None:  # a page that loads nothing shows no images either
        bar.solids.set_rasterized(False)
        bar.solids.set_edgecolor("face")
    return figure
