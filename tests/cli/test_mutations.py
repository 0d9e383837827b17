"""Random mutations of good files through the commands: an exit status of the contract, never a traceback."""

from __future__ import annotations

import re

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cartgrasp.cli import main

from .commands import CART, MORE, PROBLEM, Answer, problem_file
from .pushed_cart import as_csv, pushed_cart

VALUES = ["0", "-1", "1", "3", "-0.0", "0.001", "50", "1.0e3", "1.0e6", "1.0e12", "1.0e200", "-1.0e308", "1.0e-320"]
WORDS = [".nan", "-.inf", "[]", "{}", "null", "~", "", "true", "'x'", "exact", "[1, 2]", "{a: 1}", "é", "9" * 30]
MARKS = ["\t", ":", "- ", "[", "]", "{", "}", "\n", "&a ", "*a", "!!set ", '"', "'", "#", "\0", "\u2028", " ", ","]
CELLS = ["nan", "", "inf", "0", "0.5", "-1", "1e9", "1e20", "1e155", "-1e200", "1e308", "1e-320", "abc", '"', ","]


@st.composite
def changed_yaml(draw, text):
    """A number replaced, a bit of text replaced, a line taken out or put twice, or a key renamed."""
    for _ in range(draw(st.sampled_from([1, 1, 1, 2]))):
        kind = draw(st.sampled_from(["number", "number", "number", "marks", "line", "word"]))
        numbers = [m.span() for m in re.finditer(r"-?\d+(\.\d+)?", text)]
        if kind == "number" and numbers:
            start, stop = draw(st.sampled_from(numbers))
            text = text[:start] + draw(st.sampled_from(VALUES + WORDS)) + text[stop:]
        elif kind == "marks":
            at = draw(st.integers(0, len(text)))
            text = text[:at] + draw(st.sampled_from(MARKS)) + text[at + draw(st.integers(0, 3)) :]
        elif kind == "line":
            lines = text.split("\n")
            i = draw(st.integers(0, len(lines) - 1))
            lines[i : i + 1] = draw(st.sampled_from([[], [lines[i]] * 2]))
            text = "\n".join(lines)
        else:
            words = sorted(set(re.findall(r"[a-z_]+", text)))
            assume(words)
            text = text.replace(draw(st.sampled_from(words)), draw(st.sampled_from(words)), 1)
    return text


LOG = as_csv(pushed_cart()[40:100])


@st.composite
def changed_log(draw):
    table = [row.split(",") for row in LOG.splitlines()]
    for _ in range(draw(st.sampled_from([1, 1, 2]))):
        i = draw(st.integers(0, len(table) - 1))
        table[i][draw(st.integers(0, len(table[i]) - 1))] = draw(st.sampled_from(CELLS))
    return "\n".join(",".join(row) for row in table)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("mutations")


@pytest.fixture
def answer(capsys):
    """Runs a command, as often as hypothesis likes."""

    def run(*arguments):
        capsys.readouterr()
        status = main([*map(str, arguments), "--json"])
        return Answer(status, *capsys.readouterr())

    return run


def check(answer, statuses, keys):
    assert answer.status in statuses
    if answer.status < 2:
        assert keys <= set(answer.json)
        assert answer.err == ""
    elif answer.out:
        assert answer.json["status"] == "invalid_input"
    else:
        answer.refused(answer.status)


FUZZ = settings(suppress_health_check=["function_scoped_fixture"])  # capsys is emptied by hand


@pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning")  # of the planner, from contacts at 1e200 m
@FUZZ
@given(text=changed_yaml(PROBLEM))
def test_problems(folder, answer, text):
    check(answer("plan", problem_file(folder, text)), (0, 1, 2), {"status", "arms", "certificate"})


@FUZZ
@given(text=changed_yaml(MORE))
def test_problems_with_every_key(folder, answer, text):
    check(answer("plan", problem_file(folder, text)), (0, 1, 2), {"status", "arms", "certificate"})


@FUZZ
@given(text=changed_yaml(CART))
def test_carts(folder, answer, text):
    check(answer("plan", problem_file(folder, PROBLEM, text)), (0, 1, 2), {"status", "arms"})


@FUZZ
@given(text=changed_log(), method=st.sampled_from(["filter", "filter", "paper"]))
def test_logs(folder, answer, text, method):
    problem_file(folder)
    (folder / "run.csv").write_text(text)
    arguments = ["estimate", folder / "run.csv", "--cart", folder / "cart.yaml", "--method", method]
    check(answer(*arguments), (0, 3), {"time", "parameters", "health"})


@FUZZ
@given(text=changed_yaml(CART))
def test_logs_with_other_carts(folder, answer, text):
    problem_file(folder, PROBLEM, text)
    (folder / "run.csv").write_text("\n".join(LOG.splitlines()[:20]))
    arguments = ["estimate", folder / "run.csv", "--cart", folder / "cart.yaml"]
    check(answer(*arguments), (0, 2, 3), {"time", "parameters", "health"})
