"""How hypothesis draws: the same examples on every run; HYPOTHESIS_PROFILE=prove searches longer and anew."""

from __future__ import annotations

import os

from hypothesis import settings

settings.register_profile("default", max_examples=50, derandomize=True, deadline=None)
settings.register_profile("prove", max_examples=1000, derandomize=False, deadline=None, print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "default"))
