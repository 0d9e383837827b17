"""How hypothesis draws: the same examples on every run; HYPOTHESIS_PROFILE=prove searches longer and anew.

And which tests run: `make test` leaves out what is marked `prove`, and of the cases of a test that is marked `some(n)`
all but n; `make prove` runs these."""

from __future__ import annotations

import gc
import os
import random
from collections import defaultdict

import pytest
from hypothesis import settings

settings.register_profile("default", max_examples=30, derandomize=True, deadline=None)
settings.register_profile("prove", max_examples=1000, derandomize=False, deadline=None, print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "default"))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Which n is drawn by the test's name, so that it is the same ones on every run and for every worker."""
    cases = defaultdict(list)
    for item in items:
        if item.get_closest_marker("some"):
            cases[item.nodeid.split("[")[0]].append(item)
    for name, of_one in cases.items():
        (n,) = of_one[0].get_closest_marker("some").args
        for item in random.Random(name).sample(of_one, max(len(of_one) - n, 0)):
            item.add_marker(pytest.mark.prove)


def pytest_collection_finish() -> None:
    """The collector of garbage looks no more at all that was imported: that took a twentieth of the time."""
    gc.collect()
    gc.freeze()
