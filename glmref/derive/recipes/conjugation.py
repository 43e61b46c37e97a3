"""Order 6 with a free principal start: one to five implicit stages, five, four or three stages.

Dropping stage order 2 or the identity start (Khan 2018, section 3.4, has both) opens these
families. Free parameters are fixed rationally; ``name`` picks one method, all are derived
without.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from ...errors import UsageError
from ..ansatz import Ansatz, Value
from .record import Derivation, Progress, Statement
from .solved import Rough, finish

__all__ = ["OPTIONS", "ROUGH", "derive"]

OPTIONS: Mapping[str, str] = {"name": "all", "start": "yes"}

_W3, _I = Value("exp(2*pi*i/3)"), Value("i")
_EVEN, _ODD = Value("-1", 1, 1), Value("-1", 1, -1)

_B = {"b1": "-17/168", "b2": "3375/9464", "b3": str(1 + Fraction(17, 84) - Fraction(3375, 4732))}
_ABSCISSAE = {"abscissae": ["0", "1/15", "1/2", "14/15", "1"]}


def _thesis(name: str, z: Value, gamma: Value, start: list[str], grows: str = "") -> Rough:
    """The thesis's own b and c, without stage order 2 and with a conjugation."""
    growth = [f"growth {z.eigenvalue}", "growth -1"]
    common = ["order [oo[o]]", "order [[o][o]]", *growth]
    if gamma.parity > 0:
        equations = ["order [oo]", *common, "abscissa 1 = 0", "abscissa 2 = 1/15", "explicit 1"]
    else:
        equations = [*common, "start 2", "abscissa 2 = 1/15", "explicit 1"]
    ansatz = Ansatz(
        name, 5, 6, (z, gamma), fixed=_B, equations=equations, xi=False,
        title=f"Order 6 on the weights and abscissae of the thesis, z = {z.eigenvalue}, "
        f"gamma {'symmetric' if gamma.parity > 0 else 'antisymmetric'}",
    )  # fmt: skip
    where = (
        "b and c of Khan (2018), section 3.4, kept; stage order 2 dropped, principal start a "
        "conjugation"
    )
    return Rough(ansatz, start, where, _ABSCISSAE, grows)


ROUGH: Mapping[str, Rough] = {
    x.ansatz.name: x
    for x in [
        Rough(
            Ansatz(
                "s5t-w3",
                5,
                6,
                (_W3, _ODD),
                fixed={
                    "alpha1": "-13/125",
                    "beta1": "343/250",
                    "beta2": "87/100",
                    "beta3": "-493/1000",
                },
                title="Order 6 with five stages, all implicit",
            ),
            [
                "-0.2946434923620246",
                "0.6693041734219944",
                "0.1761135848758089",
                "0.4026058803757674",
                "0.2671263770832644",
                "0.0004780592168402113",
            ],
            "four-parameter family, gamma antisymmetric, at alpha1 = -0.104, beta1 = 1.372, "
            "beta2 = 0.87, beta3 = -0.493",
        ),
        Rough(
            Ansatz(
                "s5i2-w3",
                5,
                6,
                (_W3, _EVEN),
                fixed={"alpha2": "-39/1000", "beta1": "-6/25", "gamma1": "609/1000"},
                explicit=(1, 3),
                title="Order 6 with five stages, two of them implicit",
            ),
            [
                "-0.1358602918982919",
                "0.4802943201633946",
                "-1.14598472939215",
                "-0.2213140927160747",
                "1.02044781430602",
                "0.3025380473071094",
                "0.2032578208136973",
                "-0.004433354764813192",
            ],
            "three-parameter family with stages 1, 3 and 5 explicit, at alpha2 = -0.039, "
            "beta1 = -0.24, gamma1 = 0.609",
        ),
        Rough(
            Ansatz(
                "s5i1-w3",
                5,
                6,
                (_W3, _EVEN),
                fixed={"b3": "1277/500", "beta1": "-739/1000", "gamma1": "-173/250"},
                explicit=(1, 2),
                title="Order 6 with five stages, one of them implicit",
            ),
            [
                "0.3724709375724228",
                "-0.9657862082262305",
                "0.4954046347894847",
                "-0.9674537029198319",
                "-0.795022884685305",
                "-0.4259018894818349",
                "-0.1536361458943255",
                "0.00268268886209347",
            ],
            "three-parameter family with only stage 3 implicit, at b3 = 2.554, "
            "beta1 = -0.739, gamma1 = -0.692",
            grows="thirtyfold",
        ),
        Rough(
            Ansatz(
                "s5i1-i",
                5,
                6,
                (_I, _EVEN),
                fixed={"b3": "393/500", "beta1": "121/250", "beta2": "811/1000"},
                explicit=(1, 2),
                title="Order 6 with five stages, one of them implicit, z = i",
            ),
            [
                "0.2462345075217921",
                "1.24432022660304",
                "-1.832399343470829",
                "0.5529208191990606",
                "0.8846405068350871",
                "1.736493119465874",
                "0.7602539466171926",
                "0.001909418686861397",
            ],
            "three-parameter family with only stage 3 implicit, at b3 = 0.786, "
            "beta1 = 0.484, beta2 = 0.811",
            grows="thirtyfold",
        ),
        Rough(
            Ansatz(
                "s4-w3",
                4,
                6,
                (_W3, _ODD),
                fixed={"b2": "-873/1000", "alpha2": "109/200"},
                stage_order=2,
                title="Order 6 with four stages",
            ),
            [
                "-0.5307457294148246",
                "-0.7763441454005962",
                "-1.045899705257324",
                "-0.3763854541402051",
                "0.4720206276329117",
            ],
            "two-parameter family with stage order 2, at b2 = -0.873, alpha2 = 0.545",
            grows="threefold",
        ),
        Rough(
            Ansatz(
                "s3-w3",
                3,
                6,
                (_W3, _EVEN),
                fixed={"beta2": "-3713/1000"},
                stage_order=2,
                title="Order 6 with three stages",
            ),
            [
                "0.5244167332846152",
                "-0.5597412319223593",
                "-0.573219161358531",
                "0.5159814372910987",
                "2.391269743248006",
            ],
            "one-parameter family with stage order 2, at beta2 = -3.713",
            grows="threefold",
        ),
        Rough(
            Ansatz(
                "s3i1-w3",
                3,
                6,
                (_W3, _EVEN),
                explicit=(1,),
                stage_order=2,
                title="Order 6 with three stages, one of them implicit",
            ),
            [
                "0.52929441014989",
                "-0.8275688527117205",
                "-0.8774358478957635",
                "-5.126872635044067",
                "0.6743618265821033",
                "-2.866482225519755",
            ],
            "isolated solution with stage order 2 and only stage 2 implicit",
            grows="thirtyfold",
        ),
        _thesis(
            "t115-w3",
            _W3,
            _EVEN,
            [
                "-0.3552633689687438",
                "0.5045330602132363",
                "1.384665794878047",
                "0.4223223924288409",
                "0.4628783912791256",
                "-1.02152406963139",
                "-0.335800547493717",
                "-0.517033171141588",
            ],
        ),
        _thesis(
            "t115a-w3",
            _W3,
            _ODD,
            [
                "-0.2335983111299187",
                "0.2762453063623155",
                "1.086978256777329",
                "-0.1148482280965462",
                "0.6171841649191815",
                "0.4858908330782037",
                "-0.2588266568018778",
            ],
            grows="threefold",
        ),
        _thesis(
            "t115-i",
            _I,
            _EVEN,
            [
                "-1.414850376713584",
                "-0.1003664665077001",
                "-0.0006368143404885331",
                "-0.4532201982578528",
                "0.7169586346972431",
                "-1.000900591477033",
                "0.1848356660442568",
                "-0.6038786364934888",
            ],
        ),
        _thesis(
            "t115a-i",
            _I,
            _ODD,
            [
                "-0.005880126819821916",
                "-0.2024632183988244",
                "-1.058894558741365",
                "0.1233921990891319",
                "-0.6180227654149483",
                "0.3482703869459562",
                "-0.1855183382350619",
            ],
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
    return Derivation("conjugation6", documents, statements)
