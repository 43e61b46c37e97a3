"""The command line: one file for each family of commands, errors turned into one sentence here.

Exit codes: 0 what was asked holds, 1 a check failed, 2 usage, bad input or what the system refuses,
3 open or internal, 130 interrupted, 143 terminated, 141 the reader of the output went away. Results
go to stdout, progress and errors to stderr. Importing this package loads click and nothing heavy.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Any

import click

from .. import __version__
from ..errors import GlmrefError
from ..system.process import guarded, limited_by_parent, within
from .auditing import audit, check
from .browsing import list_, show
from .certifying import certify
from .checking import verify
from .comparing import compare, problems
from .conforming import conformance
from .deriving import derive
from .describing import analyze
from .exchanging import convert
from .feeding import feed
from .output import BAD_INPUT, INTERNAL, complain, confess
from .reporting import report
from .running import run

__all__ = ["group", "main"]


#: Words that are no commands here, and what does what they ask for.
_ELSEWHERE = {
    "bench": "`asv run` in a checkout, see CONTRIBUTING.md",
    "help": "`glmref --help` and `glmref COMMAND --help`",
    "integrate": "`glmref.solve` in Python, `glmref compare PROBLEM` or `glmref run SCENE`",
    "plot": "`glmref show NAME --plot FILE.svg`, or `glmref.plot` in Python",
    "solve": "`glmref.solve` in Python, `glmref compare PROBLEM` or `glmref run SCENE`",
}


#: Old names of commands, and the words that they stand for.
_OLD = {
    "board": ("conformance", "--board"),
    "campaign": ("run",),
    "cite": ("show", "--bibtex"),
    "errata": ("list", "--errata"),
    "export": ("convert",),
    "import": ("convert",),
    "lint": ("audit", "--lines"),
    "probe": ("conformance", "--identify"),
}


class _Group(click.Group):
    """The commands in their order, and an answer to words that one might take for a command."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in the order of :data:`EXAMPLES`."""
        return list(self.commands)

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """Find the command of a line, by its old name as well."""
        first, *rest = args or [""]
        if first in _ELSEWHERE:
            raise click.UsageError(f"there is no command {first!r}; take {_ELSEWHERE[first]}")
        if first == "campaign" and set(rest) <= {"--plan", "--pages"}:  # without a name
            rest = ["--list"]
        return super().resolve_command(ctx, [*_OLD.get(first, args[:1]), *rest])


@click.group(
    cls=_Group,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Exit codes: 0 holds, 1 a check failed, 2 usage, bad input or a "
    "refusal of the system, 3 open or internal. "
    "NO_COLOR is respected; GLMREF_DEBUG=1 shows the traceback of an internal error.",
)
@click.version_option(__version__, "--version", prog_name="glmref", message="%(prog)s %(version)s")
@click.option(
    "--time-limit",
    type=click.IntRange(1, 10**8),
    metavar="SECONDS",
    envvar="GLMREF_TIME_LIMIT",
    help="End the command after this time, with exit code 2, whatever it does then.",
)
def group(time_limit: int | None) -> None:
    """General linear methods, checked exactly."""


#: The commands in the order in which one needs them, each with an example of its use.
EXAMPLES = {
    verify: "glmref verify my-tableau.json",
    analyze: "glmref analyze gauss-2 --modified",
    show: "glmref show rk4 --plot rk4.svg",
    list_: "glmref list --class lmm",
    derive: "glmref derive order6 --c2 1/3",
    problems: "glmref problems double-pendulum",
    compare: "glmref compare kepler --tolerance 1e-6",
    run: "glmref run kepler --plan",
    convert: "glmref convert gauss-2 --to c --output gauss_2.c",
    audit: "glmref audit src/integrators --lines",
    feed: "glmref feed --output public",
    conformance: "glmref conformance scipy --identify",
    report: "glmref report --single-file",
}
#: Old names of commands, with the new ones.
HIDDEN = {
    check: "glmref verify FILE",
    certify: "glmref verify NAME --certificates DIR",
}

for command, example in EXAMPLES.items():
    command.epilog = f"Example: {example}"
    group.add_command(command)
for command, new in HIDDEN.items():
    command.hidden = True
    command.epilog = f"An old name: take `{new}`."
    group.add_command(command)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; no exception leaves this function.

    The command line has no program in it; that of the process by default.
    """
    if "_GLMREF_COMPLETE" in os.environ:  # the shell asks for completions
        return int(group.main(prog_name="glmref") or 0)
    arguments = sys.argv[1:] if arguments is None else arguments

    def program() -> int:
        return guarded("glmref", lambda: _run(list(arguments)), BAD_INPUT)

    seconds = _time_limit(list(arguments))
    if seconds is None or limited_by_parent():
        return program()
    return within("glmref", seconds, [sys.executable, "-m", "glmref", *arguments])


def _time_limit(arguments: list[str]) -> int | None:
    """Return the requested time limit; errors in it are reported later."""
    first = arguments[0] if arguments else ""
    if not first.startswith("--time-limit") and "GLMREF_TIME_LIMIT" not in os.environ:
        return None
    context = group.make_context("glmref", arguments, resilient_parsing=True)
    return context.params["time_limit"]


def _run(arguments: list[str]) -> int:
    try:
        with group.make_context("glmref", arguments) as context:
            return int(group.invoke(context) or 0)
    except click.exceptions.Exit as stop:
        return stop.exit_code
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        return BAD_INPUT
    except click.ClickException as error:
        complain(error.format_message())
        return BAD_INPUT
    except GlmrefError as error:
        complain(str(error))
        return BAD_INPUT
    except (OSError, MemoryError):
        raise
    except click.Abort:  # how click hands on Ctrl-C
        raise KeyboardInterrupt from None
    except Exception as error:
        confess(error)
        return INTERNAL
