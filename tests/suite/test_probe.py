"""The probe reads coefficients out of running integrators, or says what it could not see."""

import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.cli import main
from glmref.cli.conforming import _page
from glmref.conformance.adapters.reference import Adapter as Reference
from glmref.conformance.identify import _arrays, as_method, identify, matches, recognised
from glmref.conformance.probe import read
from glmref.conformance.readings import Reading, Watch
from glmref.conformance.subject import Subject
from glmref.errors import UsageError
from glmref.exact import Exact
from glmref.method import PartitionedGLM
from glmref.views.tables import Style
from tests.build import floats, refused


class Opaque:
    """A method of ours that says nothing but how many values it carries."""

    def __init__(self, method: str, values: int = 1) -> None:
        self.inner, self.hidden = Reference((method,)), method
        self.methods = {"black-box": {"order": 1, "values": values}}

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        return self.inner.step(self.hidden, problem, t, y, h)


@pytest.mark.sampled(1, besides=("gauss", "gsym", "g6245", "verner", "lobatto"))
@pytest.mark.parametrize(
    ("name", "values"),
    [("rk4", 1), ("gauss-2", 1), ("gsymplectic-n", 2), ("g6245-w3", 4), ("g6245", 4), ("bdf-3", 3),
     ("gauss-4", 1), ("cooper-verner-8", 1), ("stormer-verlet", 1), ("lobatto-iiia-iiib-3", 1)],
)  # fmt: skip
def test_coefficients_come_out_of_a_black_box_to_1e_10_and_the_method_by_name(name, values):
    (probe,) = identify(Subject(Opaque(name, values)))
    assert probe.reading is not None and probe.notes == ()
    known = load(name)
    assert len(probe.reading.blocks) == (8 if isinstance(known, PartitionedGLM) else 4)
    for letter, found in probe.reading.blocks.items():
        right = floats(getattr(known, letter))
        assert found.shape == right.shape and np.abs(found - right).max() < 1e-10, letter
    assert name in [match.name for match in probe.matches]
    assert probe.analysis.order == known.claims["order"]


def spoiled(change: str) -> type[Opaque]:
    """Return an opaque integrator whose engine is changed."""

    class Spoiled(Opaque):
        def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
            exec(change, {"engine": self.inner._engine(self.hidden, problem)})
            return super().step(method, problem, t, y, h)

    return Spoiled


def test_a_changed_coefficient_is_no_method_of_the_catalogue() -> None:
    (probe,) = identify(Subject(spoiled("engine.A[1, 0] = 0.6")("gsymplectic-n", 2)))
    assert probe.matches == () and probe.analysis.order < 4
    assert probe.reading is not None and probe.reading.blocks["A"][1, 0] == 0.6


def test_another_basis_and_order_of_stages_are_still_the_same_method() -> None:
    method = load("gsymplectic-n").transform([["1", "1/2"], ["0", "2"]]).permute_stages([1, 0])

    class Moved:
        methods = {"black-box": {"order": 4, "values": 2}}  # noqa: RUF012

        def step(self, _: str, problem: Any, t: float, y: Any, h: float) -> Any:
            from glmref.engine.reference import stepper

            return stepper(method, problem).step(t, y, h).values

    (probe,) = identify(Subject(Moved()))
    assert "gsymplectic-n" in [x.name for x in probe.matches]
    assert not any(x.same_basis for x in probe.matches)


def test_a_pair_is_the_same_in_another_order_of_its_stages() -> None:
    name = "lobatto-iiia-iiib-3"
    (A, U, B, V), (A_hat, U_hat, B_hat, V_hat) = _arrays(name)
    q, p = [2, 0, 1], [1, 2, 0]
    half = (A[np.ix_(q, p)], U[q], B[:, p], V)
    hat = (A_hat[np.ix_(p, q)], U_hat[p], B_hat[:, q], V_hat)
    reading = Reading((half, hat), None, 6, 6, 0.0)
    assert [match.name for match in matches(reading)] == [name]


def test_a_stage_is_read_from_iterates_that_have_settled() -> None:
    """The first call at a point may be of an iterate that is near, but has not settled."""
    first, settled = np.array([1.0, 0.5]), np.array([1.0, 0.5 + 1e-9])
    watch = Watch()
    watch.see(0.0, first, first)
    again = watch.again()
    for value, marker in enumerate((first, settled, settled)):
        again.see(0.0, np.array([float(value)]), marker)
    assert again.arguments == [np.array([2.0])] and again.unexpected == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lobatto-iiia-iiib-5", "lobatto-iiic-iiic-star-5"])
def test_pairs_of_high_stage_order_are_read(name: str) -> None:
    reading = read(Subject(Opaque(name)), "black-box", 1)
    assert reading.blocks["A"].shape == (5, 5) and reading.unexplained < 1e-14
    assert [match.name for match in matches(reading)] == [name]


def test_stages_at_equal_times_are_told_apart() -> None:
    reading = read(Subject(Opaque("rk4")), "black-box", 1)
    assert reading.c is not None and reading.c.tolist() == [0, 0.5, 0.5, 1]
    assert reading.blocks["A"].tolist() == [[0] * 4, [0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 1, 0]]


def test_a_stage_that_nothing_depends_on_is_not_seen() -> None:
    reading = read(Subject(Opaque("dormand-prince-5")), "black-box", 1)
    assert len(reading.blocks["A"]) == 6 and reading.points == 7
    (probe,) = identify(Subject(Opaque("dormand-prince-rkn-4-3")))  # the same of a pair
    assert [match.name for match in probe.matches] == ["dormand-prince-rkn-4-3"]


def test_an_exponential_integrator_is_said_to_do_something_more() -> None:
    class Exponential:
        """Lawson-Euler: exact for the linear part at the value it starts from."""

        methods = {"black-box": {"order": 1}}  # noqa: RUF012

        def step(self, _: str, problem: Any, t: float, y: Any, h: float) -> Any:
            jacobian = problem.jacobian(t, y)
            flow, term = np.eye(len(y)), np.eye(len(y))
            for k in range(1, 30):
                term = term @ jacobian * h / k
                flow = flow + term
            return flow @ (y + h * (problem.f(t, y) - jacobian @ y))

    (probe,) = identify(Subject(Exponential()))
    assert any("something more" in note for note in probe.notes)


def test_times_that_are_not_c_are_said() -> None:
    (probe,) = identify(Subject(spoiled("engine.c = 0 * engine.c")("rk4")))
    assert any("times other than" in note for note in probe.notes)


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("name", "values", "factor"), [("rk4", 1, 0.0), ("gauss-2", 1, 0.5), ("gsymplectic-n", 2, 0.0)]
)
def test_a_method_with_wrong_stage_times_is_headed_as_what_it_is(name, values, factor, capsys):
    class Shifted(Opaque):
        def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
            engine = self.inner._engine(self.hidden, problem)
            engine.c = factor * np.array(SHIFTED[name])
            return super().step(method, problem, t, y, h)

    (probe,) = identify(Subject(Shifted(name, values)))
    wrong = probe.wrong_times
    assert wrong is not None and wrong.name == name
    assert wrong.times == pytest.approx(SHIFTED[name], abs=1e-14)
    assert any("at times other than" in note for note in probe.notes)
    assert [x["same_times"] for x in probe.as_json()["matches"]] == [False] * len(probe.matches)
    page = _page(probe, Style())
    head, first, second, *_ = page.splitlines()
    assert head == "black-box with wrong stage times"
    assert f"not {name}: its coefficients, with f at other times" in first
    assert f"those of {name}: c = " in second
    assert "autonomous systems only" in page
    (right,) = identify(Subject(Opaque(name, values)))
    assert right.wrong_times is None and _page(right, Style()).splitlines()[0] == "black-box"


SHIFTED = {
    "rk4": [0.0, 0.5, 0.5, 1.0],
    "gauss-2": [0.5 - 3**0.5 / 6, 0.5 + 3**0.5 / 6],
    "gsymplectic-n": [0.5 - 3**0.5 / 6, 0.5 + 3**0.5 / 6],
}


def test_what_cannot_be_read_is_said_and_not_guessed() -> None:
    class Deaf:
        methods = {"black-box": {"order": 1}}  # noqa: RUF012

        def step(self, _: str, problem: Any, t: float, y: Any, h: float) -> Any:
            return y

    class RunsOnly:
        methods = ("gsymplectic-n",)

        def solve(self, *_: Any, **__: Any) -> Any:
            raise AssertionError

    for adapter, words in ((Deaf(), "was not called"), (RunsOnly(), "needs `step`")):
        (probe,) = identify(Subject(adapter))
        assert probe.reading is None and probe.matches == () and words in probe.notes[0]


def test_a_run_of_one_step_shows_a_one_step_method() -> None:
    class RunsOnly(Opaque):
        step = None  # type: ignore[assignment]

        def solve(self, method: str, problem: Any, h: float, steps: int) -> Any:
            return self.inner.solve(self.hidden, problem, h, steps)

    (probe,) = identify(Subject(RunsOnly("gauss-3")))
    assert probe.matches[0].name == "gauss-3"


@pytest.mark.slow
def test_an_adapter_that_iterates_without_end_is_refused() -> None:
    class Endless:
        methods = {"black-box": {"order": 1}}  # noqa: RUF012

        def step(self, _: str, problem: Any, t: float, y: Any, h: float) -> Any:
            for k in range(1000):
                problem.f(t, y + k)
            return y

    refused(UsageError, "more than 200 points", read, Subject(Endless()), "black-box", 1)


@pytest.mark.parametrize(
    "text", ["1/2", "-7/24", "19372/6561", "sqrt(3)/6", "1/4-sqrt(3)/6", "(5+2*sqrt(15))/10"]
)
def test_closed_forms_are_recognised_from_doubles(text: str) -> None:
    from glmref.exact.expression import parse

    value = parse(text)
    found = recognised(float(value))
    assert found is not None and parse(found) == value


@pytest.mark.slow
def test_a_number_without_a_closed_form_stays_a_ball_of_its_digits() -> None:
    reading = read(Subject(Opaque("gauss-5")), "black-box", 1)
    method, complete = as_method(reading)
    assert not complete and not method.is_exact
    assert isinstance(method.V[0][0], Exact)
    assert recognised(float(Fraction(1, 3)) + 1e-12) is None


@pytest.mark.slow
def test_scipy_is_read_as_dormand_prince_and_dop853_as_its_table() -> None:
    pytest.importorskip("scipy")
    from scipy.integrate._ivp import dop853_coefficients as table

    from glmref.conformance.adapters.scipy_steps import Adapter

    subject = Subject(Adapter())
    (rk45,) = identify(subject, "dormand-prince-5")
    assert rk45.matches[0].name == "dormand-prince-5"
    (dop853,) = identify(subject, "dop853")
    reading = dop853.reading
    assert reading is not None and dop853.notes == () and dop853.analysis.order == 8
    assert np.abs(reading.blocks["A"] - table.A[:12, :12]).max() < 1e-10
    assert np.abs(reading.blocks["B"][0] - table.B).max() < 1e-10
    assert np.abs(reading.c - table.C[:12]).max() < 1e-10
    (radau,) = identify(subject, "radau-iia-3")
    assert radau.matches[0].name == "radau-iia-3"


def test_the_command_prints_a_page_and_strict_json(capsys: pytest.CaptureFixture[str], cli) -> None:
    assert "gauss-2" in cli("conformance", "reference", "--identify", "--method", "gauss-2").out
    assert (
        main(
            [
                "conformance",
                "reference",
                "--identify",
                "--method",
                "gsymplectic-n",
                "--format",
                "json",
            ]
        )
        == 0
    )
    document = json.loads(capsys.readouterr().out)
    assert document["format"] == "glmref-probe-1"
    (probe,) = document["probes"]
    assert probe["matches"][0]["name"] == "gsymplectic-n"
    assert probe["analysis"]["g_symplectic"]["holds"] is True
    for wrong in (["nothing"], ["reference", "--method", "rk5"]):
        assert len(cli("conformance", "--identify", *wrong, code=2).err.splitlines()) == 1
