"""The documentation is true: examples run, printed output is the output, the site builds.

On a page, Python blocks run on their own; JSON and TOML blocks introduced by "`NAME`" are files;
of a console block each line ``$ glmref ...`` is run among these files, one after another. Where
output follows it must be the output; ``# exit N`` after a command is its exit code.
"""

import doctest
import io
import json
import re
import runpy
import shlex
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import glmref
from glmref.cli import main

DOCS = Path(__file__).parents[2] / "docs"
PAGES = sorted(page.name for page in DOCS.glob("*.md"))
FENCE = re.compile(r"^```(python|json|toml|console)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
#: Pages whose commands, or whose examples in Python, take more than a few seconds.
SLOW = {"derive.md", "feed.md", "quickstart.md", "scenes.md"}
SLOW_EXAMPLES = {"choose.md", "quickstart.md"}
MEASURED = DOCS.parent / "data" / "measurements"


def text(page: str) -> str:
    return (DOCS / page).read_text(encoding="utf-8")


def files(page: str) -> dict[str, str]:
    """Blocks that stand for files, by the last name in backquotes before them."""
    found = {}
    for block in FENCE.finditer(text(page)):
        if block[1] in ("json", "toml"):
            names = re.findall(rf"`([\w.-]+\.{block[1]})`", text(page)[: block.start()])
            if names:
                found[names[-1]] = block[2]
    return found


def commands(page: str) -> list[tuple[str, int, str]]:
    """Commands of glmref on a page: the words, the exit code, the output shown."""
    found = []
    for block in FENCE.finditer(text(page)):
        if block[1] != "console":
            continue
        for part in re.split(r"^\$ ", block[2], flags=re.MULTILINE)[1:]:
            line, _, shown = part.partition("\n")
            command, _, remark = line.partition("#")
            code = re.fullmatch(r"\s*exit (\d)", remark)
            # what goes through a shell is carried out by the test of its page
            if command.startswith("glmref ") and ">" not in command:
                found.append((command.strip(), int(code[1]) if code else 0, shown.strip()))
    return found


FORMULA = re.compile(r"\$\$.+?\$\$", re.DOTALL)


def prose(source: str) -> str:
    """Markdown without its fenced blocks."""
    return re.sub(r"^(```|~~~).*?^\1", "", source, flags=re.MULTILINE | re.DOTALL)


def run_on(source: str) -> list[str]:
    """Displayed formulas that do not stand between blank lines: they are set within the text."""
    source = "\n\n" + prose(source) + "\n\n"
    return [
        found[0]
        for found in FORMULA.finditer(source)
        if source[: found.start()].rstrip(" ")[-2:] != "\n\n"
        or source[found.end() :].lstrip(" ")[:2] != "\n\n"
    ]


@pytest.mark.parametrize("page", PAGES)
def test_displayed_formulas_stand_between_blank_lines(page: str) -> None:
    assert run_on(text(page)) == []
    assert "$$" not in FORMULA.sub("", prose(text(page)))  # each has an end


def test_a_displayed_formula_within_a_paragraph_is_seen() -> None:
    assert run_on("Insert:\n\n$$ a = b $$\n\nThe rest") == []
    assert run_on("Insert:\n$$ a = b $$\n\nThe rest") == ["$$ a = b $$"]
    assert run_on("Insert:\n\n$$ a = b $$\nThe rest") == ["$$ a = b $$"]
    pairs = text("pairs-theory.md")
    assert run_on(pairs.replace("outputs:\n\n$$", "outputs:\n$$")) != run_on(pairs)


def marked(pages: list[str], slow: set[str]) -> list[object]:
    return [pytest.param(page, marks=pytest.mark.slow) if page in slow else page for page in pages]


@pytest.mark.sampled(0)
@pytest.mark.parametrize("page", marked([page for page in PAGES if commands(page)], SLOW))
def test_the_commands_do_what_the_page_shows(page, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    for name, content in files(page).items():
        (tmp_path / name).write_text(content, encoding="utf-8")
    for words, code, shown in commands(page):
        returned = main(shlex.split(words)[1:])
        said = capfd.readouterr()
        assert returned == code, f"{words}: {said.err}"
        assert "Traceback" not in said.err
        if shown:
            assert said.out.strip() == shown, words


EXAMPLES = [page for page in PAGES if "```python\n" in text(page)]


@pytest.mark.sampled(4)
@pytest.mark.parametrize("page", marked(EXAMPLES, SLOW_EXAMPLES))
def test_the_python_examples_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.stdin", io.StringIO())
    for block in FENCE.finditer(text(page)):
        if block[1] == "python":
            exec(compile(block[2], page, "exec"), {"__name__": "__main__"})


def test_the_examples_are_found() -> None:
    assert {"my-heun.json", "my-slip.json"} <= files("your-tableau.md").keys()
    assert len(commands("your-tableau.md")) >= 3
    assert any(code == 1 for _, code, _ in commands("your-tableau.md"))


@pytest.mark.slow
def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    pytest.importorskip("myst_parser", reason="the extra `docs` is not installed")
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", str(DOCS), str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "quickstart.html").is_file()
    for page in PAGES:
        written = len(FORMULA.findall(prose(text(page))))
        html = (tmp_path / page.replace(".md", ".html")).read_text(encoding="utf-8")
        shown = re.findall(r'<div><math [^>]*display="block"', html)
        if page != "api.md":  # docstrings have formulas, too
            assert len(shown) == written, page
    assert "$$" in text("pairs-theory.md")
    api = (tmp_path / "api.html").read_text(encoding="utf-8")
    assert not re.search(r"\(<em>[^()]*,</em>\)", api)  # no attribute is taken for a type


def test_the_pages_agree_on_the_time_of_a_verification() -> None:
    readme = (DOCS.parent / "README.md").read_text(encoding="utf-8")
    for told in (text("quickstart.md"), readme):
        assert "in about a minute" in " ".join(told.split())


def test_a_record_says_under_one_key_where_it_was_measured():
    for path in MEASURED.glob("*.json"):
        assert not {"machine", "processor"} & json.loads(path.read_text("utf-8")).keys(), path


def test_the_page_of_the_python_interface_has_every_public_name():
    page = text("api.md")
    missing = [x for x in glmref.__all__ if not re.search(rf"glmref\.(\w+\.)*{x}\b", page)]
    assert missing == ["__version__"]


def test_the_promises_of_the_page_on_security_have_tests() -> None:
    page = (DOCS / "security.md").read_text(encoding="utf-8")
    tables = re.findall(r"^\| promise \| test \|\n\|---\|---\|\n((?:\|.*\n)+)", page, re.MULTILINE)
    lines = "".join(tables).splitlines()
    rows = [[x.strip() for x in line.strip("|").split("|")] for line in lines]
    assert len(rows) > 12
    for promise, tests in rows:
        named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", tests)
        assert named and len(named) == tests.count("::"), promise
        for path, function in named:
            assert f"\ndef {function}(" in (DOCS.parent / path).read_text(encoding="utf-8"), (
                function
            )


def test_primes_and_brackets_do_not_depend_on_a_font_of_mathematics() -> None:
    pytest.importorskip("latex2mathml")
    pytest.importorskip("docutils")
    found = runpy.run_path(str(Path(__file__).parents[2] / "docs" / "conf.py"))["mathml"]
    prime = found("q'' = y'")
    assert "<msup>" not in prime and prime.count("<mo lspace=") == 2 and "&#x02033;" in prime
    matrix = found(r"\begin{pmatrix} 1 & 0 \\ 0 & f(x) \end{pmatrix} (x)")
    table = matrix[matrix.index("<mtable") : matrix.index("</mtable>")]
    assert matrix.count('<mtable class="matrix">') == 1 and "f" in table
    # brackets of functions stay: two inside of the matrix, two behind it
    assert matrix.count("&#x00028;") == matrix.count("&#x00029;") == 2
    assert found(r"|\zeta| = 1").count('lspace="0" rspace="0">&#x0007C;') == 2
    assert "&#x02102;" in found(r"\mathbb C^r") and "bold" in found(r"\mathbf 1")


MODULES = sorted(
    ".".join(path.relative_to(DOCS.parent).with_suffix("").parts)
    for path in (DOCS.parent / "glmref").rglob("*.py")
    if ">>> " in path.read_text(encoding="utf-8")
)


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_of_the_docstrings_are_as_printed(name: str) -> None:
    found = doctest.testmod(import_module(name))
    assert found.attempted and not found.failed
