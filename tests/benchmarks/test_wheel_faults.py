"""A small version of `python -m benchmarks.wheel_faults`."""

import pytest

from benchmarks.sealed.generate import generate
from benchmarks.wheel_faults import CONSTANTS, KINDS, counts, looks, moved_by


@pytest.mark.prove
def test_wrong_files_are_told_and_constants_come_back(tmp_path):
    generate(tmp_path, ["rolling_resistance"], [8621], "rich")
    every = [one for one in looks(tmp_path) if one.kind != KINDS[3]]
    told = counts(every)
    assert told == ["0 of 1", "1 of 1", "1 of 1", "0 of 0"]
    before = [getattr(module, name) for module, name, _ in CONSTANTS]
    for module, name, part in CONSTANTS:
        assert moved_by(every, module, name, part, 0.7) == told
    assert [getattr(module, name) for module, name, _ in CONSTANTS] == before
    assert moved_by(every, *CONSTANTS[3][:2], None, 0.0)[1:3] == ["0 of 1", "0 of 1"]
