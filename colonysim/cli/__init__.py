"""The command line: thin doors onto the functions that Python code calls. One module a command."""

from __future__ import annotations

import sys
import warnings
from typing import Any

import typer
from typer.core import TyperGroup

from colonysim.cli import (
    backends,
    bench,
    compare,
    evaluate,
    export,
    fork,
    import_,
    new,
    plot,
    policies,
    repeat,
    report,
    reproduce,
    results,
    resume,
    run,
    scenarios,
    schema,
    sweep,
    train,
    tune,
    validate,
    verify,
    video,
    view,
)
from colonysim.cli.console import print_result, say
from colonysim.cli.stopping import told_when_stopped
from colonysim.cli.streams import guard
from colonysim.errors import ColonysimError, ColonysimWarning, PluginError

__all__ = ["app", "main"]

_EPILOG = """\b
First steps:
  colonysim scenarios                        which scenarios there are
  colonysim run hard                         run one, in an instant
  colonysim plot runs/hard-nodeworld-s0-1    draw its pheromones
  colonysim run hard --backend physics       the same colony as rigid bodies
"""


class Door(TyperGroup):
    """The top-level command: a user's mistake becomes a message and exit code 2, never a traceback."""

    def main(self, *args: Any, **extra: Any) -> Any:
        """Reads the words of the command line and runs the command that was asked for."""
        try:
            try:
                return super().main(*args, **extra)
            finally:
                sys.stdout.flush()  # here a fault can still be told
        except ColonysimError as error:
            say(f"Error: {error}{_place(error)}")
            raise SystemExit(error.exit_code) from None
        except OSError as error:
            say(f"Error: {error.filename}: {error.strerror}" if error.filename else f"Error: {error}")
            raise SystemExit(ColonysimError.exit_code) from None
        except MemoryError:
            say("Error: there is not enough memory for this")
            raise SystemExit(ColonysimError.exit_code) from None

    def invoke(self, ctx: Any) -> Any:
        """Runs the command that was asked for."""
        with told_when_stopped(lambda: "Interrupted."), warnings.catch_warnings():
            warnings.simplefilter("always", ColonysimWarning)
            warnings.showwarning = _show_warning
            return super().invoke(ctx)

    def list_commands(self, ctx: Any) -> list[str]:
        """In the order in which one needs them."""
        del ctx
        return list(self.commands)


def _place(error: ColonysimError) -> str:
    """Where an error of a part of others came from, to be told behind it."""
    if not isinstance(error, PluginError):
        return ""
    from colonysim.cli.blame import place_of

    place = place_of(error)
    return f" ({place})" if place else ""


def _show_warning(
    message: Warning | str, category: type[Warning], filename: str, lineno: int, file: Any = None, line: Any = None
) -> None:
    """Ours without the place in the code; it is about the user's files."""
    if issubclass(category, ColonysimWarning):
        say(f"Warning: {message}")
    else:
        say(warnings.formatwarning(message, category, filename, lineno, line).rstrip())


app = typer.Typer(
    cls=Door,
    help="Simulate robot colonies that coordinate through marks left in the place itself.",
    epilog=_EPILOG,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    # Rich's help would import Markdown and more: --help would take three times as long.
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
for module in (
    run, resume, scenarios, new, import_, validate, backends, policies, schema, view, video, plot, report, export,
    verify, repeat, sweep, results, compare, fork, tune, reproduce, bench,
):  # fmt: skip
    name = module.__name__.rpartition(".")[2].rstrip("_")
    app.command(name, epilog=module.EXAMPLES)(module.command)
app.add_typer(train.app, name="train")
app.add_typer(evaluate.app, name="evaluate")


def _version(wanted: bool) -> None:
    if wanted:
        from colonysim import __version__
        from colonysim.built import build

        print_result(f"colonysim {__version__} ({build()})")
        raise typer.Exit


@app.callback()
def _top(
    version: bool = typer.Option(
        False, "--version", callback=_version, is_eager=True, help="Show the version and leave."
    ),
) -> None:
    # The text shown by --help is given to Typer above; a docstring here would take its place.
    del version


def main() -> None:
    """Runs the command that the words of the command line ask for, and ends the process."""
    guard()
    with told_when_stopped(lambda: "Interrupted."):
        app()
