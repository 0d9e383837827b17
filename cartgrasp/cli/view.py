"""`cartgrasp view RUN`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from estimation.log_noise.sentinel_values import without_sentinels
from estimation.whole_log.coasting import with_known_wrench
from estimation.whole_log.replay import estimated

from ..cart_file import load_cart
from ..errors import UsageError
from ..logs import RunLog, files_of, read_log
from ..model import CartModel
from ..motion import Estimate
from ..view.player import write_player
from ..view.shown_run import ShownRun
from .output import check_writable, print_json, progress, say


def run(
    path: Path, cart_path: Path | None, topics: Path | None, asked: Mapping[str, Path | None], as_json: bool
) -> int:
    """`asked` tells where pictures go, by kind: png, svg, pdf, gif, scene and page, which is written where nothing is
    asked for, too."""
    wanted = {kind: one for kind, one in asked.items() if one is not None} or {"page": path.with_suffix(".html")}
    for kind, one in wanted.items():
        endings = (".png", ".gif") if kind == "scene" else (f".{kind}",)
        if kind != "page" and one.suffix.lower() not in endings:
            raise UsageError(f"--{kind} {one}: give a name that ends in {' or '.join(endings)}")
    for one in wanted.values():
        check_writable(one, cart_path, topics, *files_of(path, topics))
    cart = None if cart_path is None else load_cart(cart_path)
    log = without_sentinels(read_log(path, topics)).thinned()
    shown = ShownRun.of_log(log, cart, _estimates(log, cart))
    _write(shown, wanted, path.name)
    if as_json:
        print_json({kind: {"path": str(one), "bytes": one.stat().st_size} for kind, one in wanted.items()})
    for one in wanted.values():
        say(f"{one}: {one.stat().st_size / 1e3:.0f} kB")
    return 0


def _estimates(log: RunLog, cart: CartModel | None) -> tuple[Estimate, ...]:
    if cart is None:
        return ()
    with progress(f"estimating from {log.name}") as tell:
        return estimated(with_known_wrench(log), cart, progress=tell).estimates


def _write(shown: ShownRun, wanted: Mapping[str, Path], title: str) -> None:
    if "page" in wanted:
        write_player(shown, wanted["page"], title)
    for kind in ("png", "svg", "pdf"):
        if kind in wanted:
            from ..view.figures import figure_overview, save_figure

            save_figure(figure_overview(shown.averaged()), wanted[kind])
    if "gif" in wanted:
        from ..view.animation import write_gif

        with progress(f"drawing {wanted['gif'].name}") as tell:
            write_gif(shown, wanted["gif"], tell)
    if "scene" in wanted:
        from ..view.rendering import write_scene

        with progress(f"rendering {wanted['scene'].name}") as tell:
            write_scene(shown, wanted["scene"], tell)
