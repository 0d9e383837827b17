"""`cartgrasp view`: what it writes, what it refuses, and that nothing of a log runs in its page."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from cartgrasp.logs import read_log, write_log
from tests.view.browser import needs_browser, visit
from tests.view.offscreen import needs_opengl

from .commands import CART, ROOT, run
from .pushed_cart import HEADER, as_csv, pushed_cart

OWN = "document['title']='owned'"
HOSTILE = f"></script><script>{OWN}</script><img src=x onerror={OWN}>"


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "push.csv"
    path.write_text(as_csv(pushed_cart()[:400]), encoding="utf-8")
    (tmp_path / "cart.yaml").write_text(CART, encoding="utf-8")
    return path


def data_of(page):
    return json.loads(re.search(r'id="run">(.*?)</script>', page.read_text(encoding="utf-8"))[1])


def test_a_log_alone_gets_a_page_beside_it(log, capsys):
    answer = run(capsys, "view", log)
    assert (answer.status, answer.out) == (0, "")
    data = data_of(log.with_suffix(".html"))
    assert data["title"] == "push.csv"
    assert [arm["name"] for arm in data["arms"]] == ["left", "right"]
    assert data["cart"]["com"] is data["reference"] is None
    assert data["parameters"] == []


def test_with_a_cart_the_estimate_is_run_over_it(log, capsys):
    page = log.with_name("out.html")
    answer = run(capsys, "view", log, "--cart", log.with_name("cart.yaml"), "--out", page, "--json")
    assert answer.json == {"page": {"path": str(page), "bytes": page.stat().st_size}}
    data = data_of(page)
    assert {"mass", "com_x", "com_y"} <= {p["name"] for p in data["parameters"]}
    assert all(len(p["std"]) > data["frames"] for p in data["parameters"] if p["name"] in ("mass", "com_y"))
    correlation = np.cumsum([0 if c is None else c for c in data["correlation"][1:]]) / 1000
    assert np.abs(correlation).max() <= 1
    assert len(data["casters"]) == 2
    assert data["health"]["words"] == ["ok"]


@pytest.mark.parametrize(("kind", "begins"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_figures(kind, begins, log, capsys):
    figure = log.with_name(f"figure.{kind}")
    answer = run(capsys, "view", log, f"--{kind}", figure, "--json")
    assert list(answer.json) == [kind]
    assert figure.read_bytes().startswith(begins)
    assert not log.with_suffix(".html").exists()


@needs_opengl
def test_scene(log, capsys):
    scene = log.with_name("scene.png")
    answer = run(capsys, "view", log, "--cart", log.with_name("cart.yaml"), "--scene", scene, "--json")
    assert answer.json == {"scene": {"path": str(scene), "bytes": scene.stat().st_size}}
    assert scene.read_bytes().startswith(b"\x89PNG")


def test_what_it_refuses(log, tmp_path, capsys):
    run(capsys, "view", log, "--png", tmp_path / "figure.gif").refused(2, "--png", ".png")
    run(capsys, "view", log, "--scene", tmp_path / "scene.mp4").refused(2, "--scene", ".png or .gif")
    run(capsys, "view", log, "--out", log).refused(2, "is read by this command")
    run(capsys, "view", log, "--out", tmp_path / "nowhere" / "page.html").refused(2, "there is no folder")
    run(capsys, "view", tmp_path / "none.csv").refused(3, "there is no such file")


def test_the_snippet_of_the_docs(log, monkeypatch):
    docs = (ROOT / "docs" / "command_line.md").read_text(encoding="utf-8")
    (snippet,) = (code for code in re.findall(r"```python\n(.*?)```", docs, re.DOTALL) if "ShownRun" in code)
    (log.parent / "run.csv").write_text(as_csv(pushed_cart()[:600]), encoding="utf-8")
    monkeypatch.chdir(log.parent)
    exec(compile(snippet, "command_line.md", "exec"), {})
    assert (log.parent / "figure.pdf").read_bytes().startswith(b"%PDF")


@needs_browser
def test_nothing_of_a_log_runs(log, capsys):
    hostile = log.with_name(HOSTILE.replace("/", "") + ".csv")
    header = [column.replace("left.", HOSTILE + ".") for column in HEADER]
    hostile.write_text(as_csv(pushed_cart()[:200], header), encoding="utf-8")
    page = log.with_name("hostile.html")
    assert run(capsys, "view", hostile, "--out", page).status == 0
    assert data_of(page)["arms"][0]["name"] == HOSTILE
    seen = visit(page, "t=1&charts=wrenches")
    assert seen.console == ()
    assert re.search("<title>(.*?)</title>", seen.dom)[1] != "owned"
    assert "<img" not in seen.dom
    assert seen.dom.count("<script") == 2


def test_a_bag_is_shown_as_its_log_is(log, capsys):
    bag = write_log(read_log(log), log.with_suffix(".mcap"))
    for path, page in ((log, "log.html"), (bag, "bag.html")):
        assert run(capsys, "view", path, "--out", log.with_name(page)).status == 0
    shown, again = (data_of(log.with_name(page)) for page in ("log.html", "bag.html"))
    assert [arm["name"] for arm in again["arms"]] == [arm["name"] for arm in shown["arms"]]
    assert again["arms"][0]["force"] == shown["arms"][0]["force"]
