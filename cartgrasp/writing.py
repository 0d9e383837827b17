"""Files and folders that are whole: whenever a process is killed, the old one is there or the new one.

What is written to NAME grows in `.NAME.part` beside it. A lock tells one that is being written from one that a killed
process left, which the next writer of NAME takes over.
"""

from __future__ import annotations

import ctypes
import errno
import fcntl
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from .errors import FileError, Place

PartFile = tuple[int, Path]
"""An open, locked file or folder, and its name."""

_waiting: ContextVar[list[tuple[PartFile, Path]] | None] = ContextVar("_waiting", default=None)
"""What `together` will rename, and to what."""


def write_atomically(path: str | os.PathLike[str], content: str | bytes) -> Path:
    """Writes aside, then renames: readers see the old file or the new one."""
    path = Path(path)
    data = content.encode("utf-8") if isinstance(content, str) else content
    with _said(path):
        if path.exists() and not path.is_file():
            raise FileError(Place(str(path)), "", "can't be written: it is no ordinary file; name another place")
        aside = _opened(path, os.O_RDWR | os.O_CREAT)
        waiting = _waiting.get()
        try:
            _fill(aside[0], data)
            if waiting is None:
                os.replace(aside[1], path)
            else:
                waiting.append((aside, path))
        except BaseException:
            aside[1].unlink(missing_ok=True)
            raise
        finally:
            if waiting is None:
                os.close(aside[0])
    return path


@contextmanager
def together() -> Iterator[None]:
    """What is written within gets its names at the end, at one go, and none if it fails; each name once."""
    waiting: list[tuple[PartFile, Path]] = []
    token = _waiting.set(waiting)
    try:
        yield
        while waiting:
            (handle, aside), path = waiting[0]
            with _said(path):
                os.replace(aside, path)
            os.close(handle)
            del waiting[0]
    finally:
        _waiting.reset(token)
        for (handle, aside), _ in waiting:
            aside.unlink(missing_ok=True)
            os.close(handle)


def write_folder(folder: Path, fill: Callable[[Path], None]) -> Path:
    """`fill` writes into a folder aside, which then takes the place of `folder`, if there is one."""
    folder = folder.absolute()
    with _said(folder):
        folder.parent.mkdir(parents=True, exist_ok=True)
        handle, aside = _opened(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            _empty(aside)
            fill(aside)
            if folder.exists():
                _exchange(aside, folder)
            else:
                os.replace(aside, folder)
        except BaseException:
            shutil.rmtree(aside, ignore_errors=True)
            raise
        finally:
            os.close(handle)
    return folder


@contextmanager
def _said(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        copies = error.args[0] if isinstance(error, shutil.Error) else None
        reason = error.strerror or (copies[0][2].partition(": ")[0] if isinstance(copies, list) else error)
        why = f"can't be written: {reason}; mend that, or name another place"
        raise FileError(Place(str(path)), "", why) from error


def _opened(path: Path, flags: int) -> PartFile:
    """What grows aside of `path`: ours alone, once no other process writes it, and no other file by then."""
    aside = path.with_name(f".{path.name}.part")
    while True:
        if flags & os.O_DIRECTORY:
            aside.mkdir(exist_ok=True)
        handle = os.open(aside, flags | os.O_NOFOLLOW, 0o666)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX)
            with suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(handle), os.stat(aside)):
                    return handle, aside
        except BaseException:
            os.close(handle)
            raise
        os.close(handle)


def _fill(handle: int, data: bytes) -> None:
    os.ftruncate(handle, 0)
    with os.fdopen(os.dup(handle), "wb") as stream:
        stream.write(data)
        stream.flush()
        os.fsync(handle)


def _empty(folder: Path) -> None:
    for inside in folder.iterdir():
        if inside.is_dir() and not inside.is_symlink():
            shutil.rmtree(inside)
        else:
            inside.unlink()


def _exchange(aside: Path, folder: Path) -> None:
    """Both change names, and what was there before goes; it is locked, because it stands aside for a moment."""
    old = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(old, fcntl.LOCK_EX)
        if not _exchanged(aside, folder):
            shutil.rmtree(folder)
            os.replace(aside, folder)
        else:
            shutil.rmtree(aside)
    finally:
        os.close(old)


def _exchanged(one: Path, other: Path) -> bool:
    """In one system call, which Linux has."""
    working_folder, exchange = -100, 2
    libc = ctypes.CDLL(None, use_errno=True)
    if not hasattr(libc, "renameat2"):
        return False
    if libc.renameat2(working_folder, os.fsencode(one), working_folder, os.fsencode(other), exchange) == 0:
        return True
    error = ctypes.get_errno()
    if error in (errno.ENOSYS, errno.EINVAL):  # an old kernel, or a file system that can't
        return False
    raise OSError(error, os.strerror(error))
