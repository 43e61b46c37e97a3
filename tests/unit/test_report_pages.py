"""The pages: every number is the stored one, whatever is stored; nothing that is stored is markup."""

import json
import re
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

import glmref
from glmref import scenes
from glmref.catalogue.audits import STATUSES, audited_codes
from glmref.catalogue.lookup import data_root, document, names
from glmref.cli import main
from glmref.compute.records import Records
from glmref.errors import UsageError
from glmref.report import build, read
from glmref.report.markup import number
from glmref.report.orbits import MOST
from glmref.report.runs import COLUMNS, MOST_BARS
from glmref.report.stability import stability
from tests.build import refused, scene_text

METHODS = ("rk4", "gauss-2", "gsymplectic-n", "pair-4-4")


class Tables(HTMLParser):
    """Tables of a page: id -> rows of cells; the keys of the columns are the first row."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tables: dict[str, list[list[str]]] = {}
        self.now: list[list[str]] = []
        self.words: str | None = None
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag == "table" and given.get("id"):
            self.now = self.tables[str(given["id"])] = []
        elif tag == "tr":
            self.now.append([])
        elif tag == "th":
            self.now[-1].append(str(given.get("data-key")))
        elif tag == "td":
            self.now[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        if tag == "table":
            self.now = []

    def handle_data(self, data: str) -> None:
        if self.now and self.now[-1] and len(self.now) > 1:
            self.now[-1][-1] += data.strip("\n")


def table(path: Path, id_: str) -> list[dict[str, str]]:
    head, *rows = Tables(path.read_text(encoding="utf-8")).tables[id_]
    return [dict(zip(head, row, strict=True)) for row in rows]


@pytest.fixture(scope="module")
def records(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    """Real records of a short run."""
    store = Records(tmp_path_factory.mktemp("run") / "oscillator-quick.sqlite")
    return scenes.run(scenes.load_scene("oscillator", quick=True), store)


def stored(folder: Path, name: str, records: list[dict[str, Any]]) -> Path:
    folder.mkdir(exist_ok=True)
    # what a test changed is not damage, and no second record of the same task
    told = [{**x, "key": f"{n:016x}"} for n, x in enumerate(records)]
    lines = "".join(json.dumps({k: x[k] for k in x if k != "sha256"}) + "\n" for x in told)
    (folder / f"{name}.jsonl").write_text(lines, encoding="utf-8")
    return folder


def with_findings(folder: Path, findings: list[dict[str, Any]], name: str = "found") -> None:
    folder.mkdir(exist_ok=True)
    document = {"format": "glmref-findings-1", "findings": findings}
    (folder / f"{name}.json").write_text(json.dumps(document), encoding="utf-8")


def pages(folder: Path, source: Path, **options: Any) -> Path:
    build(read([source], METHODS), folder, methods=METHODS, **options)
    return folder


@pytest.mark.slow
def test_every_number_of_a_run_is_that_of_its_record(tmp_path: Path, records) -> None:
    site = pages(tmp_path / "site", stored(tmp_path / "in", "oscillator-quick", records))
    rows = table(site / "run-oscillator-quick.html", "t-oscillator-quick")
    assert len(rows) == len(records) >= 10
    getters = {column.key: get for column, get in COLUMNS}
    compared = 0
    for row, record in zip(rows, records, strict=True):
        for key, text in row.items():
            value = getters[key](record)
            if isinstance(value, float):
                # six digits are shown: half a unit of the sixth is 5e-6 of the leading one
                assert float(text) == pytest.approx(value, rel=5e-6, abs=0)
                compared += 1
            else:
                assert text == number(value)
    assert compared >= 4 * len(records)


def test_a_long_measurement_is_folded_in_parts(tmp_path: Path) -> None:
    runs = [{"method": "rk4", "curve": [[100, 1e-3], [200, 1e-5]]}]
    for count in (3, 4):
        cases = [{"case": f"case {n}", "methods": runs} for n in range(count)]
        document = {"format": "glmref-measurement-1", "title": "many", "cases": cases}
        (tmp_path / "needs.json").write_text(json.dumps(document), encoding="utf-8")
        site = pages(tmp_path / "site", tmp_path)
        page = (site / "measured-needs.html").read_text(encoding="utf-8")
        assert page.count("<figure") == count
        assert page.count('<details class="part"') == (4 if count == 4 else 0)
        assert page.count("case 2</h2>") == 1
        assert 'data-looks="{&#34;rk4' in page


@pytest.mark.slow
def test_a_quick_run_says_how_far_its_records_go(tmp_path: Path, records) -> None:
    changed = [{**x, "task": {**x["task"], "t_end": 12.5}} for x in records]
    site = pages(tmp_path / "site", stored(tmp_path / "in", "oscillator-quick", changed))
    page = (site / "run-oscillator-quick.html").read_text(encoding="utf-8")
    assert "than the scene asks for, here to t = 12.5." in page
    captions = re.findall("<figcaption>(.*?)</figcaption>", page)
    assert len(captions) == 2 and all(x.endswith("Runs go to t = 12.5.") for x in captions)


@pytest.mark.slow
def test_pages_of_a_report_share_their_looks(tmp_path: Path, records) -> None:
    folder = stored(tmp_path / "in", "oscillator-quick", records)
    turned = sorted(records, key=lambda x: x["task"]["method"], reverse=True)
    site = pages(tmp_path / "site", stored(folder, "turned", turned[:9]))
    one, other = (
        json.loads(unescape(found[1]))
        for name in ("oscillator-quick", "turned")
        if (found := re.search('data-looks="(.*?)"', (site / f"run-{name}.html").read_text()))
    )
    assert len(other) > 1 and {name: one[name] for name in other} == other


@pytest.mark.slow
def test_curves_over_time_are_those_of_the_records(tmp_path: Path, records) -> None:
    series = [[0.1, 1.23456789e-9], [1.0, 2.5e-9]]
    changed = [{**records[0], "series": series}]
    site = pages(tmp_path / "site", stored(tmp_path / "in", "mine", changed))
    rows = table(site / "run-mine.html", "c-mine")
    assert [(float(x["t"]), float(x["value"])) for x in rows] == [(0.1, 1.23457e-9), (1.0, 2.5e-9)]


def orbit(name: str, paths: list[Any], ended: str | None = None) -> dict[str, Any]:
    task = {"kind": "method", "method": name, "h": 0.1}
    block = {"axes": ["q_1", "q_2"], "paths": paths, "ended": ended}
    return {
        "format": "glmref-record-1", "key": "0" * 16, "task": task, "outcome": "completed",
        "where": {}, "orbit": block,
    }  # fmt: skip


def drawn_orbits(records: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Of each method the record of the largest step whose orbit is whole."""
    found: dict[str, dict[str, Any]] = {}
    for record in sorted(records, key=lambda one: -one["task"]["h"]):
        if record["orbit"]["ended"] is None:
            found.setdefault(record["task"]["method"], record)
    order = dict.fromkeys(record["task"]["method"] for record in records)
    assert set(order) == set(found)
    return [found[name] for name in order]


@pytest.mark.slow
def test_points_of_an_orbit_are_those_of_the_records(tmp_path: Path, records) -> None:
    site = pages(tmp_path / "site", stored(tmp_path / "in", "oscillator-quick", records))
    rows = table(site / "run-oscillator-quick.html", "o-oscillator-quick")
    kept = [
        (record["task"]["method"], record["task"]["h"], *point)
        for record in drawn_orbits(records)
        for path in record["orbit"]["paths"]
        for point in path
    ]
    assert len(rows) == len(kept) >= 10 * 100
    for row, (name, h, *point) in zip(rows, kept, strict=True):
        assert row["method"] == name and row["h"] == number(h)
        assert [float(row[k]) for k in "txy"] == pytest.approx(point, rel=5e-6, abs=0)


def test_bodies_have_a_number_and_an_orbit_that_ends_early_says_so(tmp_path: Path) -> None:
    near = [[0.0, 1.0, 2.0], [1.0, 2.0, 1.0]]
    stored_records = [
        orbit("two", [near, [[0.0, 3.0, 4.0]]]),
        orbit("early", [near], "lost after t = 1"),
        orbit("away", [[*near, [2.0, 1e9, 0.0]]]),
        orbit("torn", [[*near, [2.0, None, 1.0], [3.0, 1.0, 1.0]]]),
        orbit("third", [near]),
    ]
    site = pages(tmp_path / "site", stored(tmp_path / "in", "mine", stored_records))
    rows = table(site / "run-mine.html", "o-mine")
    assert [(x["method"], x["body"], x["x"]) for x in rows[:3]] == [
        ("two", "1", "1"), ("two", "1", "2"), ("two", "2", "3"),
    ]  # fmt: skip
    assert sum(x["method"] == "torn" for x in rows) == 2
    text = (site / "run-mine.html").read_text(encoding="utf-8")
    (given,) = re.findall(r'data-plane="([^"]*)"', text)
    assert json.loads(unescape(given)) == ["early", "away", "torn"]
    for said in ("early</strong>: lost after t = 1", "torn</strong>: a stored point is not three"):
        assert said in text
    assert "away</strong>:" not in text


@pytest.mark.parametrize(
    "change",
    [
        {"axes": ["q"]}, {"axes": 7}, {"axes": [1, 2]}, {"paths": []}, {"paths": 7},
        {"paths": [7]}, {"ended": 7},
    ],
)  # fmt: skip
def test_an_orbit_of_another_shape_breaks_nothing(tmp_path: Path, change: dict[str, Any]) -> None:
    good, odd = (orbit(name, [[[0.0, 1.0, 2.0]]]) for name in ("good", "odd"))
    odd["orbit"] |= change
    site = pages(tmp_path / "site", stored(tmp_path / "in", "mine", [good, odd]))
    rows = table(site / "run-mine.html", "o-mine")
    assert [x["method"] for x in rows] == (["good", "odd"] if "ended" in change else ["good"])


@pytest.mark.slow
def test_a_page_has_room_for_so_many_points_and_says_what_is_left_out(tmp_path: Path) -> None:
    path = [[float(k), 1.0, 2.0] for k in range(400)]
    many = [orbit(f"m{k}", [path]) for k in range(16)]
    site = pages(tmp_path / "site", stored(tmp_path / "in", "mine", many))
    assert len(table(site / "run-mine.html", "o-mine")) == 14 * 400 <= MOST - 16
    text = (site / "run-mine.html").read_text(encoding="utf-8")
    assert "In the records and not drawn: orbits of 2 methods." in text and len(text) < 1_000_000


def test_nan_an_unfinished_run_and_an_unknown_version_are_shown_as_such(tmp_path, records):
    odd = [
        {**records[0], "state_error": float("nan"), "energy_error": float("inf")},
        {**records[1], "outcome": "not finite", "message": "the values left the numbers at t = 3"},
        {"format": "glmref-record-1", "task": {"kind": "method", "method": "mine"}},
        {**records[2], "format": "glmref-record-99"},
        {**records[3], "seconds": "soon", "drifts": 7, "series": [1, [2]], "where": None},
        {**records[1], "outcome": "lost", "message": "lost at t = 13.8: parasitic"},
    ]
    site = pages(tmp_path / "site", stored(tmp_path / "in", "oscillator", odd))
    text = (site / "run-oscillator.html").read_text(encoding="utf-8")
    rows = table(site / "run-oscillator.html", "t-oscillator")
    assert rows[0]["state_error"] == "NaN" and rows[0]["energy_error"] == "infinite"
    assert rows[1]["outcome"] == "not finite"
    assert ": not finite: the values left the numbers at t = 3<" in text
    assert ": lost at t = 13.8: parasitic<" in text and "lost: lost" not in text
    assert rows[2]["method"] == "mine" and rows[2]["state_error"] == "–"
    assert len(rows) == 5 and "no answer" in text
    assert "glmref-record-99" in (site / "measured.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_policy_allows_our_own_style_and_script_and_nothing_else(tmp_path, records):
    site = pages(tmp_path / "site", stored(tmp_path / "in", "oscillator-quick", records))
    for path in site.glob("*.html"):
        text = path.read_text(encoding="utf-8")
        (policy,) = re.findall(r'Content-Security-Policy" content="([^"]+)"', text)
        assert policy.startswith("default-src 'none'; style-src 'sha256-")
        assert "unsafe" not in policy and "http" not in policy
        assert not re.search(r"\sstyle=|\son\w+=|<iframe|<img|@import|url\(", text)
        # links to the outside are for the reader to follow; nothing is loaded
        assert not re.search(r'src="|<link (?!rel="icon" href="data:,")', text)


@pytest.mark.slow
def test_a_page_of_5000_records_stays_under_a_megabyte(tmp_path: Path, records) -> None:
    many = [
        {
            **records[n % len(records)],
            "task": {**records[n % len(records)]["task"], "h": 1 / (n + 1)},
        }
        for n in range(5000)
    ]
    site = pages(tmp_path / "site", stored(tmp_path / "in", "many", many))
    assert (site / "run-many.html").stat().st_size < 1_000_000
    assert len(table(site / "run-many.html", "t-many")) == 5000


def test_the_overview_and_a_method_page_say_what_the_data_and_the_findings_say(tmp_path):
    source = tmp_path / "in"
    findings = [
        {"method": "rk4", "claim": "order", "declared": 4, "verdict": "holds", "value": 4,
         "proof": "exact", "residual": 0.0, "witness": "tree [oooo] of order 5 has residual 0.00833333"},
        {"method": "rk4", "claim": "order4/rk4/pendulum", "verdict": "holds", "value": 4,
         "proof": "measured"},
    ]  # fmt: skip
    with_findings(source, findings)
    (source / "rk4.svg").write_text(
        '<?xml version="1.0"?><svg xmlns="http://www.w3.org/2000/svg" id="drawn"></svg>',
        encoding="utf-8",
    )
    site = pages(tmp_path / "site", source)
    rows = {row["method"]: row for row in table(site / "index.html", "methods")}
    assert set(rows) == set(METHODS)
    rk4 = rows["rk4"]
    assert (rk4["order"], rk4["measured"], rk4["proof"], rk4["stages"]) == ("4", "4", "exact", "4")
    assert (rk4["implicit"], rk4["conserves"], rk4["verified"]) == ("0", "no", "1 of 1")
    assert rows["gauss-2"]["implicit"] == "2" and rows["gsymplectic-n"]["values"] == "2"
    assert rows["pair-4-4"]["implicit"] == "0" and rows["pair-4-4"]["values"] == "2 + 2"
    page = (site / "method-rk4.html").read_text(encoding="utf-8")
    claims = {x["claim"]: x for x in table(site / "method-rk4.html", "claims-rk4")}
    assert claims["order"]["witness"].startswith("tree [oooo]")
    assert claims["symplectic"]["verdict"] == "–"
    assert "1 of 1 checks hold" in page and 'id="drawn"' in page and "@article{kutta" in page
    assert (site / "data" / "rk4.json").is_file()


def test_a_finding_about_another_value_than_the_file_claims_is_not_shown(tmp_path: Path) -> None:
    source = tmp_path / "in"
    findings = [
        {"method": "rk4", "claim": "order", "declared": 5, "verdict": "holds", "proof": "exact"},
        {"method": "rk4", "claim": "explicit", "declared": True, "verdict": "holds",
         "proof": "exact"},
    ]  # fmt: skip
    with_findings(source, findings)
    site = pages(tmp_path / "site", source)
    claims = {x["claim"]: x for x in table(site / "method-rk4.html", "claims-rk4")}
    assert claims["order"]["verdict"] == "–" and claims["explicit"]["verdict"] == "holds"
    rows = {row["method"]: row for row in table(site / "index.html", "methods")}
    assert rows["rk4"]["verified"] == "1 of 1"


@pytest.mark.slow
def test_without_an_argument_every_method_has_verdict_proof_order_and_region(tmp_path):
    results = read([data_root() / "measurements"])
    build(results, tmp_path / "site", methods=names("methods"))
    shipped = json.loads((data_root() / "measurements" / "stability.json").read_text("utf-8"))
    seen = json.loads((data_root() / "measurements" / "observed-orders.json").read_text("utf-8"))
    observed = {(x["method"], x["claim"]): x["observed"] for x in seen["orders"]}
    told = json.loads((data_root() / "measurements" / "error-constants.json").read_text("utf-8"))
    constants = {x["method"]: x for x in told["methods"]}
    rows = {row["method"]: row for row in table(tmp_path / "site" / "index.html", "methods")}
    assert set(rows) == set(names("methods")) and len(rows) >= 165
    for name, row in rows.items():
        whole, _, of = row["verified"].partition(" of ")
        assert whole == of and int(of) >= 1, name
        if document(name)["class"] in ("additive", "rosenbrock"):  # nothing is stored of sums
            continue
        seen_of = observed.get((name, "order"))
        assert (seen_of is not None) == ("order" in document(name)["claims"]), name
        assert row["proof"] != "–" and row["measured"] == (
            "–" if seen_of is None else number(seen_of)
        ), name
        page = (tmp_path / "site" / f"method-{name}.html").read_text(encoding="utf-8")
        claims = table(tmp_path / "site" / f"method-{name}.html", f"claims-{name}")
        # a claim that was added and is not stored yet is tests/suite/test_verification_stored.py's
        assert {x["claim"] for x in claims} >= set(document(name)["claims"])
        assert {x["verdict"] for x in claims} <= {"holds", "–"} and claims[0]["verdict"] == "holds"
        region = shipped["methods"][name]
        ends = [region.get(key) for key in ("imaginary", "real", "oscillation")]
        told = re.findall(r"<dd>(?:no end up to )?([\d.e-]+)(?=<dt>|</dl></figcaption>)", page)
        assert [float(x) for x in told] == [x for x in ends if x is not None], name
        assert page.count('class="chart region"') == 1, name
        if not constants[name]["largest"]:  # of order 14 and above no residual is stored
            continue
        largest = table(tmp_path / "site" / f"method-{name}.html", f"constants-{name}-0")
        assert [[x["tree"], x["residual"]] for x in largest] == [
            [tree, number(x)] for tree, x in constants[name]["largest"]
        ]
        assert f"over symmetry is {number(constants[name]['norm'])}.</p>" in page, name


def test_a_region_is_drawn_where_its_polygon_lies() -> None:
    square = "-2,-1 0,-1 0,1 -2,1 -2,-1"
    text = stability("x", {"reach": 4, "rings": [square], "imaginary": 1.5, "real": 2.0})
    (path,) = re.findall(r'class="area"[^>]*d="([^"]+)"', text)
    corners = [tuple(map(float, x.split(","))) for x in re.findall(r"[-\d.]+,[-\d.]+", path)]
    (left, low), (right, _), (_, high), *_ = corners
    # 8 units are 320 px: two are 80, and zero is in the middle of the frame
    assert right - left == pytest.approx(80) and low - high == pytest.approx(80)
    assert right == pytest.approx(46 + 160)
    assert "<dd>1.5" in text and "<dd>2" in text and "where it is shaded" in text


@pytest.mark.parametrize(
    "record",
    [
        None, {}, {"reach": 0}, {"reach": float("nan")}, {"reach": "3"},
        {"reach": 3, "rings": ["<script>", 7, "1,2"]}, {"reach": 3, "moduli": [None, "0,1 x"]},
        {"reach": 3, "rings": 7, "imaginary": "far", "real": None},
    ],
)  # fmt: skip
def test_a_region_of_another_shape_breaks_nothing(record: Any) -> None:
    text = stability("x", record)
    assert "<script" not in text and 'class="area"' not in text and 'class="line' not in text
    assert ("<svg" in text) == bool(record and record.get("reach") == 3)


def test_one_file_holds_everything(tmp_path: Path, records) -> None:
    source = stored(tmp_path / "in", "oscillator-quick", records)
    path = tmp_path / "all.html"
    assert build(read([source]), path, single=True, methods=METHODS) == [path]
    text = path.read_text(encoding="utf-8")
    sections = re.findall(r'<section id="([^"]+)"', text)
    assert sections[0] == "index" and {f"method-{x}" for x in METHODS} <= set(sections)
    inner = {x for x in re.findall(r'href="#([^"]+)"', text) if x != "main"}
    assert inner <= set(sections)


def test_every_link_between_pages_leads_to_a_file(tmp_path: Path, records) -> None:
    site = pages(tmp_path / "site", stored(tmp_path / "in", "oscillator-quick", records))
    for path in site.glob("*.html"):
        for link in re.findall(r'href="([^"#:]+)"', path.read_text(encoding="utf-8")):
            assert (site / link).is_file(), (path.name, link)


def test_a_folder_with_something_else_in_it_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("precious", encoding="utf-8")
    refused(UsageError, "no report", build, read([]), tmp_path, methods=("rk4",))
    assert (tmp_path / "mine.txt").read_text(encoding="utf-8") == "precious"
    refused(UsageError, "is a file", build, read([]), tmp_path / "mine.txt", methods=("rk4",))
    refused(UsageError, "is a folder", build, read([]), tmp_path, single=True, methods=("rk4",))
    build(read([]), tmp_path / "new", methods=("rk4",))
    build(read([]), tmp_path / "new", methods=("gauss-2",))
    assert not (tmp_path / "new" / "method-rk4.html").exists()


@pytest.mark.slow
def test_the_command_names_what_it_cannot_show_and_says_what_to_open(tmp_path, records, cli):
    source = stored(tmp_path / "in", "oscillator-quick", [*records, {"format": "x"}])
    out = tmp_path / "one.html"
    said = cli("report", source, "--single-file", "--output", out)
    assert f"{len(records)} records" in said.out and str(out) in said.out
    assert "oscillator-quick.jsonl, line" in said.err and "'x'" in said.err
    assert len(cli("report", tmp_path / "nothing", code=2).err.splitlines()) == 1


OWN = scene_text(
    "duffing", 'H = "p**2/2 - q**2/2 + q**4/4"\ny0 = { q = "3/2", p = 0 }', 'kind = "accurate"\nat = 1e-4',
    title="A Duffing <oscillator>", question="Which method has the state right to 1e-4 first?",
    methods=["stormer-verlet", "rk4"], steps=[10, 32, 100], t_end=2, ask=["state", "orbit"],
)  # fmt: skip


@pytest.fixture
def with_own_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, with a scene of the user."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "duffing.toml").write_text(OWN, encoding="utf-8")
    return tmp_path


@pytest.mark.slow
def test_an_own_scene_has_its_page_and_nothing_of_the_catalogue(with_own_scene: Path, cli) -> None:
    answer = json.loads(cli("run", "duffing.toml", "--format", "json").out)["answer"]
    assert main(["report"]) == 0
    site = with_own_scene / "report" / "pages"
    written = {path.name for path in site.rglob("*") if path.is_file()}
    assert written == {"index.html", "run-duffing.html", "measured.html", "glmref-report.txt"}
    page, index = (
        (site / name).read_text(encoding="utf-8") for name in ("run-duffing.html", "index.html")
    )
    assert "<h1>A Duffing &lt;oscillator&gt;</h1>" in page
    question = "<p><strong>Which method has the state right to 1e-4 first?</strong></p>"
    assert question in page and f'<p class="answer">{answer}</p>' in unescape(page)
    assert page.count("<figure") == 2  # error against cost, and the orbit
    assert page.index(question) < page.index("<figure")
    assert "A Duffing &lt;oscillator&gt;</a>" in index and answer in unescape(index)
    for text in ("What is proved here", "All methods", "observed-orders", "Errata"):
        assert text not in index and text not in page
    assert main(["report", "duffing.toml", "--output", "again"]) == 0  # its records, by its file
    assert (with_own_scene / "again" / "run-duffing.html").read_text(encoding="utf-8") == page
    assert main(["report", "--all", "--output", "whole"]) == 0
    assert (with_own_scene / "whole" / "method-rk4.html").is_file()


def test_without_results_the_report_says_what_to_run(with_own_scene: Path, cli) -> None:
    for given, words in (
        ([], "no results in report; write some with `glmref run SCENE`"),
        (["."], "no results in .; write some with"),
        (["duffing.toml"], "no results of duffing.toml in report; run `glmref run duffing.toml`"),
    ):
        said = cli("report", *given, code=2)
        assert words in said.err and said.err.count("\n") == 1 and not said.out
    assert not (with_own_scene / "report").exists()


def test_claims_and_audited_tables_are_found_by_their_words(tmp_path: Path) -> None:
    build(read([data_root() / "measurements" / "verification.json"]), tmp_path, methods=METHODS)
    rows = table(tmp_path / "search.html", "found")
    claims = [(x["name"], x["says"]) for x in rows if x["what"] == "claim"]
    declared = {name: document(name)["claims"] for name in METHODS}
    assert len(claims) >= sum(map(len, declared.values()))
    assert {name for name, _ in claims} == set(METHODS) and ("rk4", "order: 4") in claims
    assert all(x["verdict"] == "holds" for x in rows if x["what"] == "claim")
    audited = {x["name"]: x for x in rows if x["what"] == "audited table"}
    bad = audited["petsc, TSARKIMEXBPR3"]
    assert (bad["verdict"], bad["says"]) == (
        "wrong",
        "order 3, found 1; a[5][3] is 3/5, should be 3/4",
    )
    assert {x["verdict"] for x in audited.values()} == set(STATUSES)
    page = (tmp_path / "method-rk4.html").read_text(encoding="utf-8")
    assert 'data-to="search.html"' in page


def test_audited_codes_are_counted_and_what_is_wrong_is_named(tmp_path: Path) -> None:
    build(read([]), tmp_path, methods=["rk4"])
    codes = {x["code"]: x for x in table(tmp_path / "audits.html", "codes")}
    records = audited_codes()
    assert codes.keys() == records.keys()
    for code, row in codes.items():
        assert int(row["tables"]) == len(records[code]["tables"])
        assert [int(row[x]) for x in STATUSES] == [
            records[code]["counts"].get(x, 0) for x in STATUSES
        ]
    odd = table(tmp_path / "audits.html", "odd")
    assert {x["status"] for x in odd} == {"wrong", "question", "digits"}
    feagin = next(x for x in odd if x["table"] == "Feagin12")
    assert (feagin["code"], feagin["found"]) == ("ordinarydiffeq.jl", "1")
    assert "c[2] is 2, should be 1/5" in feagin["what is wrong"]
    text = (tmp_path / "audits.html").read_text(encoding="utf-8")
    wrong = sum(x["status"] == "wrong" for x in odd)
    assert f"{wrong} wrong and" in text and "/blob/" in text


@pytest.mark.slow
def test_a_changed_copy_of_a_shipped_scene_has_its_own_words(tmp_path: Path, records) -> None:
    once = [{**x, "seconds": {**x["seconds"], "repeats": 1}} for x in records]
    folder = stored(tmp_path / "a", "oscillator-quick", once)
    said = {"title": "A copy", "question": "Which?", "answer": "None by t = 7", "judged": "state"}
    run = {"format": "glmref-run-1", "scene": "oscillator", **said}
    (folder / "oscillator-quick.run.json").write_text(json.dumps(run), encoding="utf-8")
    page = pages(tmp_path / "site", folder) / "run-oscillator-quick.html"
    text = page.read_text(encoding="utf-8")
    assert "<h1>A copy</h1>" in text and '<p class="answer">None by t = 7</p>' in text
    # of runs that were timed once the quartiles are the median: two columns less
    assert not {"q25", "q75"} & set(table(page, "t-oscillator-quick")[0])


@pytest.mark.slow
def test_bars_of_many_runs_are_left_out_and_the_caption_says_so(tmp_path: Path, records) -> None:
    many = [{**records[n % len(records)], "evaluations": 1000 + n} for n in range(MOST_BARS + 1)]
    few = pages(tmp_path / "few", stored(tmp_path / "a", "oscillator-quick", records))
    lots = pages(tmp_path / "many", stored(tmp_path / "b", "oscillator-quick", many))
    for site, drawn in ((few, True), (lots, False)):
        text = (site / "run-oscillator-quick.html").read_text(encoding="utf-8")
        assert ("data-bars=no" in text) != drawn and ("Bars span the quartiles" in text) == drawn


# --- methods of the user ----------------------------------------------------------------------------

MINE = {
    "format": "glmref-method-1", "name": "my-heun", "class": "rk",
    "A": [["0", "0"], ["1", "0"]], "b": ["1/2", "1/2"], "claims": {"order": 2},
    "source": {"citation": "my <b>notebook</b>", "where": "page 1", "status": "derived"},
}  # fmt: skip


def test_an_own_method_gets_a_page_with_its_tableau_findings_and_portrait(tmp_path: Path) -> None:
    from glmref.report import build, read
    from glmref.views.tables import findings_json

    folder = tmp_path / "results"
    folder.mkdir()
    (folder / "my-heun.svg").write_text(glmref.plot("heun-2"), encoding="utf-8")  # read first
    file = folder / "x-mine.json"
    file.write_text(json.dumps(MINE), encoding="utf-8")
    (folder / "found.json").write_text(findings_json(glmref.verify(file)), encoding="utf-8")
    alien = [{"method": "alien", "claim": "order5/alien/kepler", "verdict": "holds", "declared": 5}]
    with_findings(folder, alien, "more")
    (folder / "rk4.json").write_text(json.dumps({**MINE, "name": "rk4"}), encoding="utf-8")
    found = read([folder], ["rk4"])
    assert found.of_others() == ["alien", "my-heun"]
    assert [where for where, _ in found.odd] == ["rk4.json"]
    build(found, tmp_path / "pages", methods=["rk4"])
    page = (tmp_path / "pages" / "method-my-heun.html").read_text(encoding="utf-8")
    assert "<mfrac>" in page and 'class="holds">holds' in page and "stability region" in page
    assert "my &lt;b&gt;notebook" in page
    other = (tmp_path / "pages" / "method-alien.html").read_text(encoding="utf-8")
    assert "known by its findings" in other and "1 of 1 checks hold" in other
    index = (tmp_path / "pages" / "index.html").read_text(encoding="utf-8")
    assert "Your own:" in index and "method-my-heun.html" in index
    again = glmref.load(tmp_path / "pages" / "data" / "my-heun.json")
    assert again.name == "my-heun"


@pytest.mark.slow
def test_the_first_page_answers_which_method_and_what_is_proved() -> None:
    from glmref.catalogue.advice import ADVICE
    from glmref.catalogue.lookup import data_root
    from glmref.report import read
    from glmref.report.markup import Site
    from glmref.report.methods import overview

    names = glmref.names()
    assert all(set(one.take) <= set(names) for one in ADVICE)
    found = read([data_root() / "measurements" / "verification.json"])
    body = str(overview(Site(), found, names, catalogue=True).body)
    assert all(f"<td>{one.why}" in unescape(body) for one in ADVICE)
    assert "pair-rkn-6-8b</a> (up to 100,000 steps)" in body
    assert "Which method for which need" in body and "What is proved here" in body
    claims = sum(len(rows) for name, rows in found.findings.items() if name in names)
    assert f"{len(names)} methods make {claims} claims" in body
    assert body.index("Which method") < body.index("What is proved") < body.index("All methods")
    assert "<code>docs/choose.md</code>" in body
    linked = str(overview(Site(docs=".."), found, names, catalogue=True).body)
    assert '<a href="../choose.html">' in linked and "docs/choose.md" not in linked


def test_the_overview_shows_orders_of_nystrom_methods(tmp_path: Path) -> None:
    build(read([]), tmp_path / "site", methods=("dormand-prince-rkn-8-6", "blanes-moan-rkn-6-11"))
    rows = {row["method"]: row["order"] for row in table(tmp_path / "site/index.html", "methods")}
    assert rows == {"dormand-prince-rkn-8-6": "8", "blanes-moan-rkn-6-11": "4"}
