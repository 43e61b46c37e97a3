"""The shipped pairs: an ansatz with its free parameters fixed, and a start for the other unknowns.

The numbers were found by searches (see docs/pairs.md); four digits of the free parameters were kept
and everything else follows from the equations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..partitioned import PairAnsatz

__all__ = ["SHIPPED", "Shipped"]


@dataclass(frozen=True)
class Shipped:
    """An ansatz with as many unknowns as equations, and a dozen digits of each unknown.

    Attributes
    ----------
    start : str
        In the order of the document.
    claims : Mapping[str, Any]
        Besides the usual ones.
    notes : Sequence[str]
        For the file.
    """

    ansatz: PairAnsatz
    start: str
    claims: Mapping[str, Any] = field(default_factory=dict)
    notes: Sequence[str] = ()


_FOUR = "Explicit G-symplectic pair of order 4 with {} force evaluations, for separable systems"
_SIX = "Explicit G-symplectic pair of order 6 with {} force evaluations, for separable systems"
_SECOND = "Explicit G-symplectic pair of order 6 on second-order systems, with {} force evaluations"

#: A label that `tests/unit/test_pairs.py` compares with the sign and size of the curvature.
_LEAVES = (
    "On q'' = -omega^2 q its parasitic eigenvalues leave the unit circle at once, |w| - 1 = "
    "{} (h omega)^3, although its growth parameters are 0: errors of the carried values grow, see "
    "docs/pairs.md."
)
#: A label that `campaigns/partitioned/test_work.py` compares with `pairs-long.json`.
_GROWS = (
    "Over ten million steps from zero values its energy error or its carried values grow on {}, "
    "see data/measurements/pairs-long.json."
)
#: A label that `campaigns/partitioned/test_starts.py` compares with its measurements.
_STAYS = (
    "Over as many steps from the starting method of this file they stay bounded, see "
    "data/measurements/pairs-starts.json."
)
#: A label that `campaigns/partitioned/test_starts.py` compares with the longer of its measurements.
_LATER = (
    "Over a hundred million steps from the starting method of this file its energy error or its "
    "carried values grow on {}, see data/measurements/pairs-starts.json."
)

SHIPPED: Mapping[str, Shipped] = {
    "pair-4-4": Shipped(
        PairAnsatz(
            "pair-4-4", 4, 4, title=_FOUR.format("four"),
            fixed={"w2": "5031/10000", "c1": "-31/200", "v1": "-226/625"},
        ),
        "0.292538003158 -0.0800950647859 -0.26324858746 -0.175903151702",
    ),
    "pair-4-5": Shipped(
        PairAnsatz(
            "pair-4-5", 5, 4, title=_FOUR.format("five"),
            fixed={
                "b1": "-787/5000", "w1": "-1851/1250", "w2": "-8653/10000", "c1": "-971/5000",
                "v1": "13329/10000",
            },
        ),
        "0.33746925348 0.537597926807 0.474413887059 0.852792719724",
        notes=[_LATER.format("pendulum")],
    ),
    "pair-4-6": Shipped(
        PairAnsatz(
            "pair-4-6", 6, 4, title=_FOUR.format("six"),
            fixed={
                "b2": "3273/10000", "w1": "-3119/5000", "w2": "281/1250", "w3": "1413/1250",
                "v1": "-501/1250", "v2": "-453/1000", "v3": "359/2500",
            },
        ),
        "0.0673605816682 -0.0334573194165 0.200983455503 -0.208313166578",
        notes=[_GROWS.format("pendulum"), _STAYS, _LATER.format("pendulum")],
    ),
    "pair-6-7": Shipped(
        PairAnsatz(
            "pair-6-7", 7, 6, starts="q", title=_SIX.format("seven"),
            fixed={"w4": "-3839/625", "v2": "447/1000"},
        ),
        "0.0731280525908 0.220315238955 0.209908313854 0.118433510039 -0.466290361378 "
        "0.607722904279 0.155114360527 0.205100688002 -0.0160361492084 -0.741979426964 "
        "-2.80726432963",
        notes=[_LEAVES.format("1.70e-03"), _GROWS.format("henon-heiles")],
    ),
    "pair-6-10": Shipped(
        PairAnsatz(
            "pair-6-10", 10, 6, starts="q", title=_SIX.format("ten"),
            fixed={
                "b2": "-109/625", "b5": "-383/10000", "w5": "409/1250", "c4": "-731/2500",
                "v1": "-10711/10000", "v2": "-643/5000", "v3": "384/625", "v4": "-3331/10000",
            },
        ),
        "0.251090885793 0.280911879666 0.0405045113845 0.487998301098 0.813267657402 "
        "0.169709559807 1.12828447308 -0.0758723903025 0.240865316 0.160207480514 -0.34319691946",
        notes=[_LEAVES.format("1.12e-06"), _GROWS.format("henon-heiles"), _STAYS],
    ),
    "pair-6-8": Shipped(
        PairAnsatz(
            "pair-6-8", 8, 6, starts="qp", title=_SIX.format("eight"),
            fixed={"w1": "-4683/2000", "w3": "-141/250", "w4": "-8373/5000"},
        ),
        "0.0397332988605 0.172023548463 0.340545533412 -0.125319674888 0.383222306583 "
        "0.115842014381 0.196433425565 -0.21231867203 -0.131590990914 0.413191214356 "
        "0.577833811431 -0.297259314141",
        notes=[_GROWS.format("pendulum"), _STAYS, _LATER.format("pendulum")],
    ),
    "pair-6-9": Shipped(
        PairAnsatz(
            "pair-6-9", 9, 6, starts="qp", title=_SIX.format("nine"),
            fixed={
                "w3": "-129/80", "w4": "5441/5000", "c1": "-1819/10000", "v1": "1359/625",
                "v2": "469/500",
            },
        ),
        "0.0757193856936 0.251825760571 -0.185860742049 0.077352974819 0.364507765322 "
        "-1.1150122129 0.493851284673 0.224118607845 0.23928932166 0.21803099273 0.438660650759 "
        "1.68193872504",
        notes=[_GROWS.format("pendulum"), _STAYS, _LATER.format("pendulum")],
    ),
    "pair-8-24": Shipped(
        PairAnsatz(
            "pair-8-24", 24, 8, starts="qp",
            title="Explicit G-symplectic pair of order 8 with 24 force evaluations, for separable "
            "systems",
            fixed={
                "b3": "887/2500", "b8": "1349/5000", "b11": "-19/10000", "w1": "3559/2000",
                "w7": "7093/10000", "w8": "1789/2000", "w11": "-6381/5000", "w12": "-5239/10000",
                "c3": "1691/2500", "c11": "-3673/5000", "v3": "-13279/10000", "v5": "457/5000",
                "v9": "-9789/2500",
            },
        ),
        "0.0533388478245 0.279396319577 -0.113994669511 -0.453474961673 0.489427801154 "
        "-0.0576816255224 -0.360895876877 0.0493345149163 -0.0115291018601 -0.436864820946 "
        "0.562006484765 0.667586728144 -0.554356239762 -0.0013321223135 1.25523343526 "
        "2.22362650974 0.190887835931 0.368303534835 -0.774766370554 -0.0449812343454 "
        "-0.164595668063 0.116596135717 -0.309617551154 0.00844684491874 0.913074622804 "
        "0.214520591179 -0.161951060525 -1.29069675005 0.158445537105 0.452382160135 "
        "-0.781219965219 0.0803606904258 0.0780878522042 -0.681004973978",
        notes=[_GROWS.format("pendulum")],
    ),
    "pair-rkn-6-7": Shipped(
        PairAnsatz(
            "pair-rkn-6-7", 7, 6, nystrom=True, starts="qp", title=_SECOND.format("seven"),
            fixed={"w2": "-1173/2000", "v1": "-2033/2000", "v3": "-31873/10000"},
        ),
        "0.107524488537 0.296161720794 -0.195122598954 0.228451188528 -0.753234059311 "
        "0.105096380199 0.191318017222 0.188787478906 -0.0381604250752 1.00316298141",
        notes=[_LATER.format("pendulum")],
    ),
    "pair-rkn-6-8": Shipped(
        PairAnsatz(
            "pair-rkn-6-8", 8, 6, nystrom=True, starts="qp", title=_SECOND.format("eight"),
            fixed={
                "b2": "-281/5000", "w1": "2829/5000", "w2": "-19823/5000", "w3": "17691/10000",
                "v4": "46437/10000",
            },
        ),
        "0.0895678753103 0.0738889027341 0.326332230343 -1.38217771271 0.16751937091 "
        "0.0580985558446 0.281253913208 -0.371189801837 0.606468118501 0.607311244804",
        notes=[_GROWS.format("pendulum")],
    ),
    "pair-rkn-6-9": Shipped(
        PairAnsatz(
            "pair-rkn-6-9", 9, 6, nystrom=True, starts="qp", title=_SECOND.format("nine"),
            fixed={
                "w1": "1097/10000", "w2": "69/2500", "w4": "-61/2000", "v1": "-12479/10000",
                "v2": "-6291/5000", "v3": "6147/10000", "v4": "-891/10000",
            },
        ),
        "0.0522853628305 0.223630152208 -0.0479338055328 0.0557564260999 0.244001812969 "
        "0.096224518726 0.122946940736 -0.160892421494 0.161303775508 0.288990674911",
        notes=[_LATER.format("pendulum")],
    ),
    "pair-rkn-6-7b": Shipped(
        PairAnsatz(
            "pair-rkn-6-7b", 7, 6, nystrom=True, starts="qp", title=_SECOND.format("seven"),
            fixed={"b3": "-43/2500", "w3": "-1493/500", "v3": "5183/2500"},
        ),
        "0.0735022726648 0.27869068339 0.0224168334614 -0.453523789031 0.762751680394 "
        "0.174028729186 0.221166463849 -0.0358914366374 -0.271647453727 0.799656718419",
    ),
    "pair-rkn-6-8b": Shipped(
        PairAnsatz(
            "pair-rkn-6-8b", 8, 6, nystrom=True, starts="qp", title=_SECOND.format("eight"),
            fixed={
                "w1": "5789/10000", "w4": "-6067/2500", "c1": "-1963/10000", "v2": "879/1000",
                "v4": "13969/10000",
            },
        ),
        "0.0474484580842 0.0941482672928 0.144056474897 -0.028700674393 -1.07495108804 "
        "0.554776019563 0.343305116342 0.201013320487 1.74414245872 -0.419256551579",
        notes=[_GROWS.format("pendulum"), _STAYS, _LATER.format("pendulum")],
    ),
    "pair-rkn-8-16": Shipped(
        PairAnsatz(
            "pair-rkn-8-16", 16, 8, nystrom=True, starts="qp",
            title="Explicit G-symplectic pair of order 8 on second-order systems, with sixteen "
            "force evaluations",
            fixed={
                "b2": "131/500", "b6": "-1369/10000", "w4": "507/625", "w6": "-4819/10000",
                "w7": "-3313/5000", "v1": "9/200", "v3": "10117/10000", "v5": "-88/625",
                "v6": "-3279/5000", "v7": "-114/125", "v8": "-9/625",
            },
        ),
        "0.071745942194 0.153156311608 -0.271121927751 0.470698275871 -0.0999009454453 "
        "0.337358866297 -0.117822562911 0.20095078075 -0.489427568658 -0.622923609359 "
        "-0.261974837692 0.188268508602 0.276971278675 -0.0861868203505 0.128670347884 "
        "-0.0643131930056 -0.0582908424056 0.0459663173385 0.302450257818 -0.627072349743",
        notes=[_LEAVES.format("6.88e-03"), _GROWS.format("henon-heiles")],
    ),
}  # fmt: skip
