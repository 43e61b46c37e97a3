"""What is stored of the engine's speed: complete, and what the page says of it."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
RECORD = ROOT / "data" / "measurements" / "engine.json"
PAGE = ROOT / "docs" / "engine.md"


@pytest.fixture(scope="module")
def rows():
    return json.loads(RECORD.read_text(encoding="utf-8"))["rows"]


def against_c(rows):
    return [row for row in rows if row["comparison"] in ("c", "sweep")]


def test_the_sentences_about_others_are_those_of_the_data(rows):
    times = {(x["name"], x["goal"]): x["milliseconds"] for x in rows if "goal" in x}
    ratio = [times["g6245", 1e-12][1] / times[x, 1e-12][1] for x in ("heyoka", "gauss-4")]
    assert [round(x) for x in ratio] == [11, 7]  # eleven times heyoka, seven times Gauss
    assert all(times[x, y][1] < times["heyoka", y][1] for x in ("gauss-6", "gauss-8")
               for y in (1e-9, 1e-12))  # fmt: skip
    gains = [x["gain"] for x in rows if x["comparison"] == "lanes"]
    assert f"{min(gains):.1f} to {max(gains):.1f} times" in " ".join(
        PAGE.read_text("utf-8").split()
    )


def test_c_and_engine_did_the_same_arithmetic(rows):
    assert len(against_c(rows)) == 12 + 20
    assert all(row["same_bits"] for row in against_c(rows))
    # the same number of evaluations is part of it: seven of Yoshida's, eight of the pair's
    assert {x["evaluations"] for x in against_c(rows) if x["method"] == "yoshida-verlet-6"} == {7.0}
    assert {x["evaluations"] for x in against_c(rows) if x["method"] == "pair-6-8"} == {8.0}


def test_explicit_kernels_are_at_least_as_fast_as_c_by_95_percent(rows):
    swept = [row for row in rows if row["comparison"] == "sweep"]
    assert {row["method"] for row in swept} > {"pair-4-6", "pair-6-8", "pair-rkn-6-8b"}
    assert {row["level"] for row in swept} <= {"-O2", "-O3"}
    assert min(row["c_over_engine"][1] for row in swept) >= 0.95
    assert min(row["contracted_over_fused"][1] for row in swept) >= 0.95


def test_the_sentences_about_c_are_those_of_the_data(rows):
    page = " ".join(PAGE.read_text(encoding="utf-8").split())
    least = min(row["c_over_engine"][1] for row in against_c(rows))
    fused = min(row["contracted_over_fused"][1] for row in against_c(rows))
    times = [{key: x[1] for key, x in row["nanoseconds"].items()} for row in against_c(rows)]
    gain = max(1 - time["fused"] / time["engine"] for time in times)
    assert f"no ratio is below {least:.2f}," in page
    assert f"no ratio is below {fused:.2f} either" in page
    assert f"Fused operations take up to {100 * gain:.0f} % less time" in page
    assert f"no ratio is below {least + 0.01:.2f}," not in page


def test_the_record_says_where_and_how_it_was_measured():
    record = json.loads(RECORD.read_text(encoding="utf-8"))
    assert record["format"] == "glmref-measurement-1"
    assert {"processor", "cores", "versions", "compiler", "flags"} <= record["where"].keys()
    assert {"python", "numpy", "llvmlite", "heyoka", "scipy"} <= record["where"]["versions"].keys()
    assert "-O3 -march=native" in record["where"]["flags"]


@pytest.mark.slow
@pytest.mark.compiler
@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
def test_the_loop_in_c_has_the_bits_of_the_kernel(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT))
    from tools.measure import compare_c

    case = compare_c.Case("pair-6-8", "kepler", tmp_path)
    ours, theirs = case.engine(case.kernel, 1000), case.c(1000)
    np.testing.assert_array_equal(ours[0], theirs[0])
    assert ours[1] == theirs[1] == 8000
    # the near miss: the first coupling, one unit in the last place larger
    folder = tmp_path / "other"
    folder.mkdir()
    text = compare_c.sweep_table(case.kernel.form)
    coupling = case.kernel.form.components[1].U[0][1]
    changed = text.replace(coupling.hex(), np.nextafter(coupling, np.inf).hex(), 1)
    assert changed != text
    (folder / "table.h").write_text(changed, encoding="utf-8")
    other = case.c(1000, compare_c.built("sweep", "KEPLER", folder))
    assert not np.array_equal(other[0], theirs[0])
    with pytest.raises(ValueError, match=r"written for V = 1 or diag\(1, -1\)"):
        compare_c.sweep_table(compare_c.Case("stormer-verlet", "kepler", tmp_path).kernel.form)
