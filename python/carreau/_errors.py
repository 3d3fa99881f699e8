"""What can go wrong: one exception per kind of failure, each with the exit code of the command line."""

from __future__ import annotations

__all__ = [
    "CancelledError",
    "CarreauWarning",
    "DeadlineError",
    "Error",
    "InputError",
    "InternalError",
    "NumericError",
    "OptionsError",
    "ReadError",
    "WriteError",
]


class Error(Exception):
    """Every failure of carreau.

    Attributes
    ----------
    where : str
        Ids of the elements concerned; empty where the message has no place.
    remedy : str
        What can be done about it; empty where nothing is known.
    exit_code : int
        What the command line returns for this kind of failure.
    """

    exit_code = 70

    def __init__(self, message: str, where: str = "", remedy: str = "") -> None:
        super().__init__(message)
        self.where = where
        self.remedy = remedy

    def __reduce__(self):
        # Exceptions cross from worker processes by pickle.
        return type(self), (str(self), self.where, self.remedy)


class OptionsError(Error, ValueError):
    """An option has a value that makes no sense, or two options contradict each other."""

    exit_code = 2


class InputError(Error, ValueError):
    """The input is not acceptable for what was asked."""

    exit_code = 3


class NumericError(Error, ArithmeticError):
    """The method could not reach what was asked."""

    exit_code = 4


class ReadError(Error, OSError):
    """A file could not be read."""

    exit_code = 5


class WriteError(Error, OSError):
    """A file could not be written; nothing was left behind."""

    exit_code = 5


class InternalError(Error, RuntimeError):
    """A bug of carreau: a panic, or a result that failed its own validation. Please report it with the input."""

    exit_code = 70


class DeadlineError(Error, TimeoutError):
    """The deadline passed before the work was done."""

    exit_code = 124


class CancelledError(Error):
    """The run was cancelled. Ctrl-C raises `KeyboardInterrupt` instead."""

    exit_code = 130


class CarreauWarning(UserWarning):
    """What the user should know of a run that succeeded: repairs, losses, fallbacks."""
