"""The page that checks a tableau in the browser: right, readable, and nothing leaves it."""

import json
from typing import Any

import pytest

from glmref.catalogue.lookup import load
from glmref.exchange.feed import CHECKERS, tableau_text
from tests.browser.chromium import visit
from tests.suite.test_small_checkers import SOME, WRONG, agrees

pytestmark = [pytest.mark.browser, pytest.mark.slow]
PAGE = CHECKERS / "index.html"


def answer(chromium: Any, text: str) -> str:
    """What the page says to a tableau that is written into it."""
    place = chromium.find_element("id", "tableau")
    chromium.execute_script("arguments[0].value = arguments[1]", place, text)
    chromium.find_element("id", "check").click()
    return chromium.find_element("id", "answer").text


@pytest.mark.parametrize("width", [360, 1280])
@pytest.mark.parametrize("dark", [False, True])
def test_the_page_fits_and_answers(chromium: Any, width: int, dark: bool) -> None:
    visit(chromium, PAGE, width=width, dark=dark)
    said = chromium.find_element("id", "answer").text
    assert "7 stages; decided exactly" in said and "fails at the tree [ooooo]" in said
    page = "const page = document.documentElement; return page.scrollWidth <= page.clientWidth"
    assert chromium.execute_script(page)
    for text, sentence in WRONG:
        assert answer(chromium, text) == sentence
    assert "8 or more" in answer(chromium, tableau_text(load("gauss-5")))
    assert chromium.execute_script(page)
    messages = [json.loads(x["message"])["message"] for x in chromium.get_log("performance")]
    asked = [
        x["params"]["request"]["url"]
        for x in messages
        if x["method"] == "Network.requestWillBeSent"
    ]
    assert asked and all(url.startswith("file:") for url in asked)
    assert [x for x in chromium.get_log("browser") if x["level"] == "SEVERE"] == []


@pytest.mark.parametrize("name", [x for x in SOME if x != "gauss-2-seven-digits"])
def test_the_browser_computes_what_is_proved(chromium: Any, name: str) -> None:
    visit(chromium, PAGE)
    report = chromium.execute_script("return glmrefCheck(arguments[0])", tableau_text(load(name)))
    agrees(name, report)
