"""Exceptions: the program's errors with their place and remedy.

Attributes: `what` (the error), `where` (a file and its line, an argument, a row of an array), `entity`, and `remedy`.
`str(error)` contains all of them in one line.
"""

from __future__ import annotations

import re


class Error(Exception):
    """Base class of all errors."""

    def __init__(self, what: str, where: str = "", entity: str = "", remedy: str = "") -> None:
        self.what, self.where, self.entity, self.remedy = what, where, entity, remedy
        place = [part for part in (where, entity) if part]
        super().__init__(": ".join([*place, what]) + (f" ({remedy})" if remedy else ""))


class UsageError(Error, ValueError):
    """An invalid argument or config."""


class InputError(Error, ValueError):
    """An invalid mesh, field, file or array."""


class UnsupportedError(Error, NotImplementedError):
    """A valid request that Camber does not support."""


class WriteError(Error, OSError):
    """A file that cannot be written."""


class OutOfMemory(Error, MemoryError):
    """Not enough memory."""


class Stopped(Error):
    """Stopped by a progress callback that returned False."""


class InternalError(Error, RuntimeError):
    """A bug in Camber."""


class NotCertified(UserWarning):
    """The result does not meet the request: elements not certified valid, boundary off its geometry, crossing walls, or overlaps."""


_KINDS = (UsageError, InputError, UnsupportedError, WriteError, Stopped, OutOfMemory, InternalError)  # ErrorKind


def of(kind: int, what: str, where: str, entity: str, number: int, remedy: str) -> Error:
    """Return the exception for an error of the extension, with option names converted to keywords."""
    return _KINDS[kind](in_python(what), in_python(where), f"{entity} {number}" if entity else "", in_python(remedy))


def in_python(text: str) -> str:
    """Convert `--min-scaled-jacobian` to `min_scaled_jacobian` and `memory:name` to `name`."""
    text = re.sub(r"see camber (\w+) --help", r"see help(camber.\1)", text)
    text = text.replace("; --solution on the command line", "")
    text = re.sub(r"(?<![\w-])--([a-z][a-z-]*[a-z])", lambda option: option[1].replace("-", "_"), text)
    return re.sub(r"memory:([\w/-]+)(\.\w+)?", r"\1", text)
