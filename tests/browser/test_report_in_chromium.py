"""The report in a real browser: nothing fails, nothing leaves the page, everything works.

Chromium and its driver (Debian: ``apt install chromium chromium-driver``) with selenium; skipped
where one of them is absent. Records are those of a short run.
"""

import json
import os
import shutil
import time
from pathlib import Path
from typing import Any

import pytest

from glmref import scenes
from glmref.catalogue.lookup import data_root, names
from glmref.compute.records import Records
from glmref.report import build, read
from glmref.report.markup import number
from tests.browser.chromium import visit

pytestmark = [pytest.mark.browser, pytest.mark.slow]

METHODS = ("rk4", "gauss-2", "gsymplectic-n", "pair-4-4", "g6245-w3", "order8-s3-w3-i")
NAME = "oscillator-quick"


@pytest.fixture(scope="module")
def records(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    store = Records(tmp_path_factory.mktemp("run") / f"{NAME}.sqlite")
    return scenes.run(scenes.load_scene("oscillator", quick=True), store)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory, records: list[dict[str, Any]]) -> Path:
    """Pages of every kind: runs, curves over time, a large run, odd records, a portrait."""
    source, folder = tmp_path_factory.mktemp("in"), tmp_path_factory.mktemp("out") / "site"
    odd = [
        {**records[0], "state_error": float("nan")},
        {**records[1], "outcome": "not finite", "message": "left the numbers"},
        {"format": "glmref-record-9"},
        *({**x, "series": [[0.1 * k, 1e-9 * k] for k in range(1, 40)]} for x in records[2:5]),
    ]
    many = [
        {**records[n % len(records)], "evaluations": 1000 + n, "state_error": 1.0 / (n + 1)}
        for n in range(5000)
    ]
    for name, lines in ((NAME, records), ("odd", odd), ("many", many)):
        # what a test changed is not damage, and no second record of the same task
        told = [{**line, "key": f"{n:016x}", "sha256": None} for n, line in enumerate(lines)]
        sound = [{k: x for k, x in line.items() if k != "sha256"} for line in told]
        text = "".join(json.dumps(line) + "\n" for line in sound)
        (source / f"{name}.jsonl").write_text(text, encoding="utf-8")
    (source / "rk4.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 820 430" width="820" height="430">'
        "<title>rk4</title></svg>",
        encoding="utf-8",
    )
    findings = [{"method": "rk4", "claim": "order", "verdict": "holds", "proof": "exact"}]
    document = {"format": "glmref-findings-1", "findings": findings}
    (source / "findings.json").write_text(json.dumps(document), encoding="utf-8")
    cases = [{"case": "one", "methods": [{"method": "rk4", "curve": [[100, 1e-3], [200, 1e-5]]}]}]
    document = {"format": "glmref-measurement-1", "title": "curves", "cases": cases, "rows": [
        {"name": "a", "error": 1e-3, "seconds": 0.5}, {"name": "b", "error": 1e-5, "seconds": 1.5},
    ]}  # fmt: skip
    (source / "needs.json").write_text(json.dumps(document), encoding="utf-8")
    shutil.copyfile(data_root() / "measurements" / "stability.json", source / "stability.json")
    results = read([source], METHODS)
    build(results, folder, methods=METHODS)
    build(results, folder.parent / "one.html", single=True, methods=METHODS)
    return folder


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory, records: list[dict[str, Any]]) -> Path:
    """The report of all methods and of everything that comes with the data, and one run."""
    source, folder = tmp_path_factory.mktemp("in"), tmp_path_factory.mktemp("whole") / "site"
    text = "".join(json.dumps(line) + "\n" for line in records)
    (source / f"{NAME}.jsonl").write_text(text, encoding="utf-8")
    build(read([source, data_root() / "measurements"]), folder)
    return folder


def requests(driver: Any) -> list[str]:
    """Addresses that were asked for since the last visit."""
    messages = [json.loads(x["message"])["message"] for x in driver.get_log("performance")]
    return [
        x["params"]["request"]["url"]
        for x in messages
        if x["method"] == "Network.requestWillBeSent"
    ]


#: Texts of pictures that leave them.
CUT = """return [...document.querySelectorAll('svg.chart')].flatMap((svg) => {
  const room = svg.getBoundingClientRect();
  return [...svg.querySelectorAll('text')].filter((text) => {
    const box = text.getBoundingClientRect();
    return box.left < room.left - 1 || box.right > room.right + 1 || box.top < room.top - 1
      || box.bottom > room.bottom + 1;
  }).map((text) => text.textContent);
});"""

PAGES = (
    *("index", "audits", "errata", "measured", "measured-needs", "search"),
    *(f"run-{NAME}", "run-odd", "run-many"),
    *(f"method-{name}" for name in METHODS),
)


@pytest.mark.parametrize("page", PAGES)
def test_a_page_opens_without_error_or_request_and_fits_a_phone(chromium, site, page):
    for width, dark in ((1200, False), (360, True)):
        visit(chromium, site / f"{page}.html", width=width, dark=dark)
        assert chromium.get_log("browser") == []
        assert all(url.startswith(("file:", "data:")) for url in requests(chromium))
        inner, wide = chromium.execute_script(
            "return [document.documentElement.clientWidth, document.documentElement.scrollWidth]"
        )
        assert wide <= inner
        assert chromium.execute_script("return document.querySelectorAll('h1').length") == 1
        assert chromium.execute_script(CUT) == []


#: Words go into the field of the page shown, and Enter is pressed.
ASK = """const own = document.querySelector('.search input');
own.value = 'petsc WRONG'; own.dispatchEvent(new KeyboardEvent('keydown', { key: 'Enter' }));"""
#: Rows of the search that are shown.
SHOWN = """return [...document.querySelectorAll('table.found tbody tr')]
  .filter((row) => !row.hidden).map((row) => row.textContent);"""


@pytest.mark.parametrize("file", ["site/method-rk4.html", "one.html"])
def test_the_field_of_a_page_finds_what_holds_all_words(chromium, site, file):
    visit(chromium, site.parent / file)
    display = "return getComputedStyle(document.querySelector('.search')).display"
    assert chromium.execute_script(display) != "none"
    chromium.execute_script(ASK)
    for _ in range(100):  # until the page of the search is there
        if "search" in chromium.current_url and (shown := chromium.execute_script(SHOWN)):
            break
        time.sleep(0.05)
    assert len(shown) == 1 and "TSARKIMEXBPR3" in shown[0] and "should be 3/4" in shown[0]
    assert chromium.get_log("browser") == []


def test_a_search_that_finds_nothing_shows_no_row(chromium: Any, site: Path) -> None:
    visit(chromium, site / "search.html")
    assert chromium.execute_script(SHOWN) == []  # before a word is typed, neither
    fill = "const x = document.querySelector('.controls input'); x.value = arguments[0];"
    for words, count in (("petsc nonsense", 0), ("rk4 order holds", 1), ("a", 200)):
        chromium.execute_script(fill + "x.dispatchEvent(new Event('input'));", words)
        assert len(chromium.execute_script(SHOWN)) == count


def test_no_column_of_a_run_is_cut_on_a_small_desktop(chromium: Any, site: Path) -> None:
    visit(chromium, site / f"run-{NAME}.html", width=1280)
    room, wide = chromium.execute_script(
        "const x = document.querySelector('.scroll'); return [x.clientWidth, x.scrollWidth]"
    )
    assert wide <= room


def test_every_page_of_the_whole_report_opens(chromium: Any, whole: Path) -> None:
    pages = sorted(whole.glob("*.html"))
    assert len(pages) >= len(names("methods")) + 15
    alike = [page for page in pages if page.stem.startswith("method-")]
    left_out = set(alike) - set(alike if "GLMREF_LONG" in os.environ else alike[::8])
    for page in sorted(set(pages) - left_out):
        visit(chromium, page, width=360)
        assert chromium.get_log("browser") == [], page.name
        assert all(url.startswith(("file:", "data:")) for url in requests(chromium)), page.name
        inner, wide = chromium.execute_script(
            "return [document.documentElement.clientWidth, document.documentElement.scrollWidth]"
        )
        assert wide <= inner, page.name
        assert chromium.execute_script(CUT) == [], page.name


def test_every_kind_of_page_is_among_them(site: Path) -> None:
    assert {path.stem for path in site.glob("*.html")} == set(PAGES)


def cells(driver: Any, id_: str) -> list[dict[str, str]]:
    return driver.execute_script(
        """const table = document.getElementById(arguments[0]);
        const keys = [...table.tHead.rows[0].cells].map((cell) => cell.dataset.key);
        return [...table.tBodies[0].rows].map((row) =>
          Object.fromEntries([...row.cells].map((cell, i) => [keys[i], cell.textContent.trim()])));""",
        id_,
    )


def test_every_number_in_the_document_is_the_stored_one(chromium: Any, site: Path, records) -> None:
    visit(chromium, site / f"run-{NAME}.html")
    rows = cells(chromium, f"t-{NAME}")
    assert len(rows) == len(records)
    for row, record in zip(rows, records, strict=True):
        assert row["method"] == record["task"]["method"]
        for key in ("steps", "state_error", "energy_error", "evaluations", "iterations"):
            if key in row:
                assert row[key] == number(record.get(key))
        assert row["seconds"] == number(record["seconds"]["median"])
        assert (row["q25"], row["q75"]) == tuple(
            number(record["seconds"][k]) for k in ("q25", "q75")
        )


def drawn_orbits(records: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Of each method the record of the largest step: no orbit of these ends early."""
    assert all(record["orbit"]["ended"] is None for record in records)
    found: dict[str, dict[str, Any]] = {}
    for record in records:
        known = found.setdefault(record["task"]["method"], record)
        if record["task"]["h"] > known["task"]["h"]:
            found[record["task"]["method"]] = record
    return list(found.values())


def test_every_point_of_an_orbit_is_the_stored_one_and_is_drawn(chromium, site, records):
    visit(chromium, site / f"run-{NAME}.html")
    rows = cells(chromium, f"o-{NAME}")
    kept = [
        (record["task"]["method"], *point)
        for record in drawn_orbits(records)
        for path in record["orbit"]["paths"]
        for point in path
    ]
    assert len(kept) >= 1000
    assert [(x["method"], x["t"], x["x"], x["y"]) for x in rows] == [
        (name, *map(number, point)) for name, *point in kept
    ]
    drawn = chromium.execute_script(
        """return [...document.querySelectorAll(arguments[0] + ' g[data-series]')].map((group) =>
          [group.dataset.series, [...group.querySelectorAll('.mark')].map((mark) =>
            mark.getAttribute('transform').match(/[-\\d.]+/g).slice(0, 2).map(Number))]);""",
        ORBIT,
    )
    assert [name for name, _ in drawn] == list(dict.fromkeys(name for name, *_ in kept))
    for name, marks in drawn:
        points = [(x, y) for other, _, x, y in kept if other == name]
        assert len(marks) == len(points)
        # one unit is as long on both axes: places are the points, scaled and moved
        (u0, v0), (x0, y0) = marks[0], points[0]
        far = max(range(len(points)), key=lambda k: abs(points[k][0] - x0))
        unit = (marks[far][0] - u0) / (points[far][0] - x0)
        assert unit > 20
        for (u, v), (x, y) in zip(marks, points, strict=True):
            # a tenth of a pixel is written, at both ends and in the unit
            assert abs(u - u0 - unit * (x - x0)) < 0.3 and abs(v - v0 + unit * (y - y0)) < 0.3


def test_an_orbit_is_pointed_at_and_its_panels_are_hidden_and_shown(chromium, site, records):
    visit(chromium, site / f"run-{NAME}.html")
    panels = f'return document.querySelectorAll("{ORBIT} rect.frame").length'
    before = chromium.execute_script(panels)
    assert before == len(drawn_orbits(records)) > 8
    chromium.execute_script(
        """const mark = document.querySelectorAll(arguments[0] + ' svg.chart .mark')[7];
        mark.scrollIntoView({block: 'center'});
        const box = mark.getBoundingClientRect();
        mark.closest('svg').dispatchEvent(new PointerEvent('pointermove', {bubbles: true,
          clientX: box.x + box.width / 2, clientY: box.y + box.height / 2}));""",
        ORBIT,
    )
    said = chromium.find_element("css selector", f"{ORBIT} .status").text
    record = drawn_orbits(records)[0]
    told = [
        f"step size h: {number(record['task']['h'])}; time t: {number(t)}; "
        f"q: {number(x)}; p: {number(y)}"
        for t, x, y in record["orbit"]["paths"][0]
    ]
    assert said.startswith(f"method: {record['task']['method']}; ")
    assert said.partition("; ")[2] in told
    chromium.find_element("css selector", f"{ORBIT} .legend button[aria-pressed]").click()
    assert chromium.execute_script(panels) == before - 1
    button = chromium.find_element("css selector", f"{ORBIT} .legend button.all")
    button.click()
    assert chromium.execute_script(panels) == 0
    button.click()
    assert chromium.execute_script(panels) == before


def test_menus_work_with_the_keyboard_and_without_a_script(chromium: Any, site: Path) -> None:
    from selenium.webdriver.common.keys import Keys

    for path in (site / "index.html", site.parent / "one.html"):
        for script in (True, False):
            chromium.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": not script})
            try:
                visit(chromium, path, width=360, script=script)
                menu = chromium.find_elements("css selector", "nav details")[-1]
                link = menu.find_element("css selector", "a[href*='method-rk4']")
                assert not link.is_displayed()
                menu.find_element("css selector", "summary").send_keys(Keys.ENTER)
                assert link.is_displayed() and menu.get_attribute("open") is not None
                assert link.rect["x"] >= 0 and link.rect["x"] + link.rect["width"] <= 360
                link.send_keys(Keys.ENTER)
                assert chromium.current_url.rpartition("/")[2].endswith(
                    "method-rk4.html" if path.name == "index.html" else "#method-rk4"
                )
                heads = chromium.find_elements("css selector", "h1")
                shown = [x.text for x in heads if x.is_displayed()]
                assert shown == ["Classical Runge-Kutta method of order 4"]
            finally:
                chromium.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})


FIGURE = f"figure[data-table='t-{NAME}']"
ORBIT = f"figure[data-table='o-{NAME}']"


def status(driver: Any) -> str:
    return driver.execute_script(
        "return document.querySelector(arguments[0] + ' .status').textContent", FIGURE
    )


def marks(driver: Any) -> int:
    return driver.execute_script(
        "return document.querySelectorAll(arguments[0] + ' svg.chart .mark').length", FIGURE
    )


def completed(records: list[dict[str, Any]], key: str) -> list[dict[str, Any]]:
    return [x for x in records if x["outcome"] == "completed" and (x.get(key) or 0) > 0]


def test_every_completed_run_is_a_mark_at_the_place_of_its_numbers(chromium, site, records):
    visit(chromium, site / f"run-{NAME}.html")
    error = chromium.execute_script(
        "return document.querySelectorAll(arguments[0] + ' select')[1].value", FIGURE
    )
    drawn = completed(records, error)
    assert marks(chromium) == len(drawn) >= 10
    places = chromium.execute_script(
        """return [...document.querySelectorAll(arguments[0] + ' svg.chart .mark')].map((mark) =>
          mark.getAttribute('transform').match(/[-\\d.]+/g).map(Number));""",
        FIGURE,
    )
    by_method: dict[str, list[dict[str, Any]]] = {}
    for record in drawn:
        by_method.setdefault(record["task"]["method"], []).append(record)
    ordered = [x for group in by_method.values() for x in group]
    # further to the right is slower and higher up is a larger error, for every pair
    for (u, v), a in zip(places, ordered, strict=True):
        for (x, y), b in zip(places, ordered, strict=True):
            if a["seconds"]["median"] > 1.05 * b["seconds"]["median"]:
                assert u > x
            if a[error] > 1.05 * b[error]:
                assert v < y


def test_pointing_at_a_mark_shows_its_record(chromium: Any, site: Path, records) -> None:
    visit(chromium, site / f"run-{NAME}.html")
    chromium.execute_script(
        """const mark = document.querySelectorAll(arguments[0] + ' svg.chart .mark')[1];
        const box = mark.getBoundingClientRect();
        mark.closest('svg').dispatchEvent(new PointerEvent('pointermove', {bubbles: true,
          clientX: box.x + box.width / 2, clientY: box.y + box.height / 2}));""",
        FIGURE,
    )
    shown = status(chromium)
    record = next(
        x for x in records if f"steps: {x['steps']};" in shown and x["task"]["method"] in shown
    )
    for value in (record["seconds"]["median"], record["seconds"]["q25"], record["evaluations"]):
        assert f": {number(value)}" in shown
    assert f"step size h: {number(record['task']['h'])}" in shown


def test_the_keyboard_goes_from_point_to_point(chromium: Any, site: Path) -> None:
    from selenium.webdriver.common.keys import Keys

    visit(chromium, site / f"run-{NAME}.html")
    svg = chromium.find_element("css selector", f"{FIGURE} svg.chart")
    svg.send_keys(Keys.HOME)
    seen = [status(chromium)]
    for key in (Keys.ARROW_RIGHT, Keys.ARROW_DOWN, Keys.END, Keys.ARROW_UP):
        svg.send_keys(key)
        seen.append(status(chromium))
    first, right, down, end, up = seen
    method = [text.partition(";")[0] for text in seen]
    assert all(text.startswith("method: ") for text in seen)
    assert right != first and method[1] == method[0]
    assert method[2] != method[0] and end.startswith(method[2]) and method[4] == method[0]
    assert up == right and end == down
    ring = f"return document.querySelector(\"{FIGURE} .ring\").getAttribute('visibility')"
    assert chromium.execute_script(ring) == "visible"


def pressed(chromium: Any, site: Path, which: str) -> tuple[Any, int]:
    """Press a button of the legend; return it, and the number of marks before."""
    visit(chromium, site / f"run-{NAME}.html")
    before = marks(chromium)
    button = chromium.find_element("css selector", f"{FIGURE} .legend button{which}")
    button.click()
    return button, before


def test_the_legend_hides_and_shows_a_method(chromium: Any, site: Path) -> None:
    button, before = pressed(chromium, site, "[aria-pressed]")
    assert button.get_attribute("aria-pressed") == "false" and marks(chromium) < before
    button.click()
    assert button.get_attribute("aria-pressed") == "true" and marks(chromium) == before


def test_all_lines_are_hidden_and_shown_at_once(chromium: Any, site: Path) -> None:
    button, before = pressed(chromium, site, ".all")
    drawn = chromium.find_element("css selector", f"{FIGURE} svg.chart").text
    assert marks(chromium) == 0 and "nothing to draw" in drawn
    chromium.find_element("css selector", f"{FIGURE} .legend button[aria-pressed]").click()
    assert 0 < marks(chromium) < before
    button.click()
    assert marks(chromium) == before


def test_a_method_has_the_same_colour_in_all_pictures(chromium: Any, site: Path) -> None:
    found: dict[str, set[str]] = {}
    for page in (f"run-{NAME}", "run-odd", "run-many"):
        visit(chromium, site / f"{page}.html")
        drawn = chromium.execute_script(
            """return [...document.querySelectorAll('.legend button[aria-pressed]')].map((x) =>
              [x.textContent, getComputedStyle(x.querySelector('.mark')).stroke]);"""
        )
        for name, colour in drawn:
            found.setdefault(name.partition(", ")[0], set()).add(colour)
    assert len(found) > 8 and all(len(colours) == 1 for colours in found.values())


def test_the_axes_can_be_chosen(chromium: Any, site: Path) -> None:
    from selenium.webdriver.support.select import Select

    visit(chromium, site / f"run-{NAME}.html")
    across, up = (Select(x) for x in chromium.find_elements("css selector", f"{FIGURE} select"))
    assert [x.get_attribute("value") for x in across.options][:3] == [
        "seconds",
        "evaluations",
        "steps",
    ]
    assert {"state_error", "energy_error"} >= {x.get_attribute("value") for x in up.options}
    title = f'return document.querySelector("{FIGURE} .x-title").textContent'
    for option in ("evaluations", "steps", "h"):
        across.select_by_value(option)
        chosen = across.first_selected_option.text
        assert chromium.execute_script(title) == chosen and marks(chromium) > 0


def test_measurements_are_drawn_too(chromium: Any, site: Path) -> None:
    visit(chromium, site / "measured-needs.html")
    drawn = (
        "return [...document.querySelectorAll('figure')]"
        ".map((x) => x.querySelectorAll('svg.chart .line').length)"
    )
    assert chromium.execute_script(drawn) == [1, 2]


def test_what_cannot_be_drawn_is_counted_under_the_picture(chromium: Any, site: Path) -> None:
    visit(chromium, site / "run-odd.html")
    text = chromium.execute_script(
        "return document.querySelector('figure[data-table=\"t-odd\"] .status').textContent"
    )
    assert text.startswith("2 of 5 rows of the table have no place in this picture")
    assert cells(chromium, "t-odd")[0]["state_error"] == "NaN"


def test_5000_records_are_all_there_and_all_drawn(chromium: Any, site: Path) -> None:
    visit(chromium, site / "run-many.html")
    assert len(cells(chromium, "t-many")) == 5000
    drawn = (
        "return document.querySelectorAll('figure[data-table=\"t-many\"] svg.chart .mark').length"
    )
    assert chromium.execute_script(drawn) == 5000


def test_tables_are_sorted_and_filtered(chromium: Any, site: Path) -> None:
    visit(chromium, site / "index.html")
    chromium.find_element("css selector", "th[data-key='order'] button").click()
    orders = [int(row["order"]) for row in cells(chromium, "methods")]
    assert orders == sorted(orders) and len(orders) == len(METHODS)
    chromium.find_element("css selector", "th[data-key='order'] button").click()
    assert [int(row["order"]) for row in cells(chromium, "methods")] == sorted(orders, reverse=True)
    chromium.find_element("css selector", "main input[type=search]").send_keys("rk4")
    shown = (
        "return [...document.querySelectorAll('#methods tbody tr')].filter(r => !r.hidden).length"
    )
    assert chromium.execute_script(shown) == 1


def test_one_file_shows_one_section_at_a_time(chromium: Any, site: Path) -> None:
    visible = (
        "return [...document.querySelectorAll('section.page')]"
        ".filter((x) => x.offsetParent !== null).map((x) => x.id)"
    )
    path = site.parent / "one.html"
    visit(chromium, path)
    assert chromium.execute_script(visible) == ["index"]
    chromium.find_element("css selector", "nav details summary").click()
    link = chromium.find_element("css selector", f"nav a[href='#run-{NAME}']")
    link.click()
    assert not link.is_displayed()  # the menu closes behind it
    assert chromium.execute_script(visible) == [f"run-{NAME}"]
    chromium.execute_async_script(
        "requestAnimationFrame(() => requestAnimationFrame(arguments[0]))"
    )
    assert marks(chromium) >= 10 and chromium.get_log("browser") == []
    assert all(url.startswith(("file:", "data:")) for url in requests(chromium))


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize(
    "page",
    ["index", "errata", "measured", "measured-needs", "run-odd", f"run-{NAME}",
     "method-rk4", "method-pair-4-4"],
)  # fmt: skip
def test_axe_finds_no_serious_fault(chromium: Any, site: Path, page: str, *, dark: bool) -> None:
    package = pytest.importorskip("axe_selenium_python")
    (axe,) = Path(package.__file__).parent.rglob("axe.min.js")
    visit(chromium, site / f"{page}.html", dark=dark, width=360 if dark else 1200)
    # menus and numbers open; rows and marks beyond the first are like them
    chromium.execute_script(
        """document.querySelectorAll('details').forEach((x) => { x.open = true; });
        for (const all of document.querySelectorAll('tbody, g[data-series]'))
          while (all.children.length > 40) all.lastElementChild.remove();"""
    )
    chromium.execute_script(axe.read_text(encoding="utf-8"))
    chromium.set_script_timeout(120)
    found = chromium.execute_async_script(
        "axe.run({resultTypes: ['violations']}).then((r) => arguments[0](r.violations))"
    )
    serious = [x["id"] for x in found if x["impact"] in ("serious", "critical")]
    assert serious == []
