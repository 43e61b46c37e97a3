"""Pages are short: words of a page, characters of a paragraph, words of a sentence, rows of a table.

A list item is a paragraph. Blocks of code and displayed formulas belong to no paragraph, a formula
in a sentence is one word.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {page.stem: page for page in sorted(DOCS.glob("*.md"))}
WORDS, PARAGRAPH, SENTENCE, ROWS = 1200, 600, 45, 12
#: Pages in which readers look up one entry, formula or proof: as many words and rows as it takes.
REFERENCE = {
    "adapters",
    "api",
    "certificates",
    "coq",
    "feed",
    "limits",
    "pairs-growth",
    "vocabulary",
}
#: What a page does not keep yet. Only ever take something out of this list.
NOT_YET: dict[str, set[str]] = {
    "certificates": {"paragraph", "sentence"},
}
ABBREVIATION = re.compile(r"\b(e\.g|i\.e|et al|cf|vs|No|p|pp|Vol|Sect|Eq)\.$")


def blocks(text: str) -> list[str]:
    """Return the paragraphs, list items and tables of a page, without code, comments, headings."""
    text = re.sub(r"^(```|~~~).*?^\1", "\n\n", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"<!--.*?-->", "\n\n", text, flags=re.DOTALL)
    text = re.sub(r"^#.*$", "\n\n", text, flags=re.MULTILINE)
    text = re.sub(r"\$\$.+?\$\$", "\n\n", text, flags=re.DOTALL)
    text = re.sub(r"^\s*([*+-]|\d+\.)\s+(?=\S)", "\n\n", text, flags=re.MULTILINE)
    return [block.strip() for block in re.split(r"\n\s*\n", text) if block.strip()]


def sentences(paragraph: str) -> list[str]:
    """Return the sentences of a paragraph, whose formulas and code are one word each."""
    text = re.sub(r"\$[^$]+\$|`[^`]+`", "Code", " ".join(paragraph.split()))
    found, begun = [], ""
    for part in re.split(r"(?<=[.!?])(?:\*\*)?\)?\s+(?=[A-Z(*{\[<])", text):
        begun = f"{begun} {part}".strip()
        if not ABBREVIATION.search(begun):
            found.append(begun)
            begun = ""
    return [*found, begun] if begun else found


def excess(name: str, text: str) -> dict[str, int]:
    """Return the limits that a page does not keep, and what it reaches in each."""
    tables = [block for block in blocks(text) if block.startswith("|")]
    paragraphs = [block for block in blocks(text) if not block.startswith("|")]
    most = {
        "paragraph": (PARAGRAPH, [len(" ".join(x.split())) for x in paragraphs]),
        "sentence": (SENTENCE, [len(x.split()) for p in paragraphs for x in sentences(p)]),
    }
    if name not in REFERENCE:
        most["words"] = (WORDS, [len(text.split())])
        most["rows"] = (ROWS, [table.count("\n") - 1 for table in tables])
    return {
        what: max(found) for what, (limit, found) in most.items() if max(found, default=0) > limit
    }


@pytest.mark.parametrize("name", PAGES)
def test_a_page_keeps_the_limits(name: str) -> None:
    found = excess(name, PAGES[name].read_text(encoding="utf-8"))
    assert set(found) <= NOT_YET.get(name, set()), f"{name}: {found}"


def test_the_lists_name_pages() -> None:
    assert REFERENCE | set(NOT_YET) <= set(PAGES)


def test_each_limit_is_seen() -> None:
    row = "| a | b |\n"
    long = "Word " * SENTENCE
    assert excess("x", f"{row}|---|---|\n{row * ROWS}\n\n{long.strip()}.\n") == {}
    assert excess("x", f"{row}|---|---|\n{row * (ROWS + 1)}") == {"rows": ROWS + 1}
    assert excess("x", f"{long}word.") == {"sentence": SENTENCE + 1}
    assert excess("x", f"* {long.strip()}.\n* {long.strip()}. Word.") == {}
    assert excess("x", "Letters. " * 67) == {"paragraph": 602}
    assert excess("x", "Letters.\n\n" * (WORDS + 1)) == {"words": WORDS + 1}
    assert excess("coq", "Letters.\n\n" * (WORDS + 1)) == {}
    assert excess("x", f"```\n{long}word.\n```\n$$ {long} word $$") == {}
