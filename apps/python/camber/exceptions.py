"""What goes wrong, as exceptions: the program's errors, with their place and remedy.

Each says `what` is wrong, `where` (a file with its place, an argument, a row of an array), of which `entity`, and the
`remedy`: what can be done about it. `str(error)` has all of them in one line.
"""

from __future__ import annotations

import re


class Error(Exception):
    """An error of Camber's."""

    def __init__(self, what: str, where: str = "", entity: str = "", remedy: str = "") -> None:
        self.what, self.where, self.entity, self.remedy = what, where, entity, remedy
        place = [part for part in (where, entity) if part]
        super().__init__(": ".join([*place, what]) + (f" ({remedy})" if remedy else ""))


class UsageError(Error, ValueError):
    """An argument or a config that makes no sense."""


class InputError(Error, ValueError):
    """A mesh, a field, a file or an array that is wrong."""


class UnsupportedError(Error, NotImplementedError):
    """Something that is right and that Camber does not do."""


class WriteError(Error, OSError):
    """A file that cannot be written."""


class OutOfMemory(Error, MemoryError):
    """The machine has less memory than that needs."""


class Stopped(Error):
    """A progress callback said False."""


class InternalError(Error, RuntimeError):
    """A bug of Camber's."""


class NotCertified(UserWarning):
    """A result is not the requested one: elements are not certified valid, the boundary is off its geometry, walls cross, or elements overlap."""


_KINDS = (UsageError, InputError, UnsupportedError, WriteError, Stopped, OutOfMemory, InternalError)  # ErrorKind


def of(kind: int, what: str, where: str, entity: str, number: int, remedy: str) -> Error:
    """The exception that an error of the extension is; words of the command line become Python's."""
    return _KINDS[kind](in_python(what), in_python(where), f"{entity} {number}" if entity else "", in_python(remedy))


def in_python(text: str) -> str:
    """`--min-scaled-jacobian` is `min_scaled_jacobian` here, and what is in memory has its name alone."""
    text = re.sub(r"see camber (\w+) --help", r"see help(camber.\1)", text)
    text = text.replace("; --solution on the command line", "")
    text = re.sub(r"(?<![\w-])--([a-z][a-z-]*[a-z])", lambda option: option[1].replace("-", "_"), text)
    return re.sub(r"memory:([\w/-]+)(\.\w+)?", r"\1", text)
