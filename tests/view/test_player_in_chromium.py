"""The player's page in a browser, where one is found."""

from __future__ import annotations

import html
import re
import socketserver
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from cartgrasp.view.player import write_player
from cartgrasp.view.player_data import frame_indices
from cartgrasp.view.shown_run import ShownRun

from .browser import count_of, needs_browser, run_browser, visit

pytestmark = needs_browser


@pytest.fixture
def page(shown: ShownRun, tmp_path) -> Path:
    return write_player(shown, tmp_path / "run.html", "Two bends")


@pytest.mark.parametrize("time", [12.3, 34.0])
def test_fragment_sets_the_time_and_readouts_follow(time: float, page: Path, shown: ShownRun):
    seen = visit(page, f"t={time}")
    assert seen.console == ()
    assert 'id="problem" role="alert" hidden' in seen.dom
    i = int(np.searchsorted(shown.time, time - 1e-6))
    assert seen.number("time") == time
    assert seen.number("error") == pytest.approx(100 * shown.tracking_error[i], abs=0.02)
    assert seen.number("speed") == pytest.approx(shown.velocity_b[i, 0], abs=0.011)
    assert seen.text("status") == shown.statuses[i]


def test_playing_moves_on(page: Path):
    playing = visit(page, "t=5&play=1", virtual_ms=8000)
    assert playing.console == ()
    assert 5.0 < playing.number("time") <= 13.1  # how many frames come depends on the machine
    assert 'aria-label="Pause"' in playing.dom


PRESSES = """
const pressed = (key, shiftKey) => new KeyboardEvent("keydown", {key, shiftKey, bubbles: true});
const press = (key, shiftKey) => document.body.dispatchEvent(pressed(key, shiftKey));
const times = [];
const note = () => { draw(); times.push(element("time").value); };
press("ArrowRight"); note(); press("ArrowRight", true); note(); press("ArrowLeft"); note();
press("End"); note(); press("Home"); note(); press("."); note(); press(","); note();
element("scrubber").value = 7.5; element("scrubber").dispatchEvent(new Event("input")); note();
press("c"); times.push(camera.mode);
document.querySelector("[data-camera=path]").click(); times.push(camera.mode);
element("rate").value = "4"; element("rate").dispatchEvent(new Event("change")); times.push(player.rate);
element("parameter").selectedIndex = 1; element("parameter").dispatchEvent(new Event("change")); draw();
times.push(element("chart-parameter").querySelector("output").value);
press(" "); times.push(player.playing); element("play").click(); times.push(player.playing);
press("3"); times.push(["overview", "wrenches"].map((name) => element("panel-" + name).hidden).join());
document.title = times.join("|");
"""


def title_after(page: Path, script: str) -> list[str]:
    """The page's title, in parts, after a script that sets it; the policy is taken out for it."""
    text = page.read_text(encoding="utf-8").replace("Content-Security-Policy", "none")
    page.write_text(text.replace("</body>", f"<script>{script}</script></body>"), encoding="utf-8")
    seen = visit(page)
    assert seen.console == ()
    found = re.search("<title>(.*)</title>", seen.dom)
    assert found
    return found[1].split("|")


def test_keys_and_controls(page: Path):
    *noted, parameter, playing, paused, hidden = title_after(page, PRESSES)
    assert noted == ["0.50", "5.50", "5.00", "59.99", "0.00", "0.04", "0.00", "7.50", "heading", "path", "4"]
    assert re.fullmatch(r"0\.\d{3} ± 0\.\d{3}, true 0\.300 m", parameter)
    assert (playing, paused, hidden) == ("true", "false", "true,false")


def test_playing_stops_at_the_end(page: Path, shown: ShownRun):
    script = """
    const seen = [];
    seek(run.stop - 2.5); player.rate = 8; setPlaying(true);
    for (let frame = 0; frame < 2; frame++) { tick(player.last + 200); seen.push(player.time, player.playing); }
    document.title = seen.join("|");
    """
    before, is_playing, end, still = title_after(page, script)
    assert float(before) == pytest.approx(shown.time[-1] - 0.9, abs=0.011)
    assert float(end) == pytest.approx(shown.time[-1], abs=0.011)
    assert (is_playing, still) == ("true", "false")


def test_ellipses_and_columns_are_those_of_python(page: Path, shown: ShownRun):
    script = """
    document.title = [...ellipseOf(0.03, 0.01, -0.6), run.pose[0][700], run.parameters[1].std[700], ...[0, 1, 2].map(
      (i) => unwrapped(Float64Array.of(3.1, -3.1, NaN, -3, 3.1))[i + (i > 1)])].join("|");
    """
    wide, narrow, turn, x, std, *angles = map(float, title_after(page, script))
    across = -0.6 * 0.03 * 0.01
    variances, axes = np.linalg.eigh([[0.03**2, across], [across, 0.01**2]])
    np.testing.assert_allclose([narrow, wide], np.sqrt(variances), rtol=1e-9)
    assert np.tan(turn) == pytest.approx(axes[1, 1] / axes[0, 1])
    row = frame_indices(shown.time)[700]
    assert x == pytest.approx(shown.pose[row, 0], abs=6e-5)
    assert std == pytest.approx(shown.parameters["com_x"].std[row], abs=6e-6)
    np.testing.assert_allclose(angles, [3.1, 2 * np.pi - 3.1, 2 * np.pi - 3.0])


@pytest.mark.some(1)
@pytest.mark.parametrize("camera", ["follow", "heading", "path"])
def test_cart_paths_and_arms_are_painted(camera: str, page: Path, tmp_path):
    shot = tmp_path / "shot.png"
    run_browser(page, f"t=40&camera={camera}", "--virtual-time-budget=1000", f"--screenshot={shot}")
    stage = imread(shot)[60:780, 230:780]  # beside the legend and the charts
    assert count_of("#009e73", stage) > 100, "driven path"
    assert count_of("#0072b2", stage) > 60, "left arm"
    assert count_of("#d55e00", stage) > 40, "right arm"
    assert count_of("#3c4654", stage) > 20, "wheels"


def test_dark_scheme_is_dark(page: Path, tmp_path):
    shot = tmp_path / "dark.png"
    dark = "--blink-settings=preferredColorScheme=0"
    run_browser(page, "t=20", "--virtual-time-budget=1000", f"--screenshot={shot}", dark)
    assert np.median(imread(shot)[..., :3]) < 0.2


def test_bare_and_gappy_runs_are_shown(bare: ShownRun, tmp_path):
    pose = bare.pose.copy()
    pose[:300] = np.nan
    late = np.where(bare.time < 4, bare.time, bare.time + 3)
    page = write_player(replace(bare, pose=pose, time=late), tmp_path / "bare.html", "Bare")
    seen = visit(page, "t=1")
    assert seen.console == ()
    assert seen.text("error") == "–"
    assert seen.text("speed") != "–"
    assert visit(page, "t=5").text("speed") == "–"  # no row between 4 and 7 s
    assert visit(page, "t=8").number("error") > 0


def test_one_row_is_a_run_too(shown: ShownRun, tmp_path):
    first = slice(0, 1)
    single = replace(
        shown,
        time=shown.time[first],
        pose=shown.pose[first],
        velocity_b=shown.velocity_b[first],
        reference_pose=shown.reference_pose[first],
        contacts={a: c[first] for a, c in shown.contacts.items()},
        wrenches={a: w[first] for a, w in shown.wrenches.items()},
        parameters={},
        caster_headings=None,
        statuses=("optimal",),
    )
    seen = visit(write_player(single, tmp_path / "single.html", "One row"), "play=1")
    assert seen.console == ()
    assert seen.number("time") == 0.0


def test_hostile_names_stay_text(shown: ShownRun, tmp_path):
    name = "</script><script>document.title = 'owned'</script><img src=x onerror=\"document.title = 'owned'\">"
    names = (name, "__proto__", "constructor")
    hostile = replace(
        shown,
        name=name,
        cart=replace(shown.cart, name=name),
        contacts=dict.fromkeys(names, shown.contacts["left"]),
        wrenches=dict.fromkeys(names, shown.wrenches["left"]),
        parameters={name: replace(shown.parameters["mass"], unit=name)},
        statuses=(name,) * len(shown.time),
        healths=(name,) * len(shown.time),
    )
    seen = visit(write_player(hostile, tmp_path / "hostile.html", name), "t=20")
    assert seen.console == ()
    assert "<img" not in seen.dom
    assert seen.dom.count("<script") == 2
    assert "owned" in seen.text("status")
    assert "owned" in seen.text("health")
    assert html.escape(name, quote=False) in seen.dom


def test_an_estimate_that_is_not_ok_is_told_beside_it(shown: ShownRun, tmp_path):
    """In words and along the timeline, where it is so and nowhere else."""
    n = len(shown.time)
    healths = tuple("inconsistent" if i > n // 2 else "ok" for i in range(n))
    path = write_player(replace(shown, healths=healths), tmp_path / "run.html", "Doubtful")
    script = """
    const strip = element("strip");
    const line = strip.getContext("2d").getImageData(0, strip.height - 2, strip.width, 1).data;
    const part = (name, k) => parseInt(ink[name].slice(1 + 2 * k, 3 + 2 * k), 16);
    const apart = (name, x) =>
      [0, 1, 2].reduce((sum, k) => sum + Math.abs(part(name, k) - line[4 * Math.round(x * strip.width) + k]), 0);
    const nearest = (x) => ["good", "fair", "poor"].sort((a, b) => apart(a, x) - apart(b, x))[0];
    const found = [];
    for (const t of [10, 50]) {
      seek(t); draw();
      const beside = element("chart-parameter").querySelector("output").value.split(" \u00b7 ")[1];
      found.push(element("health").value, beside, nearest(t / run.stop));
    }
    document.title = found.join("|");
    """
    assert title_after(path, script) == ["ok", "", "good", "inconsistent", "inconsistent", "poor"]


def test_policy_stops_what_gets_in(page: Path):
    """The control of the tests above: what they listen for does speak, and the policy does bite."""
    text = page.read_text(encoding="utf-8")
    intruder = "<script>document.title = 'owned'</script><img src='http://127.0.0.1:9/x.png'></body>"
    page.write_text(text.replace("</body>", intruder), encoding="utf-8")
    seen = visit(page)
    assert "<title>Two bends</title>" in seen.dom
    assert len(seen.console) >= 2
    assert "blocked" in seen.text("problem")


@pytest.mark.parametrize("charts", ["motion", "parameters"])
def test_tabs_show_their_charts(charts: str, page: Path, shown: ShownRun):
    seen = visit(page, f"t=20&charts={charts}")
    assert seen.console == ()
    for name in ("overview", "motion", "wrenches", "parameters"):
        hidden = re.search(rf'id="panel-{name}"[^>]*hidden', seen.dom)
        assert (hidden is None) == (name == charts)
    count = {"motion": 4, "parameters": len(shown.parameters)}[charts]
    panel = seen.dom.split(f'id="panel-{charts}"')[1].split('role="tabpanel"')[0]
    assert panel.count("<figure") == count


def test_values_under_the_cursor_are_those_of_the_run(page: Path, shown: ShownRun):
    seen = visit(page, "t=20&charts=wrenches")
    i = int(np.searchsorted(shown.time, 20 - 1e-6))
    found = [float(v.replace("−", "-")) for v in re.findall(r"[ft][xyz]<output[^>]*>([^<]*)<", seen.dom)]
    wanted = [shown.wrenches[arm][i, k] for arm in ("left", "right") for k in (0, 1, 2, 5, 3, 4)]
    np.testing.assert_allclose(found, wanted, atol=0.051)


@contextmanager
def eavesdropper() -> Iterator[tuple[str, list[str]]]:
    """A proxy that answers nothing, and the first line of whatever asked it."""
    asked: list[str] = []

    class Note(socketserver.StreamRequestHandler):
        def handle(self) -> None:
            asked.append(self.rfile.readline().decode("latin-1"))

    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Note) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"--proxy-server=127.0.0.1:{server.server_address[1]}", asked
        server.shutdown()


def test_no_request_leaves(page: Path, tmp_path):
    telling = tmp_path / "telling.html"
    telling.write_text("<img src='http://cartgrasp.invalid/x.png'>", encoding="utf-8")
    for opened, leaves in ((page, False), (telling, True)):
        with eavesdropper() as (proxy, asked):
            run_browser(opened, "t=1&play=1", "--virtual-time-budget=3000", "--dump-dom", proxy)
        ours = [line for line in asked if not re.search(r"google|gstatic", line)]  # what browsers ask on their own
        assert bool(ours) == leaves, asked


def test_absurd_rows_do_not_stop_the_page(shown: ShownRun, tmp_path):
    pose, contact, wrench = shown.pose.copy(), shown.contacts["left"].copy(), shown.wrenches["left"].copy()
    for values, row in ((pose, 3000), (contact, 2997), (wrench, 3000)):
        values[row] = 1e10
        values[row + 1] = 1e300
    absurd = replace(shown, pose=pose, contacts={"left": contact}, wrenches={"left": wrench}, cart=None, parameters={})
    page = write_player(absurd, tmp_path / "absurd.html", "Absurd")
    for fragment in ("t=30", "t=40&camera=path"):
        seen = visit(page, fragment)
        assert seen.console == ()
        assert seen.number("time") == float(fragment[2:4])
