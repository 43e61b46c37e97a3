"""The tables of all pages are those of the data."""

import re

import pytest

from campaigns.pages import all_pages, filled

PAGES = all_pages()
#: Tables that tools/measure/engine_tables.py writes into pages of this package.
OTHERS = {"against-c"}
#: What takes seconds: the periodicity of every pair, in balls.
SLOW = {"growth"}
TABLES = [
    pytest.param(page, name, id=name, marks=pytest.mark.slow if name in SLOW else ())
    for page, names in PAGES.items()
    for name in names
]


@pytest.mark.parametrize(("page", "name"), TABLES)
def test_a_table_of_a_page_is_that_of_the_data(page, name):
    text = page.read_text(encoding="utf-8")
    assert filled(text, {name: PAGES[page][name]}) == text, "run `python -m campaigns.pages`"


@pytest.mark.parametrize(
    "page",  # not the notes of a single campaign, which writes tables of its own there
    [page for page in PAGES if page.parent.name == "docs" or page.name == "README.md"],
    ids=lambda page: f"{page.parent.name}-{page.stem}",
)
def test_every_table_between_marks_is_computed(page):
    there = re.findall(r"<!-- table: (\S+) -->", page.read_text(encoding="utf-8"))
    assert len(set(there)) == len(there) and set(there) - OTHERS == set(PAGES[page])


def test_a_table_is_replaced_in_its_one_place():
    page = "a\n<!-- table: a -->\n| old |\n<!-- end of table -->\nb\n"
    assert filled(page, {"a": lambda: "| new |"}) == page.replace("old", "new")
    for text, count in ((2 * page, 2), (page.replace("table: a", "table: b"), 0)):
        with pytest.raises(ValueError, match=f"{count} places for the table a, not one"):
            filled(text, {"a": lambda: ""})
