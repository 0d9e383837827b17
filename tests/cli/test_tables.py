"""Tables fit where they are shown, and no word of theirs is broken while there is room."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len

from cartgrasp.cli.output import _widths, print_table
from cartgrasp.cli.run_tables import print_parameters
from cartgrasp.effects import KNOWN_EFFECTS
from cartgrasp.motion import ParameterEstimate

from .commands import ROOT

STUDY = "by `cartgrasp study"
RESULTS = [path for path in sorted((ROOT / "docs" / "results").glob("*.md")) if STUDY in path.read_text()]


def markdown_tables(text):
    """Columns and rows of each."""
    table = []
    for line in [*text.splitlines(), ""]:
        if line.startswith("|"):
            table.append([cell.strip() for cell in line.strip().strip("|").split(" | ")])
        elif table:
            yield table[0], table[2:]
            table = []


def printed(capsys, monkeypatch, *arguments, columns=80):
    monkeypatch.setenv("COLUMNS", str(columns))
    print_table(*arguments)
    out = capsys.readouterr().out
    assert max(map(cell_len, out.splitlines())) <= columns
    return out


def test_there_are_tables_of_studies():
    assert len(RESULTS) > 4


@pytest.mark.parametrize("path", RESULTS, ids=lambda path: path.stem)
def test_tables_of_studies_fit_80_columns(capsys, monkeypatch, path):
    for columns, rows in markdown_tables(path.read_text(encoding="utf-8")):
        out = printed(capsys, monkeypatch, "", columns, rows)
        for row in rows:
            assert set(row[0].split()) <= set(out.split())


def test_parameters_of_every_effect_fit_80_columns(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    learned = {
        f"{kind.name}.{parameter.name}": ParameterEstimate(-12345.678, 0.00012345, parameter.unit, True)
        for kind in KNOWN_EFFECTS.values()
        for parameter in kind().parameters
    }
    print_parameters("t", learned, "taught by this motion")
    out = capsys.readouterr().out
    assert max(map(cell_len, out.splitlines())) <= 80
    for name, one in learned.items():
        assert f"{name} " in out
        assert f"{one.unit} " in out


def test_a_cell_is_data(capsys, monkeypatch):
    out = printed(capsys, monkeypatch, "[bold]t[/]", ["[red]a"], [["[/x] 人"]])
    assert all(part in out for part in ("[bold]t[/]", "[red]a", "[/x] 人"))


CELL = st.text(st.sampled_from("ab 人"), max_size=30)


@given(data=st.data(), count=st.integers(1, 6), room=st.integers(20, 120))
def test_widths(data, count, room):
    columns, *rows = data.draw(st.lists(st.tuples(*[CELL] * count), min_size=1, max_size=4))
    widths, gap = _widths(columns, rows, room)
    cells = [[column, *(row[i] for row in rows)] for i, column in enumerate(columns)]
    natural = [max(map(cell_len, column)) for column in cells]
    words = [max((cell_len(word) for cell in column for word in cell.split()), default=1) for column in cells]
    total, gaps = sum(widths) + gap * (count - 1), gap * (count - 1)
    assert all(width <= most for width, most in zip(widths, natural, strict=True))
    assert total <= max(room, count + gaps)
    if sum(natural) + 2 * (count - 1) <= room:
        assert widths == natural
    if sum(words) + count - 1 <= room:
        assert all(width >= min(word, most) for width, word, most in zip(widths, words, natural, strict=True))
