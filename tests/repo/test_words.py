"""Pages use the usual words: each pattern is followed by what to write instead."""

import re
from pathlib import Path

import pytest

from tests.repo.test_page_limits import read

ROOT = Path(__file__).parents[2]
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md")),
    *(ROOT / "docs").glob("*.md"),
]
#: What reads as if it were translated or is a word of ours -> what to write.
USUAL = {
    r"anew": "again",
    r"for ever": "forever, or how long it takes",
    r"(?:nobody|whoever)": "which program, reader or user",
    r"(?:is|are|was|were) asked for": "requested, required",
    r"(?:is|are) told": "is reported, is distinguished",
    r"(?:has|have) not (?:the|a|an)": "does not have, lacks",
    r"strangers?": "untrusted, unexpected",
    r"what rounding took": "rounding residual",
    r"and the like": "such as",
    r"(?:where|there|here)(?:by|of|upon)": "which, so that",
}
ANY = re.compile(rf"\b({'|'.join(USUAL)})\b")


def found(text: str) -> list[str]:
    """Return the phrases to replace, across the ends of lines."""
    plain = re.sub(r"\s+", " ", text.lower())
    return [m[0] for m in ANY.finditer(plain)]


@pytest.mark.parametrize("page", PAGES, ids=lambda x: x.name)
def test_the_usual_words_are_used(page: Path) -> None:
    assert found(read(page)) == [], USUAL


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("It is made Anew; renewed, anewer", ["anew"]),
        ("It is\nasked for; it is asked to go", ["is asked for"]),
        ("This has\n    not the rows. It has not been read.", ["has not the"]),
    ],
)
def test_a_phrase_is_found_across_lines(text: str, words: list[str]) -> None:
    assert found(text) == words
