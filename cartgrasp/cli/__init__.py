"""The command line `cartgrasp`: what scripts rely on stands in `docs/command_line.md`."""

from .app import main

__all__ = ["main"]
