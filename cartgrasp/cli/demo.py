"""`cartgrasp demo`: the main job, end to end, on MuJoCo; then with casters and rolling resistance left out."""

from __future__ import annotations

from pathlib import Path

from estimation import CartFilter

from ..cart_file import save_cart
from ..studies.run_figures import RunFigures
from ..studies.shopping_cart import first_guess, loaded_cart, scenario
from .artefacts import save_run
from .output import make_folder, print_json, print_table, progress, say
from .run_tables import print_health, print_run
from .warm_up import prepare


def run(out: Path, as_json: bool, seed: int, quick: bool) -> int:
    make_folder(out)
    prepare(CartFilter)
    with progress("pushing a loaded cart in MuJoCo", tells_begin=True) as tell:
        record = scenario(True, quick, seed).run(tell)
    with progress("again, with casters and rolling resistance left out of the model", tells_begin=True) as tell:
        poorer = scenario(False, quick, seed).run(tell)
    with progress("drawing", tells_begin=True) as tell:
        save_run(record, out, "Two arms push a loaded shopping cart")
        tell(0.5)
        save_run(poorer, out, "The same, with casters and rolling resistance left out", prefix="left_out_")
    save_cart(loaded_cart(), out / "true_cart.yaml")
    save_cart(first_guess(), out / "first_guess.yaml")
    with_effects, without = RunFigures.of(record), RunFigures.of(poorer)
    if as_json:
        print_json({"run": with_effects.as_dict(), "left_out": without.as_dict(), "out": str(out), "seed": seed})
    else:
        print_run(with_effects, "Two arms push a cart of unknown load, in MuJoCo with real casters")
        _print_cost(with_effects, without)
    say(f"open {out / 'player.html'} to watch; log, figures and carts are beside it")
    return 0


def _print_cost(full: RunFigures, poorer: RunFigures) -> None:
    rows = []
    for name in ("mass", "com_x", "com_y", "inertia", "viscous_drag.linear"):
        a, b = full.parameters[name], poorer.parameters[name]
        cells = (f"{p['value']:.3g} ± {p['std']:.1g}" for p in (a, b))
        rows.append([f"{name} ({a['unit']})", f"{a['truth']:.3g}", *cells])
    rows.append(["health of the estimate", "", *(f.health for f in (full, poorer))])
    rows.append(["largest tracking error (cm)", "", *(f"{100 * f.largest_error:.2f}" for f in (full, poorer))])
    title = "What it costs to leave casters and rolling resistance out of the model"
    print_table(title, ["± one standard deviation", "truth", "in the model", "left out"], rows)
    print_health(poorer.health, "the model without them")
