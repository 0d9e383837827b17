"""What a proposal says at one place of a map, how sure it is, and why."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class ProposedValue:
    """`value` is None where only the user can know it; one that is not sure gets a question mark."""

    value: Any
    is_sure: bool = True
    why: str = ""

    def __str__(self) -> str:
        """As YAML has it."""
        mark = "" if self.is_sure else "?"
        if self.value is None:
            return ""
        if isinstance(self.value, str):
            return word(self.value + mark)
        if isinstance(self.value, list):
            return f"[{', '.join(str(ProposedValue(one, self.is_sure)) for one in self.value)}]"
        return f"{self.value}{mark}"

    @property
    def is_open(self) -> bool:
        return self.value is None or not self.is_sure


def word(text: str) -> str:
    """As YAML takes it, whatever is in it."""
    bare = text.removesuffix("?")
    is_plain = bare.replace("/", "").replace("_", "").replace("·", "").isalnum() and not bare[:1].isdigit()
    is_word = bare.lower() in ("true", "false", "null", "yes", "no", "on", "off", "nan", "inf")
    return text if is_plain and not is_word and bare.isprintable() else json.dumps(text, ensure_ascii=False)
