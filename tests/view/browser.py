"""A headless browser, where one is found: the page's DOM after some time, and what it wrote on its console."""

from __future__ import annotations

import html
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
    "--enable-logging=stderr",
    "--force-device-scale-factor=1",
    "--window-size=1400,900",
)

needs_browser = pytest.mark.skipif(BROWSER is None, reason="no chromium or google-chrome on the path")


@dataclass(frozen=True)
class Visit:
    """The page's DOM after some time, and what it wrote on its console."""

    dom: str
    console: tuple[str, ...]

    def text(self, name: str) -> str:
        found = re.search(rf'id="{name}"[^>]*>([^<]*)<', self.dom)
        assert found, f"no element {name}"
        return html.unescape(found[1])

    def number(self, name: str) -> float:
        return float(self.text(name).replace("−", "-"))


def run_browser(page: Path, fragment: str, *flags: str) -> subprocess.CompletedProcess[str]:
    assert BROWSER is not None
    profile = page.parent / f"profile-{len(list(page.parent.iterdir()))}"
    command = [BROWSER, *FLAGS, f"--user-data-dir={profile}", *flags, f"{page.as_uri()}#{fragment}"]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)


def visit(page: Path, fragment: str = "", virtual_ms: int = 1000) -> Visit:
    done = run_browser(page, fragment, f"--virtual-time-budget={virtual_ms}", "--dump-dom")
    return Visit(done.stdout, tuple(line for line in done.stderr.splitlines() if "CONSOLE" in line))


def count_of(colour: str, pixels: np.ndarray) -> int:
    wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return int((np.abs(pixels[..., :3] - wanted).max(-1) < 0.02).sum())
