"""Measurements, benchmarks and errata on the pages: what is stored, and pictures where they fit."""

from __future__ import annotations

from typing import Any

import pytest

from glmref.report.asv_results import Cell
from glmref.report.measurements import measurement_pages
from glmref.report.side_pages import history_page
from glmref.report.store import Results


def measured(**doc: Any) -> str:
    (page,) = measurement_pages(
        Results(measurements={"it": {"format": "glmref-measurement-1", **doc}})
    )
    return page.body


ROWS = [
    {"name": "a", "problem": "one", "error": 1.25e-3, "evaluations": 100, "outcome": "completed"},
    {"name": "b", "problem": "one", "error": float("nan"), "evaluations": 200, "outcome": "lost"},
    {"name": "a", "problem": "two", "error": None, "evaluations": 300, "outcome": "completed"},
]


def test_errors_against_costs_are_drawn_one_picture_a_problem() -> None:
    body = measured(rows=ROWS)
    assert body.count("<figure") == 1 and 'data-table="m-it-rows-0"' in body
    assert 'data-x="evaluations" data-y="error"' in body and 'data-series="name"' in body
    assert body.count("<h3>") == 2 and "0.00125" in body and "NaN" in body
    # nothing to draw without an error
    assert "<figure" not in measured(rows=[{"name": "a", "evaluations": 1}])


def test_lists_of_equal_length_are_a_curve_with_its_numbers_beside_it() -> None:
    rows = [
        {"variant": "plain", "method": "rk4", "steps": [10, 20], "rms": [1e-16, 2e-16]},
        {"variant": "sums", "method": "rk4", "steps": [10, 20], "rms": [3e-16, 4e-16]},
    ]
    body = measured(rows=rows)
    assert 'data-table="m-it-rows-0-curves" data-series="line" data-x="steps" data-y="rms"' in body
    for cells in ("plain, rk4<td>10<td>1e-16", "sums, rk4<td>20<td>4e-16"):
        assert f"<tr><td>{cells}" in body
    rows[1]["rms"] = [3e-16]
    assert "-curves" not in measured(rows=rows)


def test_an_object_with_a_list_inside_is_opened_and_other_values_are_written_out() -> None:
    body = measured(h=[0.2, 0.1], losses={"problem": {"q0": "23/10"}, "runs": [{"lost": 7.25}]})
    assert "<dt>h<dd>0.2, 0.1" in body and "<dd>q0: 23/10" in body
    assert "<h2>losses</h2>" in body and "<tr><td>7.25" in body


def test_cases_are_opened_and_their_runs_are_rows_under_the_method_they_belong_to() -> None:
    runs = [
        {"steps": 10, "error": 1e-3, "seconds": 0.5},
        {"steps": 20, "error": 2e-5, "seconds": 1.5},
    ]
    tracks = [{"method": "g6245", "solver": "newton", "runs": runs, "at": {"1e-06": 3}}]
    body = measured(cases=[{"case": "kepler-0.6", "t_end": 6.5, "tracks": tracks}])
    assert "<h2>kepler-0.6</h2>" in body and "<dt>t_end<dd>6.5" in body
    assert "<tr><td>g6245, newton<td>g6245<td>newton<td>10<td>0.001<td>0.5" in body
    assert 'data-x="seconds steps" data-y="error"' in body
    assert "<td>1e-06: 3" in body  # what belongs to the track and to none of its runs


def cell(commit: str, date: str, values: dict[str, float | None]) -> Cell:
    return Cell(
        "bench.Kepler", {"method": "rk4", "steps": "100"}, values, {}, commit, date, "m", "3.11"
    )


def test_benchmarks_are_a_history_and_error_beside_time() -> None:
    cells = [
        cell("a" * 40, "2026-01-01T00:00:00", {"time_run": 0.0125, "track_error": 1e-6}),
        cell("b" * 40, "2026-02-01T00:00:00", {"time_run": 0.00625, "track_error": None}),
    ]
    body = history_page(Results(benchmarks=cells)).body
    assert body.count("<figure") == 2 and 'data-x="time_run" data-y="track_error"' in body
    assert "<tr><td>rk4, 100<td>1<td>aaaaaaaa<td>2026-01-01<td>0.0125<td>1e-06" in body
    assert "<td>2<td>bbbbbbbb<td>2026-02-01<td>0.00625<td>–" in body
    assert "No result of asv" in history_page(Results()).body


@pytest.mark.parametrize("value", [[], {}, [1, {}], {"a": []}, "text", None, 3, [[1, 2], [3]]])
def test_a_value_of_any_shape_breaks_nothing(value: Any) -> None:
    assert "<dt>odd" in measured(odd=value) or value == {}
