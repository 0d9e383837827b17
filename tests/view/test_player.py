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

from cartgrasp.logs.run_log import ArmLog
from cartgrasp.simulation.record import RunRecord, Series
from cartgrasp.view.player import player_page, write_player
from cartgrasp.view.player_data import MOST_FRAMES, body_outline, column, frame_indices, player_data
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


def named(record: RunRecord, name: str) -> RunRecord:
    """The run with every word that a log or a cart could bring replaced by `name`."""
    arm = record.log.arms["left"]
    return replace(
        record,
        log=replace(record.log, arms={name: ArmLog(arm.contact, arm.wrench)}, name=name),
        cart=replace(record.cart, name=name),
        parameters={name: replace(record.parameters["mass"], unit=name)},
        statuses=(name,) * len(record.time),
    )


def expanded(values, n: int) -> np.ndarray:
    return np.array(values if isinstance(values, list) else [values] * n, dtype=float)


def test_page_holds_the_run(record: RunRecord):
    data = Page(player_page(record, "A push")).data
    frames = frame_indices(record.time)
    n = len(data["time"])
    np.testing.assert_allclose(data["time"], record.time[frames], atol=1e-9)
    for i in range(3):
        np.testing.assert_allclose(expanded(data["pose"][i], n), record.pose[frames, i], atol=5.1e-5)
    np.testing.assert_allclose(expanded(data["error"], n), 100 * record.tracking_error[frames], atol=5.1e-4)
    np.testing.assert_allclose(expanded(data["speed"], n), record.velocity[frames, 0], atol=5.1e-4)
    assert [arm["name"] for arm in data["arms"]] == ["left", "right"]
    for arm in data["arms"]:
        truth = record.wrenches[arm["name"]][frames]
        np.testing.assert_allclose(expanded(arm["force"][0], n), truth[:, 0], atol=5.1e-3)
        np.testing.assert_allclose(expanded(arm["moment"], n), truth[:, 5], atol=5.1e-4)
    assert data["arms"][1]["contact"] == [-0.25, -0.22]
    assert len(data["casters"]) == 2
    assert [p["name"] for p in data["parameters"]] == list(record.parameters)


def test_policy_allows_this_script_and_this_style_alone(record: RunRecord):
    page = Page(player_page(record, "A push"))
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


def test_page_names_nothing_to_load(record: RunRecord):
    text = player_page(record, "A push")
    page = Page(text)
    assert not [(t, a) for t, a in page.elements if {"src", "href", "style", "srcset"} & a.keys()]
    assert not [a for _, attributes in page.elements for a in attributes if a.startswith("on")]
    assert not re.search(r"https?:|url\(|@import|fetch\(|XMLHttp|innerHTML|eval\(", text)


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_names_do_not_break_out(name: str, record: RunRecord):
    plain, hostile = Page(player_page(record, "A push")), Page(player_page(named(record, name), name))
    assert hostile.elements[1:] == plain.elements[1:]
    assert hostile.policy == plain.policy
    data = hostile.data
    assert data["title"] == data["run"] == data["cart"]["name"] == data["arms"][0]["name"] == name
    assert data["parameters"][0]["unit"] == data["status"]["words"][0] == name
    raw = hostile.all("script")[0]
    assert raw.isascii()
    assert not set("<>&") & set(raw)
    player_page(named(record, name), name).encode("utf-8")


def test_sixty_seconds_stay_under_a_megabyte(record: RunRecord):
    assert record.log.duration > 59
    assert len(player_page(record, "A push").encode()) < 1_000_000


def test_missing_samples_are_null(record: RunRecord):
    pose = record.pose.copy()
    pose[100:500] = np.nan
    wrench = record.wrenches["left"].copy()
    wrench[:, 0] = np.inf
    unknown = Series(*np.full((2, len(record.time)), np.nan), None, "m")
    gappy = replace(
        record,
        pose=pose,
        wrenches={"left": wrench},
        parameters={"com_x": unknown},
    )
    page = Page(player_page(gappy, "Gaps"))
    data = page.data
    gap = [i for i, t in enumerate(data["time"]) if 1.0 <= t < 4.995]
    assert gap
    assert all(data["pose"][0][i] is None and data["error"][i] is None for i in gap)
    assert data["pose"][0].count(None) == len(gap)
    assert data["arms"][0]["force"][0] is None
    assert data["parameters"][0]["value"] is None
    assert data["parameters"][0]["truth"] is None
    assert not re.search(r"NaN|Infinity", page.all("script")[0])


def test_bare_run_falls_back(bare_record: RunRecord):
    data = player_data(bare_record, "Bare")
    assert data["casters"] is None
    assert data["status"] is None
    assert data["parameters"] == []
    # Without a true wrench the measured one is shown.
    np.testing.assert_allclose(
        expanded(data["arms"][0]["force"][0], len(data["time"])),
        bare_record.log.arms["only"].wrench[frame_indices(bare_record.time), 0],
        atol=5.1e-3,
    )


def test_box_without_wheels_has_the_inertia_of_the_cart(bare_record: RunRecord):
    x0, x1, y0, y1 = body_outline(bare_record.cart)
    inertia = bare_record.cart.inertia
    of_box = inertia.mass * ((x1 - x0) ** 2 + (y1 - y0) ** 2) / 12
    assert of_box == pytest.approx(inertia.about_com)
    assert ((x0 + x1) / 2, (y0 + y1) / 2) == pytest.approx(inertia.com)


def test_body_holds_all_wheels_and_is_never_flat(record: RunRecord):
    x0, x1, y0, y1 = body_outline(record.cart)
    assert all(x0 < w.x < x1 and y0 < w.y < y1 for w in record.cart.wheels)
    x0, x1, y0, y1 = body_outline(replace(record.cart, wheels=(Wheel("fixed", 0.3, 0.05),)))
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
    assert len(frames) <= min(MOST_FRAMES + 1, 30 * (time[-1] - time[0]) + 3)
    step = max(1 / 30, (time[-1] - time[0]) / (MOST_FRAMES - 1))
    skipped = np.diff(frames) > 1
    assert (np.diff(time[frames])[skipped] <= 2 * step + 1e-6).all()


def test_a_single_bad_plan_is_not_thinned_away(record: RunRecord):
    for bad in (1, 1234, 5998):
        statuses = ["optimal"] * len(record.time)
        statuses[bad] = "infeasible"
        status = player_data(replace(record, statuses=tuple(statuses)), "One bad plan")["status"]
        assert status["words"] == ["optimal", "infeasible"]
        assert status["grades"] == [0, 2]
        assert sum(status["index"]) == 1


def test_fewer_plans_than_steps_are_spread_over_the_run(record: RunRecord):
    data = player_data(replace(record, statuses=("optimal", "relaxed", "relaxed")), "Three plans")
    relaxed = [t for t, i in zip(data["time"], data["status"]["index"], strict=True) if i == 1]
    assert min(relaxed) == pytest.approx(20.0, abs=0.05)
    assert max(relaxed) == data["time"][-1]


def test_columns():
    assert column([1.00001, 1.00002]) == 1.0
    assert column([1.0, 2.0]) == [1.0, 2.0]
    assert column([np.nan, np.nan]) is None
    assert column([np.nan, 2.0]) == [None, 2.0]
    assert str(column([-1e-9, -1e-9])) == "0.0"


def test_caster_headings_of_another_count_are_left_out(record: RunRecord):
    assert player_data(replace(record, caster_headings=np.zeros((len(record.time), 1))), "")["casters"] is None


def test_written_page_is_the_page(record: RunRecord, tmp_path):
    path = write_player(record, tmp_path / "run.html", "A push")
    assert path.read_text(encoding="utf-8") == player_page(record, "A push")
    assert [p.name for p in tmp_path.iterdir()] == ["run.html"]
