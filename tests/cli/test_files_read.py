"""All that a log is read from: its map, and the tables that the map names, beside the log itself."""

from __future__ import annotations

import hashlib
import json
from types import SimpleNamespace

import pytest

from cartgrasp.cli import discrepancy

from ..logs import bag_files as files
from .commands import CART, run
from .pushed_cart import HEADER, as_csv, pushed_cart

MAP = """\
time: {column: t, unit: s}
pose:
  x: {column: x, unit: m}
  y: {column: y, unit: m}
  theta: {column: theta, unit: rad}
arms:
  left: &hand
    file: hands/both.csv
    time: {column: t, unit: s}
    contact: [-0.25, 0.2, 1.0]
    force: on_cart
    measures: [fx, fy, tz]
    fx: {column: left.fx, unit: N}
    fy: {column: left.fy, unit: N}
    tz: {column: left.tz, unit: N·m}
    unmeasured: zero
  right:
    <<: *hand
    contact: [-0.25, -0.2, 1.0]
    fx: {column: right.fx, unit: N}
    fy: {column: right.fy, unit: N}
    tz: {column: right.tz, unit: N·m}
"""


@pytest.fixture
def table(tmp_path):
    """Poses in a file, wrenches in another, and a map beside."""
    rows = pushed_cart()
    (tmp_path / "hands").mkdir()
    for name, columns in (("mine.csv", HEADER[:4]), ("hands/both.csv", ("t", *HEADER[7:]))):
        (tmp_path / name).write_text(as_csv(rows[:, [HEADER.index(c) for c in columns]], columns), encoding="utf-8")
    (tmp_path / "mine.csv.topics.yaml").write_text(MAP, encoding="utf-8")
    (tmp_path / "cart.yaml").write_text(CART, encoding="utf-8")
    (tmp_path / "run.csv").write_text(as_csv(pushed_cart(seed=1)), encoding="utf-8")
    return tmp_path / "mine.csv"


@pytest.mark.parametrize("name", ["hands/both.csv", "mine.csv.topics.yaml", "mine.csv", "cart.yaml"])
def test_nothing_that_is_read_is_written_over(capsys, table, name):
    read, cart = table.parent / name, table.with_name("cart.yaml")
    before = read.read_bytes()
    for command, option in (("estimate", "--out"), ("discrepancy", "--next"), ("view", "--out")):
        run(capsys, command, table, "--cart", cart, option, read).refused(2, f"{read}: is read by this command")
    if name != "cart.yaml":  # which a conversion doesn't read
        run(capsys, "convert", table, "--out", read).refused(2, f"{read}: is read by this command")
    assert read.read_bytes() == before


def test_provenance_has_the_sums_of_all(capsys, table):
    assert run(capsys, "convert", table, "--out", table.with_name("out.csv")).status == 0
    told = json.loads(table.with_name("out.csv.provenance.json").read_text(encoding="utf-8"))["source"]
    read = [table, table.with_name("mine.csv.topics.yaml"), table.with_name("hands") / "both.csv"]
    assert told["name"] == "mine.csv"
    assert told["files"] == [{"name": p.name, "sha256": hashlib.sha256(p.read_bytes()).hexdigest()} for p in read]


def reported(capsys, monkeypatch, log, *options):
    """The folder of a report, as if the cart had been diagnosed."""
    told = SimpleNamespace(save=lambda _: None, as_dict=dict)
    monkeypatch.setattr(discrepancy, "diagnose", lambda *_, **__: SimpleNamespace(report=told))
    out = log.with_name("report")
    answer = run(capsys, "discrepancy", log, "--cart", log.with_name("cart.yaml"), "--out", out, *options, "--json")
    assert answer.status == 0, answer.err
    return out


@pytest.mark.some(2)
@pytest.mark.parametrize("name", ["mine.csv.topics.yaml", "hands/both.csv"])
@pytest.mark.parametrize("given", [False, True])
def test_a_report_follows_only_what_is_as_it_was(capsys, monkeypatch, table, name, given):
    read, new = table.parent / name, table.with_name("run.csv")
    options = ("--topics", table.with_name("mine.csv.topics.yaml")) if given else ()
    out = reported(capsys, monkeypatch, table, *options)
    assert run(capsys, "discrepancy", new, "--follow", out, "--json").status == 0
    text = read.read_text(encoding="utf-8")
    read.write_text(text + "\n", encoding="utf-8")
    run(capsys, "discrepancy", new, "--follow", out).refused(3, f"{name}: the ", "has changed since", "make the report")
    read.unlink()
    run(capsys, "discrepancy", new, "--follow", out).refused(3, f"{name}: the ", "is gone")


def test_maps_of_bags_are_followed_too(capsys, monkeypatch, table):
    bag = files.write_mcap(table.with_name("push.mcap"), files.push())
    for name in ("topics.yaml", "push.mcap.topics.yaml"):
        read = bag.with_name(name)
        read.write_text(files.MAP, encoding="utf-8")
        out = reported(capsys, monkeypatch, bag)
        read.write_text(files.MAP + "\n", encoding="utf-8")
        refused = run(capsys, "discrepancy", table.with_name("run.csv"), "--follow", out)
        refused.refused(3, f"{name}: the map or table", "has changed since")
