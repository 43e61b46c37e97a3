"""Pages are short: words of a page, characters of a paragraph, words of a sentence, rows of a table.

A list item is a paragraph. Blocks of code and displayed formulas belong to no paragraph, a formula
in a sentence is one word. What a page includes is part of it.
"""

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {page.stem: page for page in sorted(DOCS.glob("*.md"))}
WORDS, PARAGRAPH, SENTENCE, ROWS, ALL = 1200, 600, 45, 12, 35_000
#: Pages in which readers look up one entry, and what. They are not among the words of all pages.
REFERENCE = {
    "adapters": "interface, checks and protocol of adapters",
    "api": "names of the Python interface",
    "certificates": "the format of certificates and the rules of the judge",
    "feed": "files and keys of the feed",
    "vocabulary": "terms",
}
#: Pages whose table is as long as what it lists.
LONG_TABLE = {"coq", "limits", "pairs-growth"}
#: The report of a measurement or an audit, with all its tables, stands beside its program or data
#: and is included. These pages are records, and may only become shorter: words of all, as written.
INCLUDE = re.compile(r"^```\{include\} (\S+)\n```$", re.MULTILINE)
RECORDS = {name for name, page in PAGES.items() if INCLUDE.search(page.read_text("utf-8"))}
RECORDED = 47_100
ABBREVIATION = re.compile(r"\b(e\.g|i\.e|et al|cf|vs|No|Vol|Sect|Eq)\.$")


def read(page: Path) -> str:
    """Return a page with what it includes."""
    text = page.read_text(encoding="utf-8")
    return INCLUDE.sub(lambda found: read(page.parent / found[1]), text)


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
    if name not in {*REFERENCE, *LONG_TABLE, *RECORDS}:
        most["words"] = (WORDS, [len(text.split())])
        most["rows"] = (ROWS, [table.count("\n") - 1 for table in tables])
    return {
        what: max(found) for what, (limit, found) in most.items() if max(found, default=0) > limit
    }


@pytest.mark.parametrize("name", PAGES)
def test_a_page_keeps_the_limits(name: str) -> None:
    found = excess(name, read(PAGES[name]))
    assert not found, f"{name}: {found}"


def total(pages: set[str]) -> int:
    """Return the words of some pages."""
    return sum(len(read(PAGES[name]).split()) for name in pages)


def test_all_pages_keep_the_limit_together() -> None:
    assert total(PAGES.keys() - REFERENCE.keys() - RECORDS) <= ALL
    assert total(RECORDS) <= RECORDED


def test_what_a_page_includes_is_part_of_it(tmp_path: Path) -> None:
    (tmp_path / "a.md").write_text("One\n```{include} b/c.md\n```\n", encoding="utf-8")
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "c.md").write_text("two three", encoding="utf-8")
    assert read(tmp_path / "a.md").split() == ["One", "two", "three"]


def test_the_lists_name_pages() -> None:
    assert {*REFERENCE, *LONG_TABLE} <= set(PAGES)
    assert not REFERENCE.keys() & (LONG_TABLE | RECORDS)


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
