"""`cartgrasp view RUN`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from estimation import CartFilter
from estimation.log_noise.log_noise import noise_of_log
from estimation.log_noise.sentinel_values import without_sentinels
from estimation.whole_log.coasting import prior_of, with_known_wrench
from estimation.whole_log.replay import replay

from ..cart_file import load_cart
from ..errors import UsageError
from ..logs import RunLog, read_log
from ..model import CartModel
from ..motion import Estimate
from ..view.player import write_player
from ..view.shown_run import ShownRun
from .output import check_writable, print_json, progress, say


@dataclass(frozen=True)
class Pictures:
    """Where they go; None is not drawn. A page is written where nothing else is asked for."""

    page: Path | None
    png: Path | None
    svg: Path | None
    pdf: Path | None
    gif: Path | None
    scene: Path | None

    def checked(self, log: Path, *read: Path | None) -> dict[str, Path]:
        """By kind; refused before any work if one can't be written or would replace what is read."""
        given = {"png": self.png, "svg": self.svg, "pdf": self.pdf, "gif": self.gif, "scene": self.scene}
        wanted = {kind: path for kind, path in given.items() if path is not None}
        for kind, path in wanted.items():
            endings = (".png", ".gif") if kind == "scene" else (f".{kind}",)
            if path.suffix.lower() not in endings:
                raise UsageError(f"--{kind} {path}: give a name that ends in {' or '.join(endings)}")
        if self.page is not None or not wanted:
            wanted["page"] = self.page or log.with_suffix(".html")
        for path in wanted.values():
            check_writable(path, log, *read)
        return wanted


def run(path: Path, cart_path: Path | None, topics: Path | None, pictures: Pictures, as_json: bool) -> int:
    wanted = pictures.checked(path, cart_path, topics)
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
    told = with_known_wrench(log)
    cart_filter = CartFilter(cart, list(told.arms), noise=noise_of_log(told, cart), prior=prior_of([log], cart))
    with progress(f"estimating from {log.name}") as tell:
        return replay(told, cart_filter, tell).estimates


def _write(shown: ShownRun, wanted: dict[str, Path], title: str) -> None:
    page, gif, scene = wanted.get("page"), wanted.get("gif"), wanted.get("scene")
    if page is not None:
        write_player(shown, page, title)
    for kind in ("png", "svg", "pdf"):
        if kind in wanted:
            from ..view.figures import figure_overview, save_figure

            save_figure(figure_overview(shown.averaged()), wanted[kind])
    if gif is not None:
        from ..view.animation import write_gif

        with progress(f"drawing {gif.name}") as tell:
            write_gif(shown, gif, tell)
    if scene is not None:
        from ..view.rendering import write_scene

        with progress(f"rendering {scene.name}") as tell:
            write_scene(shown, scene, tell)
