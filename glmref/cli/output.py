"""Streams, exit codes and sentences of the command line."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence, Sized
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from ..errors import did_you_mean
from ..views.tables import Style, columns, csv_text, one_line

HOLDS, FAILED, BAD_INPUT, INTERNAL = 0, 1, 2, 3


class Word(click.Choice[str]):
    """One of some words; for a wrong one the nearest is named."""

    def get_invalid_choice_message(self, value: object, ctx: click.Context | None) -> str:
        """Return the sentence for a word that is none of them."""
        near = did_you_mean(value, self.choices, "; ")
        return f"{value!r} is none of {', '.join(self.choices)}{near}"


def complete_method(
    context: click.Context, parameter: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete a method: the shipped names, never those wrong on purpose, and files."""
    from ..catalogue.files import names

    return _completed(names("methods"), incomplete)


def complete_problem(
    context: click.Context, parameter: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete a problem: the shipped names and files."""
    from ..problems import names

    return _completed(names(), incomplete)


def complete_scene(
    context: click.Context, parameter: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete a scene or a campaign: the shipped names and files."""
    from ..scenes.campaign import campaign_names
    from ..scenes.reading import names

    return _completed([*names(), *campaign_names()], incomplete)


def complete_recipe(
    context: click.Context, parameter: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete a recipe, or the file of an ansatz."""
    from ..derive.recipes import names

    return _completed(names(), incomplete)


def _completed(names: Iterable[str], incomplete: str) -> list[CompletionItem]:
    found = [CompletionItem(name) for name in names if name.startswith(incomplete)]
    return [*found, CompletionItem(incomplete, type="file")]


def format_option(
    formats: Iterable[str] = ("table", "json", "csv"),
    said: str = "Format of the output.",
    default: str | None = "table",
) -> Callable[[Any], Any]:
    """Return the option ``--format`` of a command."""
    return click.option("--format", "form", type=Word([*formats]), default=default, help=said)


def count_option(name: str, most: int, said: str) -> Callable[[Any], Any]:
    """Return an option that takes a whole number from 1 on."""
    return click.option(name, type=click.IntRange(1, most), metavar="N", help=said)


def file_option(name: str, said: str) -> Callable[[Any], Any]:
    """Return an option that takes a file to write."""
    return click.option(name, type=click.Path(path_type=Path), metavar="FILE", help=said)


on_option = click.option(
    "--on",
    metavar="WHERE",
    help="Where tasks run: here, local, local:N, dask, dask:N, dask:ADDRESS or dask:FILE of a "
    "scheduler; GLMREF_EXECUTOR says the same.",
)


def say(text: str) -> None:
    """Write a result to stdout, at once, so that an interruption keeps it."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def say_rows(form: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Write rows under their headings, as CSV or for the eye."""
    if form == "csv":
        say(csv_text([head, *rows]))
    else:
        say(columns(rows, style=Style.of(sys.stdout), head=head))


def complain(text: str) -> None:
    """Write one sentence, on one line, to stderr."""
    print(f"glmref: {one_line(text)}", file=sys.stderr, flush=True)  # noqa: T201


def internal_sentence(error: BaseException | str, where: str = "") -> str:
    """Say that something failed that should not have, and what to do."""
    at = f" while checking {where}" if where else ""
    what = error if isinstance(error, str) else f"{type(error).__name__}: {error}"
    return (
        f"internal error{at} ({one_line(what, limit=300)}); "
        f"please report it, with what GLMREF_DEBUG=1 shows"
    )


def confess(error: BaseException) -> None:
    """Report an unexpected exception; with GLMREF_DEBUG=1 its traceback too."""
    if os.environ.get("GLMREF_DEBUG"):
        traceback.print_exception(error)
    complain(internal_sentence(error))


@contextmanager
def said_when_interrupted(store: Sized, wanted: int, what: str) -> Iterator[None]:
    """Say on an interruption how much is kept of what was to be measured, and how to go on."""
    try:
        yield
    except KeyboardInterrupt:
        with suppress(Exception):  # a file that a second signal closed says nothing
            complain(f"{len(store)} of {wanted} {what} are kept; the same command goes on")
        raise


class Progress:
    """Tasks done, running and failed, their rate and the time left, in one line of a terminal.

    Off a terminal nothing is shown. ``out``, ``done`` and ``threads`` count how many tasks of the
    total were handed out, where that is known, have ended, and can run at the same time.
    """

    def __init__(self, total: int, name: str, unit: str) -> None:
        self.bar: Any = None
        self.out = self.done = self.failed = 0
        self.threads = 1
        if sys.stderr.isatty() and total > 0:
            from tqdm import tqdm

            tqdm.monitor_interval = 0  # no thread besides this one
            self.bar = tqdm(total=total, desc=name, unit=unit, leave=False, file=sys.stderr)

    def __enter__(self) -> Progress:
        return self

    def advance(self, text: str = "", *, failed: bool = False) -> None:
        """Count one task."""
        self.done += 1
        self.failed += failed
        if self.bar is not None:
            count = min(self.out - self.done, self.threads)
            running = [f"{count} running"] if count > 0 else []
            shown = [*running, *([f"{self.failed} failed"] if self.failed else []), text]
            self.bar.set_postfix_str(", ".join(filter(None, shown)), refresh=False)
            self.bar.update()

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Write the result of a task above the line, and count the task."""
        with nullcontext() if self.bar is None else self.bar.external_write_mode():
            yield
        self.advance()

    def __exit__(self, *exception: object) -> None:
        if self.bar is not None:
            self.bar.close()
