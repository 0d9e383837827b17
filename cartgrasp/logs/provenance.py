"""Where a log is from: its source's sum, the topic map, each step with its counts, and what was lost."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any


def provenance(
    sources: Sequence[Path],
    written: Path,
    steps: Sequence[Mapping[str, Any]],
    lost: Sequence[str],
    topic_map: Mapping[str, Any] | None,
) -> dict[str, Any]:
    """A document beside a log that was written from another, the first of the files that were read."""
    from .. import __version__

    files = dict.fromkeys(file for source in sources for file in _files(source))
    return {
        "written_by": f"cartgrasp {__version__}",
        "log": {"name": written.name, "sha256": sum_of(written)},
        "source": {"name": sources[0].name, "files": [{"name": p.name, "sha256": sum_of(p)} for p in files]},
        "topics": topic_map,
        "steps": list(steps),
        "lost": list(lost),
    }


def sum_of(path: Path) -> str:
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def sum_of_all(source: Path) -> str:
    """The checksum of a file, or of all files in a recorder's folder."""
    sums = [sum_of(path) for path in _files(source)]
    return sums[0] if source.is_file() else hashlib.sha256("".join(sums).encode()).hexdigest()


def _files(source: Path) -> list[Path]:
    return sorted(p for p in source.iterdir() if p.is_file()) if source.is_dir() else [source]
