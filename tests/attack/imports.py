"""Mutated tables of other packages: ``glmref import`` reads them or refuses them with a sentence.

The tables are exports of shipped methods whose names, titles and sources hold hostile texts. An
export must be one comment and its code, whatever these say. What is read must be a method file.
"""

import json
import random
import re
from collections.abc import Iterable
from functools import lru_cache

from glmref.catalogue.lookup import document
from glmref.catalogue.reader import load_document
from glmref.errors import GlmrefError
from glmref.exchange.export import TARGETS, export
from glmref.exchange.import_tables import READ, read_table
from glmref.system.terminal import escaped

from .tableaux import SPLINTERS, _splintered

CASES = "tables"
COUNT = 2000
SECONDS = 5.0
NAMES = (
    "heun-2", "rk4", "dormand-prince-5", "kennedy-carpenter-ark-4-3", "stormer-verlet", "ruth-3",
    "g6245",
)  # fmt: skip
#: Texts that would end a comment, go on after it, be a formula or be seen as others.
TEXTS = ("*/ evil(); /*", "a\nevil()", "a\r\x85\u2028evil()", "=# evil() #=", '"""\nevil()\n"""', "a\\", "??/",
         "\x1b[2J", "\u202e\u200b", "\ud800", "=cmd()", "@SUM(1)", "\x00", "</script>", "\uff0bcmd()")  # fmt: skip
#: What a table should not hold, besides what a source should not.
MORE = ("9" * 5000, "1e9999", "1e-9999", "A,9999,9999,1\n", "\uff11", "\u0660.\u0665", '"A": [["0"]],', "/*" * 20_000,
        "A[" * 20_000, "#=" * 20_000, "-" * 50_000, "name,,,x\n", "x" * 200_000)  # fmt: skip


@lru_cache
def _table(name: str, form: str, text: str) -> str:
    """A method in a format, with a text in every place for one; ``""`` where it has no table."""
    given = json.loads(json.dumps(document(name)))
    given |= {"title": text, "notes": [text]}
    given["source"] |= {"citation": f"x{text}", "where": f"x{text}", "doi": text}
    for k, row in enumerate(given.get("embedded", ())):
        given.get("claims", {}).pop("embedded-order", None)
        row["name"] = f"{text}{k}"
    try:
        return export(load_document(given), to=form)
    except GlmrefError:
        return ""


def judge(draw: random.Random) -> tuple[str, Iterable[str]]:
    """Export a method with a hostile text; mutate the table, and read it."""
    name, text, target = draw.choice(NAMES), draw.choice(TEXTS), draw.choice(TARGETS)
    table = _table(name, target, text)
    wrong = []
    for line in table.split("\n"):
        if escaped(line) != line:
            wrong.append(f"{text!r} is written to {target}")
        said = "evil" in line and target not in ("json", "csv")
        if said and (line.strip()[0] not in "*/!#%" or re.search(r"\*/|=#", line)):
            wrong.append(f"{text!r} leaves its comment in {target}")
    if target not in READ or not table:
        return "exported" if table else "no table", wrong
    at = draw.randrange(len(table) + 1)
    mutated = table[:at] + draw.choice((*MORE, *SPLINTERS)) + table[at:]
    mutated = _splintered(draw, draw.choice((table, mutated)))
    found = read_table(mutated, target)
    load_document(found)
    return "read", wrong
