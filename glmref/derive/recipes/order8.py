"""Order 8, parasitism-free, symmetric, G-symplectic: three to five stages, one to five implicit.

Stage order 2 or 3 makes nearly all conditions follow from others (:mod:`glmref.prove.classes`):
of the 200 trees up to order 8 there remain [oooo] of order 5 and three trees of order 7 at stage
order 2, or one at stage order 3. With the stage-order equations s = 5, r = 4 leaves two free
parameters, or none when only the middle stage is implicit; s = 3 needs two complex pairs (r = 6),
and with these s = 4 at stage order 3 has one free parameter when stages 1 and 4 are explicit.
``name`` picks one method, all are derived without; ``start`` says whether start and finish are
derived too (45 or 95 stages, seven of them coupled, and an exact inverse for the first value).
"""

from __future__ import annotations

from collections.abc import Mapping

from ...errors import UsageError
from ..ansatz import Ansatz, Value
from .record import Derivation, Progress, Statement
from .solved import Rough, finish

__all__ = ["OPTIONS", "ROUGH", "derive"]

OPTIONS: Mapping[str, str] = {"name": "all", "start": "yes"}

_W3, _I, _EVEN = Value("exp(2*pi*i/3)"), Value("i"), Value("-1", 1, 1)

ROUGH: Mapping[str, Rough] = {
    x.ansatz.name: x
    for x in [
        Rough(
            Ansatz(
                "order8-s5-w3",
                5,
                8,
                (_W3, _EVEN),
                stage_order=2,
                fixed={"alpha2": "36/25", "beta2": "-277/1000"},
                title="Order 8 with five stages, small coefficients and error",
            ),
            (
                *("0.444081807265", "-0.143687443664", "0.568445411511", "0.402133145678"),
                *("-0.685581355088", "-0.0971830417664", "-0.435305144495", "-0.339696721932"),
                "3.55836729613e-05",
            ),
            "two-parameter family with stage order 2, at alpha2 = 1.44, beta2 = -0.277",
        ),
        Rough(
            Ansatz(
                "order8-s5a-w3",
                5,
                8,
                (_W3, _EVEN),
                stage_order=2,
                fixed={"b2": "573/500", "alpha1": "-113/250"},
                title="Order 8 with five stages, smallest error after the best conjugation",
            ),
            (
                *("-0.902252428882", "-0.482892662805", "0.819110297017", "0.624248219314"),
                *("-0.544271318954", "-0.153226576753", "0.126627835022", "0.104697662861"),
                "-3.00220178516e-05",
            ),
            "two-parameter family with stage order 2, at b2 = 1.146, alpha1 = -0.452",
            grows="threefold",
        ),
        Rough(
            Ansatz(
                "order8-s5q3-w3",
                5,
                8,
                (_W3, _EVEN),
                stage_order=3,
                fixed={"alpha2": "9/100"},
                title="Order 8 with five stages and stage order 3",
            ),
            (
                *("0.37349508826259", "0.27808133030683", "0.95627514881742", "0.38437880055767"),
                *("0.38830288456323", "-1.7055517328914", "-1.1492853557736"),
                *("-0.29899293020984", "1.8489705631702"),
            ),
            "one-parameter family with stage order 3, at alpha2 = 0.09",
            grows="thirtyfold",
        ),
        Rough(
            Ansatz(
                "order8-s5i1-w3",
                5,
                8,
                (_W3, _EVEN),
                stage_order=2,
                explicit=(1, 2),
                title="Order 8 with five stages, one of them implicit",
            ),
            (
                *("-0.31872896032811", "0.29132889409361", "-1.2784106742019"),
                *("-0.26578396221317", "0.063372371871487", "-1.2424372390262"),
                *("0.31369882309529", "0.79896802778958", "-0.7837674447747"),
                *("0.21553156539475", "0.00052376424906192"),
            ),
            "isolated solution with stage order 2 and only stage 3 implicit",
            grows="thirtyfold",
        ),
        Rough(
            Ansatz(
                "order8-s3-w3-i",
                3,
                8,
                (_W3, _I, _EVEN),
                stage_order=3,
                fixed={"b1": "91/125"},
                title="Order 8 with three stages and six values",
            ),
            (
                *("0.13963086756437", "0.043936351418934", "-0.26167469596694"),
                *("-0.43560785150113", "-0.57099070506378", "-1.2838473142807"),
                *("-0.13071382419301", "0.23366879454443"),
            ),
            "one-parameter family with stage order 3 and r = 6, at b1 = 0.728",
            grows="thirtyfold",
        ),
        Rough(
            Ansatz(
                "order8-s4i2-w3-i",
                4,
                8,
                (Value("exp(2*pi*i/3)", 1), _I, Value("-1", -1, -1)),
                stage_order=3,
                explicit=(1,),
                fixed={"b1": "-7/50"},
                title="Order 8 with four stages, two of them implicit, and six values",
            ),
            (
                *("0.0359234601796268", "-0.153166075038863", "1.17387550968441"),
                *("-0.527500129183244", "1.34971696203506", "-0.284843456134963"),
                *("0.228265781788632", "-0.573382033123746", "0.710938156584241"),
                "-0.332510875640359",
            ),
            "one-parameter family with stage order 3, r = 6 and stages 1 and 4 explicit, at "
            "b1 = -0.14",
        ),
    ]
}


def derive(options: Mapping[str, str], progress: Progress) -> Derivation:
    """Derive one method or all of them.

    Raises
    ------
    UsageError
        For a name that is not in the table.
    """
    name = options["name"]
    if name != "all" and name not in ROUGH:
        raise UsageError(f"`name` must be all or one of {', '.join(ROUGH)}, got {name!r}")
    chosen = list(ROUGH) if name == "all" else [name]
    documents, statements = [], list[Statement]()
    for k, each in enumerate(chosen):
        progress(each, k, len(chosen))
        document, _, proved = finish(ROUGH[each], start=options["start"] == "yes")
        documents.append(document)
        statements += proved
    progress("done", len(chosen), len(chosen))
    return Derivation("order8", documents, statements)
