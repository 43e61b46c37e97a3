"""``glmref derive``: run a recipe, prove what it finds, write method files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import UsageError
from ..system.files import make_folder, write_text
from ..views.tables import json_text, one_line
from .output import FAILED, HOLDS, complete_recipe, format_option, say

if TYPE_CHECKING:
    from ..derive.recipes import Derivation


@click.command(
    short_help="Derive methods, with proofs.",
    context_settings={"ignore_unknown_options": True, "allow_extra_args": True},
    add_help_option=False,
)
@click.argument(
    "recipe", metavar="[RECIPE|ANSATZ.toml]", required=False, shell_complete=complete_recipe
)
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    help="Folder for the method files, or a file FILE.json for one; without it one goes to stdout.",
)
@format_option(("table", "json"), "Statements and files as text, or as one JSON record.")
@click.option("-h", "--help", "wanted", is_flag=True, help="Show this message, or a recipe's.")
@click.pass_context
def derive(
    context: click.Context, recipe: str | None, output: Path | None, form: str, wanted: bool
) -> int:
    """Derive methods and prove them; without a recipe, list the recipes and their options.

    Options of the recipe follow it, as in: glmref derive order6 --c2 1/3 --z "exp(2*pi*i/3)".
    A TOML file stands for the recipe `search` with that ansatz. Exit code 1 when the method is
    proved not to exist.
    """
    from ..derive import recipes

    if wanted:
        say(context.get_help() if recipe is None else _help(recipe))
        return HOLDS
    if recipe is None:
        say(_listing() if form == "table" else json_text(_recipes()))
        return HOLDS
    options = _options(context.args)
    if recipe.endswith(".toml"):
        options, recipe = {"ansatz": recipe, **options}, "search"
    if output is not None:
        make_folder(output.parent if output.suffix == ".json" else output)
    try:
        with _Bar() as bar:
            found = recipes.run(recipe, options, bar.progress)
    except KeyboardInterrupt:
        if recipe == "search":
            state = options.get("state")
            how = f"the same command goes on from {state}" if state else "add --state FILE"
            click.echo(f"to go on later: {how}", err=True)
        raise
    if form == "json":
        say(json_text(_record(found)))
        if output is not None:
            _write(found.documents, output, err=True)
    else:
        _report(found, output)
    return FAILED if found.refused else HOLDS


def _options(words: Sequence[str]) -> dict[str, str]:
    """Read ``--key value`` and ``--key=value``.

    Raises
    ------
    UsageError: for a word that is neither.
    """
    options: dict[str, str] = {}
    rest = list(words)
    while rest:
        word = rest.pop(0)
        key, equals, value = word.removeprefix("--").partition("=")
        if not word.startswith("--") or not key:
            raise UsageError(f"{word!r} is out of place; write options as --name value")
        if not equals:
            if not rest:
                raise UsageError(f"the option --{key} needs a value")
            value = rest.pop(0)
        options[key] = value
    return options


def _listing() -> str:
    """Return the recipes and their options, two lines each."""
    from ..derive import recipes

    lines: list[str] = []
    for name in recipes.names():
        lines.append(f"{name:16}{recipes.describe(name)}")
        options = recipes.options_of(name).items()
        known = " ".join(f"--{key} {value or '...'}" for key, value in options)
        if known:
            lines.append(f"{'':16}{known}")
    return "\n".join(lines)


def _recipes() -> dict[str, Any]:
    from ..derive import recipes

    found = [
        {"name": x, "what": recipes.describe(x), "options": dict(recipes.options_of(x))}
        for x in recipes.names()
    ]
    return {"format": "glmref-recipes-1", "recipes": found}


def _help(recipe: str) -> str:
    """Return what a recipe does, and its options with their defaults."""
    from ..derive import recipes

    name = "search" if recipe.endswith(".toml") else recipe
    options = recipes.options_of(name)
    usage = f"Usage: glmref derive {recipe} [OPTIONS]"
    width = max((len(x) for x in options), default=0)
    known = [
        f"  --{key:{width}}  {f'default: {value}' if value else 'no default'}"
        for key, value in options.items()
    ]
    listed = ["Options:", *known] if known else ["It has no options of its own."]
    general = "See `glmref derive --help` for --output and --format."
    return "\n".join([usage, "", recipes.explain(name), "", *listed, "", general])


def _record(found: Derivation) -> dict[str, Any]:
    return {
        "format": "glmref-derivation-1",
        "recipe": found.recipe,
        "refused": found.refused,
        "statements": [{"text": s.text, "proof": str(s.proof)} for s in found.statements],
        "documents": [dict(document) for document in found.documents],
    }


def _report(found: Derivation, output: Path | None) -> None:
    """Write statements to stderr where a file takes stdout, else to stdout, and files."""
    from ..catalogue.canonical import canonical

    to_stdout = output is None and len(found.documents) == 1
    for statement in found.statements:
        line = f"{statement.proof}: {statement.text}"
        click.echo(line, err=to_stdout)
    if to_stdout:
        click.echo(canonical(dict(found.documents[0])), nl=False)
        return
    if output is not None:
        _write(found.documents, output)
        return
    for document in found.documents:
        say(f"derived {document['name']}; give --output DIR to keep the file")


def _write(documents: Sequence[Mapping[str, Any]], output: Path, *, err: bool = False) -> None:
    """Write one file where the name says so and there is one, else a folder of files."""
    from ..catalogue.canonical import canonical

    alone = output.suffix == ".json" and len(documents) == 1
    if output.suffix == ".json" and not alone:
        output = make_folder(output.with_suffix(""))
    for document in documents:
        path = output if alone else output / f"{document['name']}.json"
        write_text(path, canonical(dict(document)))
        click.echo(f"wrote {one_line(path)}", err=err)


class _Bar:
    """A progress bar on stderr, silent off a terminal."""

    def __enter__(self) -> _Bar:
        self.bar: Any = None
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.close()

    def progress(self, what: str, done: int, total: int) -> None:
        """Show how far a recipe is."""
        if self.bar is None:
            from tqdm import tqdm

            self.bar = tqdm(total=total, disable=None, leave=False)
        self.bar.total = total
        self.bar.set_description_str(what, refresh=False)
        self.bar.update(done - self.bar.n)
        self.bar.refresh()
