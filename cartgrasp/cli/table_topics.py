"""`cartgrasp topics mine.csv [--with OTHER …] [--out MAP] [--ask]`: a table's columns, and the map proposed for it."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ruamel.yaml.comments import CommentedMap

from ..errors import FileError, LogError, Place, UsageError, printable
from ..logs import MAP_SUFFIX, TABLES
from ..logs.csv_log import PAGE, check_columns
from ..logs.mapped.run_map import Location
from ..logs.tables.proposing import Proposal, propose
from ..logs.tables.questions import put, value_of
from ..logs.tables.table_map import Question, TableFormat, open_questions
from ..writing import write_atomically
from ..yaml_file import dump_yaml, parse_yaml
from .output import print_json, print_table, say

MAX_SIBLING_FILES = 30
"""Files of a folder that are looked at."""

ANSWER_NAME = "the answer"
UNNAMED_ARM_ENTRY = "\n  arm:\n"
"""How the proposed map begins a hand that no column names."""


def run(path: Path, beside: Sequence[Path], out: Path | None, ask: bool, as_json: bool) -> int:
    if not path.is_file():
        raise LogError(Place(str(path)), "", "there is no such file")
    if any(one.resolve().parent != path.resolve().parent for one in beside):
        raise UsageError("--with: name files in the table's own folder, so that the map can name them")
    if ask and not sys.stdin.isatty():
        raise UsageError("--ask: asks on a terminal; elsewhere fill in the map that --out writes")
    proposal = propose(path, beside or _others(path))
    if _is_run_log(proposal):
        if as_json:
            print_json({**_document(proposal, ()), "proposal": None})
        say(f"{path}: has the columns of a run log; commands read it as it is")
        return 0
    document = parse_yaml(proposal.text, str(path))
    questions = open_questions(document, str(path))
    if as_json:
        print_json(_document(proposal, questions))
    else:
        _print(proposal)
    for note in proposal.notes:
        say(printable(note))
    text = proposal.text
    if ask:
        out = out or path.with_name(f"{path.name}{MAP_SUFFIX}")
        if out.exists():
            raise UsageError(f"{out}: is there already; remove it, or name another place with --out")
        document = _named(document, text)
        _ask(document, open_questions(document, ANSWER_NAME), text)
        text = dump_yaml(document)
        questions = open_questions(document, str(path))
    if out is not None:
        write_atomically(out, text)
    _say_open(questions, path, out)
    return 0


def _is_run_log(proposal: Proposal) -> bool:
    table = proposal.files[0].table
    try:
        check_columns(table.header or (), table.name)
    except LogError:
        return False
    return proposal.files[0].layout.format == TableFormat()


def _others(path: Path) -> list[Path]:
    """Tables in the same folder."""
    found = sorted(p for p in path.parent.iterdir() if p.suffix.lower() in TABLES and p.name != path.name)
    return [p for p in found if p.is_file()][:MAX_SIBLING_FILES]


def _document(proposal: Proposal, questions: Sequence[Question]) -> dict[str, Any]:
    columns = [
        {
            "file": file.path.name,
            "column": column.title,
            "taken_for": column.role or None,
            "unit": column.unit,
            "least": None if column.span is None else column.span[0],
            "largest": None if column.span is None else column.span[1],
        }
        for file in proposal.files
        for column in file.columns
    ]
    asked = [{"where": ".".join(q.where), "said": q.said, "why": q.why} for q in questions]
    return {"columns": columns, "proposal": proposal.text, "questions": asked, "notes": list(proposal.notes)}


def _print(proposal: Proposal) -> None:
    for file in proposal.files:
        rows = []
        for column in file.columns:
            span = ["", ""] if column.span is None else [f"{value:.6g}" for value in column.span]
            rows.append([printable(column.title), column.role, column.unit or "", *span])
        title = f"{file.path.name}: {len(file.table.lines)} rows"
        print_table(title, ["column", "taken for", "unit in its name", "least", "largest"], rows, left=3)


def _say_open(questions: Sequence[Question], path: Path, out: Path | None) -> None:
    for same in _alike(questions):
        where = ", ".join(".".join(question.where) for question in same)
        said = f"{same[0].said}?" if same[0].said is not None else same[0].why
        say(printable(f"open: {where}: {said}"))
    if out is None:
        say(f"a map is proposed with --out {path}{MAP_SUFFIX}; with --ask you are asked what is open ({PAGE})")
    elif questions:
        say(f"in {out} take the question marks away, or put what is right, and fill in what is blank ({PAGE})")
    else:
        say(f"{out} is whole: commands read {path} through it")


def _alike(questions: Sequence[Question]) -> list[list[Question]]:
    """Those that one answer serves: the same guess at the same kind of place."""
    found: dict[tuple[str, ...], list[Question]] = {}
    for one in questions:
        kind = one.where if one.said is None else (one.where[0], one.where[-1], one.said)
        found.setdefault(kind, []).append(one)
    return list(found.values())


def _named(document: CommentedMap, text: str) -> CommentedMap:
    """The map, of such a text, with a word of one's own for a hand that no column names."""
    if UNNAMED_ARM_ENTRY not in text:
        return document
    print("arms: a word for the hand, as your cart's file and your controller call it")
    while True:
        word = input("  name [arm]: ").strip() or "arm"
        document = parse_yaml(text.replace(UNNAMED_ARM_ENTRY, f"\n  {json.dumps(word)}:\n"), ANSWER_NAME)
        if _is_taken(document, ("arms", word)):
            return document


def _ask(document: CommentedMap, questions: Sequence[Question], text: str) -> None:
    """Enter takes a guess as it is, and leaves a blank open; what can't be used is asked again."""
    lines = text.splitlines()
    for same in _alike(questions):
        where = ", ".join(".".join(question.where) for question in same)
        said = same[0].said
        print(printable(f"{where}: {_comment(document, same[0], lines) or same[0].why}"))
        prompt = f"  {same[0].where[-1]}{'' if said is None else f' [{said}]'}: "
        while answer := input(prompt).strip() or said:
            _put_all(document, same, _answered(answer))
            if _is_taken(document, same[0].where):
                break
            _put_all(document, same, None if said is None else f"{said}?")


def _put_all(document: CommentedMap, questions: Sequence[Question], value: Any) -> None:
    for question in questions:
        put(document, question.where, value)


def _answered(text: str) -> Any:
    """As YAML reads it; several numbers are a list without its brackets, too."""
    parts = text.replace(",", " ").split()
    are_numbers = len(parts) > 1 and all(isinstance(value_of(part), int | float) for part in parts)
    return value_of(f"[{', '.join(parts)}]" if are_numbers else text)


def _is_taken(document: CommentedMap, where: Location) -> bool:
    """Whether what was put there can be used; if not, says why."""
    try:
        wrong = [one.why for one in open_questions(document, ANSWER_NAME) if one.where == where and one.said is None]
    except FileError as error:
        wrong = [error.why]
    for why in wrong:
        say(printable(f"{'.'.join(where)}: {why}; once more"))
    return not wrong


def _comment(document: CommentedMap, question: Question, lines: Sequence[str]) -> str:
    """What stands behind it in the map."""
    node: Any = document
    line = 0
    for key in question.where:
        if not isinstance(node, CommentedMap) or key not in node:
            break
        line = node.lc.key(key)[0]
        node = node[key]
    return lines[line].partition("  # ")[2]
