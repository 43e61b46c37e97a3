"""The command line: one file for each family of commands, errors turned into one sentence here.

Exit codes: 0 what was asked holds, 1 a check failed, 2 usage, bad input or what the system refuses,
3 open or internal, 130 interrupted, 143 terminated, 141 the reader of the output went away. Results
go to stdout, progress and errors to stderr. Importing this package loads click and nothing heavy.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import click

from .. import __version__
from ..errors import GlmrefError
from ..system.process import guarded
from .auditing import audit, check
from .benching import bench
from .browsing import cite, list_, show
from .campaigning import campaign
from .certifying import certify
from .checking import verify
from .comparing import compare, problems
from .deriving import derive
from .describing import analyze, errata
from .exchanging import export, import_
from .output import BAD_INPUT, INTERNAL, complain, confess
from .probing import conformance, probe
from .reporting import report
from .running import run

__all__ = ["group", "main"]


@click.group(
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Exit codes: 0 holds, 1 a check failed, 2 usage, bad input or a "
    "refusal of the system, 3 open or internal. "
    "NO_COLOR is respected; GLMREF_DEBUG=1 shows the traceback of an internal error.",
)
@click.version_option(__version__, "--version", prog_name="glmref", message="%(prog)s %(version)s")
def group() -> None:
    """General linear methods, checked exactly."""


for command in (
    *(
        verify,
        certify,
        analyze,
        list_,
        show,
        cite,
        errata,
        derive,
        run,
        probe,
        bench,
        report,
        campaign,
    ),
    *(export, import_, problems, compare, check, conformance, audit, campaign),
):
    group.add_command(command)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; no exception leaves this function.

    Parameters
    ----------
    arguments : Sequence[str] or None
        The command line without the program; that of the process by default.
    """
    if "_GLMREF_COMPLETE" in os.environ:  # the shell asks for completions
        return int(group.main(prog_name="glmref") or 0)
    arguments = sys.argv[1:] if arguments is None else arguments
    return guarded("glmref", lambda: _run(list(arguments)), BAD_INPUT)


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
