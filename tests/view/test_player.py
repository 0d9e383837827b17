"""The player's page as text: what it holds, that it stays closed, and that it stays small."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cartgrasp.simulation.record import RunRecord, Series
from cartgrasp.view.player import player_page, write_player
from cartgrasp.view.player_data import MAX_PLAYER_FRAMES, column, frame_indices, player_data
from cartgrasp.view.shown_run import ShownRun, body_outline
from cartgrasp.wheels import Wheel

HOSTILE = (
    "</script><script>alert(1)</script>",
    "<!--<script>",
    "]]><img src=x onerror=alert(1)>",
    "\"'><svg onload=alert(1)>",
    "&lt;b&gt; &amp; $title ${data} @@",
    "__proto__",
    "\u2028\u2029\x00\ud800",
)


class Page(HTMLParser):
    """Elements with their attributes, and the text in scripts, styles and the title."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[tuple[str, str]] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag in ("script", "style", "title"):
            self.texts.append((tag, ""))

    def handle_data(self, data):
        if self.elements and self.texts and self.elements[-1][0] == self.texts[-1][0]:
            tag, text = self.texts[-1]
            self.texts[-1] = (tag, text + data)

    def handle_endtag(self, tag):
        self.elements.append(("/" + tag, {}))

    def all(self, tag: str) -> list[str]:
        return [text for name, text in self.texts if name == tag]

    @property
    def data(self):
        return json.loads(self.all("script")[0])

    @property
    def policy(self) -> dict[str, str]:
        metas = [a for tag, a in self.elements if tag == "meta"]
        content = next(a["content"] for a in metas if a.get("http-equiv") == "Content-Security-Policy")
        return dict(part.strip().split(" ", 1) for part in content.split(";"))


def named(run: ShownRun, name: str) -> ShownRun:
    """The run with every word that a log or a cart could bring replaced by `name`."""
    return replace(
        run,
        name=name,
        cart=replace(run.cart, name=name),
        contacts={name: run.contacts["left"]},
        wrenches={name: run.wrenches["left"]},
        parameters={name: replace(run.parameters["mass"], unit=name)},
        statuses=(name,) * len(run.time),
        healths=(name,) * len(run.time),
    )


def expanded(packed, n: int) -> np.ndarray:
    """A column as the page reads it."""
    if not isinstance(packed, list):
        return np.full(n, np.nan if packed is None else packed)
    decimals, *steps = packed
    assert len(steps) == n
    whole = np.cumsum([0 if step is None else step for step in steps])
    return np.where([step is None for step in steps], np.nan, whole / 10.0**decimals)


def test_page_holds_the_run(shown: ShownRun):
    data = Page(player_page(shown, "A push")).data
    frames = frame_indices(shown.time)
    n = data["frames"]
    np.testing.assert_allclose(expanded(data["time"], n), shown.time[frames], atol=1e-9)
    for i in range(3):
        np.testing.assert_allclose(expanded(data["pose"][i], n), shown.pose[frames, i], atol=5.1e-5)
    np.testing.assert_allclose(expanded(data["error"], n), 100 * shown.tracking_error[frames], atol=5.1e-4)
    for i in range(3):
        np.testing.assert_allclose(expanded(data["velocity"][i], n), shown.velocity_b[frames, i], atol=5.1e-4)
    assert [arm["name"] for arm in data["arms"]] == ["left", "right"]
    for arm in data["arms"]:
        truth = shown.wrenches[arm["name"]][frames]
        np.testing.assert_allclose(expanded(arm["force"][0], n), truth[:, 0], atol=5.1e-3)
        np.testing.assert_allclose(expanded(arm["force"][2], n), truth[:, 2], atol=5.1e-3)
        np.testing.assert_allclose(expanded(arm["moment"][2], n), truth[:, 5], atol=5.1e-4)
    assert data["arms"][1]["contact"] == [-0.25, -0.22]
    mass = shown.parameters["mass"]
    np.testing.assert_allclose(expanded(data["parameters"][0]["value"], n), mass.value[frames], atol=5.1e-4)
    np.testing.assert_allclose(expanded(data["parameters"][0]["std"], n), mass.std[frames], atol=5.1e-4)
    assert len(data["casters"]) == 2
    assert [p["name"] for p in data["parameters"]] == list(shown.parameters)


def test_policy_allows_this_script_and_this_style_alone(shown: ShownRun):
    page = Page(player_page(shown, "A push"))
    (style,) = page.all("style")
    _, script = page.all("script")

    def source(text: str) -> str:
        return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"

    assert page.policy == {
        "default-src": "'none'",
        "script-src": source(script),
        "style-src": source(style),
        "base-uri": "'none'",
        "form-action": "'none'",
    }
    # The policy stands before everything that it governs.
    tags = [tag for tag, _ in page.elements]
    assert tags.index("meta") < min(tags.index("style"), tags.index("script"))


def test_page_names_nothing_to_load(shown: ShownRun):
    text = player_page(shown, "A push")
    page = Page(text)
    assert not [(t, a) for t, a in page.elements if {"src", "href", "style", "srcset"} & a.keys()]
    assert not [a for _, attributes in page.elements for a in attributes if a.startswith("on")]
    assert not re.search(r"https?:|url\(|@import|fetch\(|XMLHttp|innerHTML|eval\(", text)


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_names_do_not_break_out(name: str, shown: ShownRun):
    plain, hostile = Page(player_page(shown, "A push")), Page(player_page(named(shown, name), name))
    assert hostile.elements[1:] == plain.elements[1:]
    assert hostile.policy == plain.policy
    data = hostile.data
    assert data["title"] == data["run"] == data["cart"]["name"] == data["arms"][0]["name"] == name
    assert data["parameters"][0]["unit"] == data["status"]["words"][0] == data["health"]["words"][0] == name
    raw = hostile.all("script")[0]
    assert raw.isascii()
    assert not set("<>&") & set(raw)
    player_page(named(shown, name), name).encode("utf-8")


def test_sixty_seconds_stay_under_a_megabyte(shown: ShownRun):
    """Four arms and a dozen parameters, and no number twice the same."""
    noise = np.random.default_rng(0)
    n = len(shown.time)
    arms = [f"arm{i}" for i in range(4)]
    value = 20 + np.cumsum(noise.normal(size=(12, n)), axis=1)
    hard = replace(
        shown,
        contacts={arm: noise.normal(size=(n, 3)) for arm in arms},
        wrenches={arm: 50 * noise.normal(size=(n, 6)) for arm in arms},
        parameters={f"effect{i}.parameter": Series(v, np.abs(v), None, "m") for i, v in enumerate(value)},
        velocity_b=shown.velocity_b + noise.normal(size=(n, 3)),
    )
    assert shown.time[-1] - shown.time[0] > 59
    assert len(player_page(hard, "A push").encode()) < 1_000_000
    assert len(player_page(shown, "A push").encode()) < 250_000


def test_missing_samples_are_null(shown: ShownRun):
    pose = shown.pose.copy()
    pose[100:500] = np.nan
    wrench = shown.wrenches["left"].copy()
    wrench[:, 0] = np.inf
    unknown = Series(*np.full((2, len(shown.time)), np.nan), None, "m")
    gappy = replace(
        shown,
        pose=pose,
        wrenches={**shown.wrenches, "left": wrench},
        parameters={"com_x": unknown},
    )
    page = Page(player_page(gappy, "Gaps"))
    data = page.data
    gap = [i for i, t in enumerate(expanded(data["time"], data["frames"])) if 1.0 <= t < 4.995]
    assert gap
    missing = [i for i, step in enumerate(data["pose"][0][1:]) if step is None]
    assert missing == gap
    assert [i for i, step in enumerate(data["error"][1:]) if step is None] == gap
    assert data["arms"][0]["force"][0] is None
    assert data["parameters"][0]["value"] is None
    assert data["parameters"][0]["truth"] is None
    assert not re.search(r"NaN|Infinity", page.all("script")[0])


def test_bare_run_falls_back(bare: ShownRun, bare_record: RunRecord):
    data = player_data(bare, "Bare")
    assert data["casters"] is None
    assert data["status"] is data["health"] is None
    assert data["parameters"] == []
    # Without a true wrench the measured one is shown.
    np.testing.assert_allclose(
        expanded(data["arms"][0]["force"][0], data["frames"]),
        bare_record.log.arms["only"].wrench[frame_indices(bare.time), 0],
        atol=5.1e-3,
    )


def test_box_without_wheels_has_the_inertia_of_the_cart(bare: ShownRun):
    x0, x1, y0, y1 = bare.outline
    inertia = bare.cart.inertia
    of_box = inertia.mass * ((x1 - x0) ** 2 + (y1 - y0) ** 2) / 12
    assert of_box == pytest.approx(inertia.about_com)
    assert ((x0 + x1) / 2, (y0 + y1) / 2) == pytest.approx(inertia.com)


def test_body_holds_all_wheels_and_is_never_flat(shown: ShownRun):
    x0, x1, y0, y1 = shown.outline
    assert all(x0 < w.x < x1 and y0 < w.y < y1 for w in shown.cart.wheels)
    x0, x1, y0, y1 = body_outline(replace(shown.cart, wheels=(Wheel("fixed", 0.3, 0.05),)), [])
    assert min(x1 - x0, y1 - y0) == pytest.approx(0.3)


@pytest.mark.parametrize(
    "time",
    [
        np.array([3.0]),
        np.array([0.0, 0.001]),
        np.linspace(0, 2, 7),
        np.arange(0, 10, 0.001),
        np.concatenate([np.arange(0, 1, 0.01), np.arange(50, 51, 0.01)]),
        1.7e9 + np.arange(0, 1000, 0.01),
    ],
)
def test_frames_keep_both_ends_and_the_video_rate(time: np.ndarray):
    frames = frame_indices(time)
    assert frames[0] == 0
    assert frames[-1] == len(time) - 1
    assert (np.diff(frames) > 0).all()
    assert len(frames) <= min(MAX_PLAYER_FRAMES + 1, 30 * (time[-1] - time[0]) + 3)
    step = max(1 / 30, (time[-1] - time[0]) / (MAX_PLAYER_FRAMES - 1))
    skipped = np.diff(frames) > 1
    assert (np.diff(time[frames])[skipped] <= 2 * step + 1e-6).all()


def test_a_single_bad_plan_is_not_thinned_away(shown: ShownRun):
    for bad in (1, 1234, 5998):
        statuses = ["optimal"] * len(shown.time)
        statuses[bad] = "infeasible"
        status = player_data(replace(shown, statuses=tuple(statuses)), "One bad plan")["status"]
        assert status["words"] == ["optimal", "infeasible"]
        assert status["grades"] == [0, 2]
        assert sum(status["index"]) == 1


def test_fewer_plans_than_steps_are_spread_over_the_run(shown: ShownRun):
    data = player_data(replace(shown, statuses=("optimal", "relaxed", "relaxed")), "Three plans")
    time = expanded(data["time"], data["frames"])
    relaxed = [t for t, i in zip(time, data["status"]["index"], strict=True) if i == 1]
    assert min(relaxed) == pytest.approx(20.0, abs=0.05)
    assert max(relaxed) == time[-1]


def test_columns():
    assert column([1.00001, 1.00002]) == 1.0
    assert column([1.0, 2.5, 2.0], 1) == [1, 10, 15, -5]
    assert column([np.nan, np.nan]) is None
    assert column([np.nan, 2.0, np.inf, 1.0], 0) == [0, None, 2, None, -1]
    assert column([1e300, 2.0], 0) == [0, None, 2]
    assert str(column([-1e-9, -1e-9])) == "0.0"


@given(arrays(float, 40, elements=st.floats(-1e6, 1e6)), st.integers(0, 5))
def test_columns_come_back_to_half_of_their_last_decimal(values: np.ndarray, decimals: int):
    np.testing.assert_allclose(expanded(column(values, decimals), 40), values, rtol=1e-12, atol=0.501 * 10.0**-decimals)


def test_caster_headings_of_another_count_are_left_out(shown: ShownRun):
    assert player_data(replace(shown, caster_headings=np.zeros((len(shown.time), 1))), "")["casters"] is None


def test_written_page_is_the_page(shown: ShownRun, tmp_path):
    path = write_player(shown, tmp_path / "run.html", "A push")
    assert path.read_text(encoding="utf-8") == player_page(shown, "A push")
    assert [p.name for p in tmp_path.iterdir()] == ["run.html"]
