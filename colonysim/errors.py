"""The errors a user can cause, each shown as one message and never as a traceback; and the wish to stop."""


class ColonysimError(Exception):
    """A mistake that the user can mend; the command line prints the message and exits with `exit_code`."""

    exit_code = 2


class ScenarioError(ColonysimError):
    """A scenario that cannot be simulated; the message names file, line, column and field."""


class MissingExtraError(ColonysimError):
    """An optional part was asked for that is not installed; the message holds the install command."""


class PluginError(ColonysimError):
    """A policy, field or backend that could not be found or loaded."""


class UnsavableError(PluginError):
    """A policy, field or backend of which the protocol's optional methods for saving are not there."""


class TraceError(ColonysimError):
    """A run directory that cannot be read or written."""


class ColonysimWarning(UserWarning):
    """What a user should know though the work goes on; the command line prints the message alone."""


class Stopped(KeyboardInterrupt):
    """Somebody or something asked the command to end: Ctrl-C, SIGTERM, a terminal that was closed.

    Attributes:
        exit_code: What the command ends with.
    """

    # A class of its own also because Python kills itself in the end, whatever the exit code, once a plain
    # `KeyboardInterrupt` came out of an `exec`, as there are many in imports.
    exit_code = 130


class Anew(KeyboardInterrupt):
    """A run is to begin anew: it ends as one that was stopped, and whoever has begun it begins another."""


PASSED_ON = (ColonysimError, MemoryError, KeyboardInterrupt)
"""Errors that are passed on when a third party's code raises them: the first already says what is wrong, the others are
not that code's fault."""


def told(error: BaseException) -> str:
    """The class and the message of an error that a third party's code has raised."""
    try:
        return f"{type(error).__name__}: {error}"
    except Exception:  # its words are another's code too
        return type(error).__name__
