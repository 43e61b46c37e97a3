"""Mutants of the judge: each must be noticed by a hostile row or a certificate that holds.

``python -m tests.adversary.judge_mutation [MODULE..] [SHARE]`` changes one comparison, one connective,
one quantifier or one negation of the judge at a time, and one hypothesis of a rule at a time (dropped
or negated), of one mutant in SHARE, and names those that nothing notices.
"""

import importlib
import importlib.abc
import importlib.util
import os
import resource
import sys
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

from campaigns.mutation.mutants import mutants
from glmref import judge
from glmref.catalogue.lookup import document

from .both_ways import written
from .test_both_ways import ROWS
from .test_hypotheses import certificate_of

FOLDER = Path(judge.__file__).parent
#: Modules that decide nothing: texts, tables, and how files are read.
OTHERS = ("__init__", "__main__", "join", "claims", "command")
MODULES = sorted(p.stem for p in FOLDER.glob("*.py") if p.stem not in OTHERS)
#: Shipped and broken files whose certificates use every rule that proves something, of every class.
HOLDING = """
pair-4-6 pair-rkn-6-7 blanes-moan-4 blanes-moan-rkn-4 calvo-sanz-serna-4 kahan-li-6 mclachlan-atela-5
omelyan-vefrl-4 okunbor-skeel-6 rodas4 s5i1-w3 ab-1 ab-2-one-leg adams-nordsieck-3 am-1 ars-1-2-2 bdf-1 bdf-2-one-leg bogacki-shampine-3-2 dimsim-2-type-1
dimsim-2-type-4 dormand-prince-rkn-4-3 euler fehlberg-2-1 fine-rkn-4-3 g4123 gauss-1 gsymplectic-n
gsymplectic-n-pair gsymplectic-p implicit-midpoint kraaijevanger-spijker-order-2 leapfrog
lobatto-iiia-iiib-2 lobatto-iiic-star-3 mclachlan-4 milne-simpson-one-leg multistep-rkn-8 numerov
pair-4-4 pair-4-5 radau-iia-1 rodas3 s3-w3 ros3-printed ros34pw2 s5i1-i ssp3-4-3-3-printed stormer-verlet
symplectic-euler-a tsitouras-5-4 yoshida-4 ab-4-digit am-2-error-constant bogacki-shampine-digit
dimsim-2-type-1-embedded-digit dormand-prince-5-4-dense-sign dormand-prince-rkn-4-3-digit
explicit-euler-pair-symplectic gsymplectic-n-p-pair gsymplectic-p-parasitism-free imkg-343a-sign
leapfrog-growth-sign lobatto-iiia-3-symplectic mclachlan-atela-4-digits-swapped pair-4-4-p-digit
pair-idle-value radau-iia-2-symmetric rk4-abscissae-ones rodas3-sign ruth-3-sign
symplectic-euler-b-symmetric ark-4-v-preconsistent gsymplectic-n-d-scaled cash-karp-5-4-abscissa
matlode-bogacki-shampine-3-2 ssp3-4-3-3-digit explicit-2-step-order-3 thesis-adams-moulton-implicit thesis-start-3-6-printed trapezoidal-l-stable
"""
#: Kinds of changes that are made.
KINDS = ("comparison", "connective", "quantifier", "negation")
CPU = 40  # seconds of processor time that a child may take
Case = tuple[dict[str, Any], bool, tuple[str, str]]


def cases() -> list[Case]:
    """Return certificates, whether they are accepted, and the hypothesis that refuses them.

    Those of the statements of the hostile rows, in whichever direction they are true, are accepted.
    """
    held = [(dict(document(x)), document(x)["claims"]) for x in HOLDING.split()]
    some = {"order": 12, "preconsistent": True, "consistent": True, "symplectic": True}
    held.append((dict(document("gauss-6")), {**some, "stage-order": 6}))
    for row in ROWS.values():
        # a file with an enclosure is read where it claims an order
        own = {"order": 1} if "enclosure" in row["document"] else {}
        own[row["statement"]["claim"]] = row["statement"]["declared"]
        held.append((row["document"], own))
    found = [(certificate_of(row), False, tuple(row.get("violates", ()))) for row in ROWS.values()]
    true = [x for d, claims in held for x in written(d, claims)]
    return found + [(x, True, ()) for x in true if judge.verdict(x)[0]]


class Mutated(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Import one module of the judge from a text."""

    def __init__(self, name: str, text: str) -> None:
        self.name, self.code = name, compile(text, name, "exec")

    def find_spec(self, fullname: str, path: Any, target: Any = None) -> ModuleSpec | None:
        return importlib.util.spec_from_loader(fullname, self) if fullname == self.name else None

    def exec_module(self, module: ModuleType) -> None:
        exec(self.code, module.__dict__)


def imported(name: str, text: str) -> ModuleType:
    """Import the judge again, one module from a text."""
    own = judge.__name__
    for key in [x for x in sys.modules if x == own or x.startswith(f"{own}.")]:
        del sys.modules[key]
    sys.meta_path.insert(0, Mutated(f"{own}.{name}", text))
    return importlib.import_module(own)


def differs(case: Case) -> bool:
    """Tell whether the judge that is imported answers a case in another way."""
    certificate, accepted, violates = case
    if sys.modules[judge.__name__].verdict(certificate)[0] is not accepted:
        return True
    return bool(violates) and refusing(certificate) != violates


def refusing(certificate: dict[str, Any]) -> tuple[str, ...]:
    """Return the rule and the hypothesis that refuse a part, by the judge that is imported."""
    own = sys.modules[judge.__name__]
    names = {
        x: importlib.import_module(f"{own.__name__}.{x}") for x in ("proof", "rule", "statements")
    }
    try:
        proof = names["proof"].Proof(certificate, names["statements"].RULES)
        for part in proof.parts:
            proof.apply(part)
    except names["rule"].HypothesisFails as error:
        return error.args[0], error.args[1].__name__
    except Exception:
        return ()
    return ()


class Bench:
    """The cases; those that notice the most mutants are asked first."""

    def __init__(self) -> None:
        self.cases = cases()

    def notices(self, change: Callable[[], object]) -> bool:
        """Make a change in a child and tell whether a case differs, or the child breaks down."""
        reader, writer = os.pipe()
        child = os.fork()
        if child == 0:
            resource.setrlimit(resource.RLIMIT_CPU, (CPU, CPU + 1))
            code = 1
            try:
                change()
                for n, case in enumerate(self.cases):
                    if differs(case):
                        os.write(writer, str(n).encode())
                        break
                else:
                    code = 0
            finally:
                os._exit(code)
        os.close(writer)
        with os.fdopen(reader) as stream:
            first = stream.read()
        failed = os.waitpid(child, 0)[1] != 0
        if failed and first:
            self.cases.insert(0, self.cases.pop(int(first)))
        return failed


def changes(modules: Sequence[str]) -> Iterator[tuple[str, str, Callable[[], object]]]:
    """Yield the module, the text and the change of each mutant."""
    statements = importlib.import_module(f"{judge.__name__}.statements")
    for rule in statements.RULES.values():
        for n, hypothesis in enumerate(rule.hypotheses):
            for how, other in (("dropped", ()), ("negated", (negated(hypothesis),))):
                rest = (*rule.hypotheses[:n], *other, *rule.hypotheses[n + 1 :])
                text = f"{rule.name}: {hypothesis.__name__} {how}"
                yield (
                    "hypotheses",
                    text,
                    lambda rule=rule, rest=rest: statements.RULES.update(
                        {rule.name: replace(rule, hypotheses=rest)}
                    ),
                )
    for name in modules:
        for x in mutants((FOLDER / f"{name}.py").read_text(encoding="utf-8")):
            if x.kind in KINDS:
                label = f"line {x.line}: {x.before}  ->  {x.after}"
                yield name, label, lambda name=name, text=x.source: imported(name, text)


def negated(hypothesis: Callable[[Any], object]) -> Callable[[Any], bool]:
    """Return the hypothesis that holds where another does not."""
    return lambda case: not hypothesis(case)


def survivors(modules: Sequence[str], share: int) -> tuple[Counter[str], list[str]]:
    """Return how many mutants of a sample were drawn and noticed by module, and the others."""
    bench, counts, alive = Bench(), Counter(), []
    # else each mutant would count as noticed
    assert not bench.notices(lambda: None), "the judge fails a case, or takes too long, as it is"
    for name, label, change in changes(modules):
        if zlib.crc32(f"{name} {label.partition(': ')[2]}".encode()) % share:
            continue
        counts[f"{name} drawn"] += 1
        if bench.notices(change):
            counts[f"{name} noticed"] += 1
        else:
            alive.append(f"{name} {label}")
            sys.stdout.write(f"{alive[-1]}\n")
            sys.stdout.flush()
    return counts, alive


def main(arguments: Sequence[str]) -> int:
    """Run the mutants; the exit code is 1 where one is not noticed."""
    share = next((int(x) for x in arguments if x.isdecimal()), 1)
    named = [x for x in arguments if not x.isdecimal()]
    counts, alive = survivors(named or MODULES, share)
    for name in ("hypotheses", *MODULES):
        if counts[f"{name} drawn"]:
            sys.stdout.write(f"{name}: {counts[f'{name} noticed']} of {counts[f'{name} drawn']}\n")
    return int(bool(alive))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
