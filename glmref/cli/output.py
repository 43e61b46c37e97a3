"""Streams, exit codes and sentences of the command line."""

from __future__ import annotations

import os
import sys
import traceback

import click
from click.shell_completion import CompletionItem

from ..errors import did_you_mean
from ..system.process import INTERRUPTED, PIPE_CLOSED, open_streams
from ..views.tables import one_line

__all__ = [
    "BAD_INPUT",
    "FAILED",
    "HOLDS",
    "INTERNAL",
    "INTERRUPTED",
    "PIPE_CLOSED",
    "Word",
    "complain",
    "complete_method",
    "confess",
    "internal_sentence",
    "open_streams",
    "say",
]

HOLDS, FAILED, BAD_INPUT, INTERNAL = 0, 1, 2, 3


class Word(click.Choice[str]):
    """One of some words; a wrong one is told the nearest."""

    def get_invalid_choice_message(self, value: object, ctx: click.Context | None) -> str:
        """Return the sentence for a word that is none of them."""
        near = did_you_mean(value, self.choices, "; ")
        return f"{value!r} is none of {', '.join(self.choices)}{near}"


def complete_method(
    context: click.Context, parameter: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete a method: the shipped names, never those wrong on purpose, and files."""
    from ..catalogue.files import names

    found = [CompletionItem(name) for name in names("methods") if name.startswith(incomplete)]
    return [*found, CompletionItem(incomplete, type="file")]


def say(text: str) -> None:
    """Write a result to stdout, at once, so that an interruption keeps it."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def complain(text: str) -> None:
    """Write one sentence, on one line, to stderr."""
    print(f"glmref: {one_line(text)}", file=sys.stderr, flush=True)  # noqa: T201


def internal_sentence(error: BaseException, where: str = "") -> str:
    """Say that something failed that should not have, and what to do."""
    at = f" while checking {where}" if where else ""
    return (
        f"internal error{at} ({type(error).__name__}: {one_line(error, limit=300)}); "
        f"please report it, with what GLMREF_DEBUG=1 shows"
    )


def confess(error: BaseException) -> None:
    """Report an exception nobody expected; with GLMREF_DEBUG=1 its traceback too."""
    if os.environ.get("GLMREF_DEBUG"):
        traceback.print_exception(error)
    complain(internal_sentence(error))
