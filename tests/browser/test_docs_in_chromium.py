"""The documentation in a real browser: nothing is cut, broken apart or unreadable."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import glmref
from tests.browser.chromium import visit

pytestmark = [pytest.mark.browser, pytest.mark.slow]
DOCS = Path(__file__).parents[2] / "docs"
PAGES = sorted(page.stem for page in DOCS.glob("*.md"))

#: Texts that stand beyond the window and that nothing scrolls into it.
CUT = """const wide = document.documentElement.clientWidth;
const scrolls = (node) => {
  for (let at = node; at !== document.body; at = at.parentElement)
    if (getComputedStyle(at).overflowX !== 'visible') return true;
  return false;
};
return [...document.querySelectorAll('article *')]
  .filter((node) => node.getBoundingClientRect().right > wide + 1 && !scrolls(node))
  .map((node) => node.textContent.trim().slice(0, 60));"""

#: Names, numbers and formulas of which a part stands in another line.
BROKEN = """return [...document.querySelectorAll('td:first-child code, .number, .formula')]
  .filter((node) => {
    const rows = [...node.getClientRects()].filter((box) => box.width > 0);
    return rows.length > 1;
  }).map((node) => node.textContent);"""

#: Displayed formulas that are wider than the page.
WIDE = """return [...document.querySelectorAll('div:has(> math[display=block])')]
  .filter((node) => node.scrollWidth > node.clientWidth + 1).map((node) => node.textContent);"""

#: Contrast of each paragraph with what is behind it, by the formula of WCAG 2.
CONTRAST = """const light = (text) => {
  const [r, g, b] = text.match(/[0-9.]+/g).map(Number).slice(0, 3).map((x) => x / 255)
    .map((x) => x <= 0.03928 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};
const behind = (node) => {
  for (let at = node; at; at = at.parentElement) {
    const colour = getComputedStyle(at).backgroundColor;
    if (!/, 0\\)$/.test(colour)) return colour;
  }
  return 'rgb(255, 255, 255)';
};
return Math.min(...[...document.querySelectorAll('article p, article td, article math')]
  .map((node) => [light(getComputedStyle(node).color), light(behind(node))].sort())
  .map(([a, b]) => (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05)));"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("myst_parser", reason="the extra `docs` is not installed")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-W", "-q", str(DOCS), str(folder)]
    subprocess.run(command, check=True, timeout=300)
    return folder


@pytest.mark.parametrize("page", PAGES)
def test_a_page_is_readable_on_a_phone_and_on_a_desk(chromium: Any, site: Path, page: str) -> None:
    for width, dark in ((360, True), (1280, False)):
        visit(chromium, site / f"{page}.html", width=width, dark=dark)
        inner, wide = chromium.execute_script(
            "const page = document.documentElement; return [page.clientWidth, page.scrollWidth]"
        )
        assert wide <= inner
        assert chromium.execute_script(CUT) == []
        assert chromium.execute_script(BROKEN) == []
        if page != "api":
            assert chromium.execute_script(CONTRAST) >= 4.5
        if width == 1280:
            assert chromium.execute_script(WIDE) == []


def test_the_checks_see_what_they_look_for(chromium: Any, tmp_path: Path) -> None:
    page = tmp_path / "bad.html"
    page.write_text(
        "<!doctype html><article><table><tr><td><p style='color: #999; width: 3em'>"
        "<span class=number>1.2e- 13</span></p></td></tr></table>"
        "<p style='width: 2000px'>wide</p>"
        "<div style='width: 9em; overflow: auto'><math display=block>"
        f"<mtext>{'m' * 40}</mtext></math></div></article>",
        encoding="utf-8",
    )
    visit(chromium, page, width=360)
    assert "wide" in chromium.execute_script(CUT)
    assert chromium.execute_script(BROKEN) == ["1.2e- 13"]
    assert chromium.execute_script(WIDE) == ["m" * 40]
    assert chromium.execute_script(CONTRAST) < 3


@pytest.mark.parametrize("dark", [False, True])
def test_a_picture_in_a_file_of_its_own_follows_the_desktop(
    chromium: Any, tmp_path: Path, *, dark: bool
) -> None:
    path = glmref.plot("rk4").save(tmp_path / "rk4.svg")
    visit(chromium, path, dark=dark, script=False)
    style = "return getComputedStyle(document.documentElement).filter"
    assert ("invert" in chromium.execute_script(style)) is dark
    # within a page it is not the root, and the page has a style of its own
    page = tmp_path / "page.html"
    page.write_text(path.read_text(encoding="utf-8"), encoding="utf-8")
    visit(chromium, page, dark=dark)
    shown = "return getComputedStyle(document.querySelector('svg')).filter"
    assert chromium.execute_script(shown) == "none"
