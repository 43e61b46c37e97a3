"""Every command that takes a method, on every kind of shipped file and of those wrong on purpose.

A method of a rare class reaches code that the tests of a command do not: each answer must be an
exit code that the command documents, and never an internal error. Every file is taken where
``GLMREF_LONG`` is set; ``show`` takes every file and ``cite`` every method in any case
(tests/unit/test_show.py, test_catalogue.py).
"""

import json
import os

import pytest

from glmref.catalogue.lookup import names, path_of
from glmref.cli import main
from glmref.exchange.export import TARGETS
from glmref.measure import stability
from glmref.views import portrait
from tests.build import SOURCE, scene_text
from tests.shipped import shipped

METHODS = names("methods")
BROKEN = names("broken")


def kinds(listed: list[str]) -> list[str]:
    """Return of each kind of file the shortest: kinds differ in class or keys."""
    if "GLMREF_LONG" in os.environ:
        return listed
    found: dict[tuple[str, frozenset[str]], str] = {}
    for name in sorted(listed, key=lambda x: path_of(x).stat().st_size):
        d = shipped(name)
        found.setdefault((d["class"], frozenset(d)), name)
    return sorted(found.values())


#: Parts of names of methods of which some answer takes seconds.
LONG = tuple("6245 robust thesis-3-8 hairer order8 tanaka -10 -12 -14 s7 s9".split())


def code_of(capsys: pytest.CaptureFixture[str], *arguments: str) -> int:
    """Run a command line, which must not end in an internal error."""
    code = main(arguments)
    err = capsys.readouterr().err
    assert code in (0, 1, 2, 3) and "internal error" not in err, (arguments, err)
    assert code != 2 or err.count("\n") <= 2, (arguments, err)
    return code


@pytest.fixture
def few_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw from few points: what a method breaks, it breaks there, too."""
    for name, points in (("locus", {"turns": 24}), ("interval", {"samples": 64})):
        whole = getattr(stability, name)
        monkeypatch.setattr(
            portrait, name, lambda *a, f=whole, few=points, **k: f(*a, **{**k, **few})
        )
    monkeypatch.setattr(stability, "_SAMPLES", 48)
    monkeypatch.setattr(stability, "GRID", 12)


@pytest.mark.sampled(1, besides=LONG, whole=len(METHODS) + len(BROKEN))
@pytest.mark.parametrize("name", [*kinds(METHODS), *kinds(BROKEN)])
@pytest.mark.usefixtures("few_points")
def test_what_describes_a_method_takes_every_kind(name, capsys, tmp_path):
    picture = tmp_path / "picture.svg"
    assert code_of(capsys, "show", name) == 0
    assert code_of(capsys, "show", name, "--decimal", "5") == 0
    assert code_of(capsys, "cite", name) == 0
    code_of(capsys, "show", name, "--plot", str(picture))
    code_of(capsys, "check", str(path_of(name)))
    for target in TARGETS:
        code_of(capsys, "export", name, "--to", target)


@pytest.mark.sampled(1, besides=LONG, whole=len(METHODS) + len(BROKEN))
@pytest.mark.parametrize("name", [*kinds(METHODS), *kinds(BROKEN)])
def test_every_kind_of_method_is_analysed(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """`verify` and `certify`, which read claims, have test_catalogue and test_judge_catalogue."""
    assert code_of(capsys, "analyze", name) in (0, 3)


@pytest.mark.sampled(2, whole=30)
@pytest.mark.parametrize("name", kinds(METHODS))
def test_a_scene_takes_every_kind_of_method(name, capsys, tmp_path):
    scene, answer = tmp_path / "every.toml", 'kind = "fastest"\nat = 1e-3'
    # one for all classes of methods: its Hamiltonian is separable and quadratic
    keys = {"methods": [name], "ask": ["state"], "t_end": 1, "steps": [8], "repeats": 1}
    scene.write_text(scene_text("every", answer=answer, **keys))
    assert code_of(capsys, "run", str(scene), "--plan") in (0, 2)
    code_of(capsys, "run", str(scene), "--output", str(tmp_path / "out"))


OWN = {
    "format": "glmref-method-2", "name": "mine", "class": "rosenbrock",
    "alpha": [["0", "0"], ["1", "0"]], "gamma": [["g", "0"], ["-2*g", "g"]], "b": ["1/2", "1/2"],
    "constants": {"g": "1-sqrt(2)/2"},
    "claims": {"order": 2}, "source": SOURCE,
}  # fmt: skip


def test_a_rosenbrock_method_that_is_not_decided_in_time_is_measured(capsys, tmp_path, monkeypatch):
    """The ends of its intervals were asked of the additive method, which has no rounded form."""
    monkeypatch.setattr("glmref.prove.analysis.STABILITY", 1e-9)
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(OWN))
    assert main(["analyze", str(path), "--format", "json"]) in (0, 3)
    found = json.loads(capsys.readouterr().out)
    # L-stable with this gamma: nothing leaves the unit disc as far as is looked
    assert found["stability_measured"]["imaginary"] == 64
