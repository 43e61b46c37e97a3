"""Functions of the judge over numbers of the package."""

from glmref.errors import ExactnessError
from glmref.exact import Ball, exact
from glmref.exact.judging import as_number, asked, inward, outward
from tests.build import refused

ROOT, I = exact(2).sqrt(), exact(-1).sqrt()
WIDE = Ball.decimal("0.0", 1)


def test_numbers_go_in_and_come_back_as_they_are():
    given = (exact(3), ROOT, ((I, exact(0)), (Ball.decimal("0.5", 20),)), 7, True, None, "text")
    back = outward(inward(given))
    assert isinstance(back, tuple) and back[:2] == (3, ROOT) and back[2][0] == (I, 0)
    assert back[2][1][0].contains(exact(1) / 2) and back[2][1][0].radius() < 1e-18
    assert back[3:] == (7, True, None, "text")


def test_conjugates_and_signs_are_those_of_the_numbers():
    square, mirror = asked("numbers.squared"), asked("polynomials.mirror")
    assert square(1 + I * ROOT) == 3 and mirror((I, exact(2))) == (2, -I)
    assert asked("numbers.sign")(1 - ROOT) == -1 == -as_number(ROOT).sign()
    refused(ExactnessError, "only a real number has a sign", asked("numbers.sign"), I)


def test_what_the_judge_does_not_decide_is_an_error_of_the_package():
    refused(ExactnessError, "an interval holds 0", asked("linalg.rank"), ((WIDE,),))
    refused(ExactnessError, "singular", asked("linalg.inverse_matrix"), ((exact(0),),))
