"""Refusals, and readers of small JSON values."""

SIZE = 200  # rows and columns of a matrix of the document


class Refused(Exception):
    """The certificate proves nothing: the answer is no."""

    def __init__(self, why):
        super().__init__(why if len(why) <= 200 else f"{why[:200]}...")


class Unreadable(Exception):
    """The file is not JSON: the exit code is 2."""


def require(truth, why):
    """Refuse unless `truth`."""
    if not truth:
        raise Refused(why)


def not_covered(what):
    """Refuse what this checker does not decide."""
    raise Refused(f"not covered: {what}")


def beyond(_number=None, _frame=None):
    """Refuse what takes too long."""
    raise Refused("beyond the limits of this checker")


def keys(thing, needed, optional="", where="witness"):
    """Refuse an object whose keys are not the `needed` ones and some `optional` ones."""
    require(isinstance(thing, dict), f"the {where} is no object")
    needed, optional = set(needed.split()), set(optional.split())
    for key in needed - set(thing):
        raise Refused(f"the {where} has no key {key!r}")
    for key in set(thing) - needed - optional:
        raise Refused(f"the {where} has an unknown key {key!r}")


def whole(value, low=0, high=20):
    """Return an integer within bounds."""
    require(type(value) is int and low <= value <= high, f"{value!r} is no whole number in bounds")
    return value


def as_object(value):
    """Return an object of the certificate."""
    require(isinstance(value, dict), "an object is missing")
    return value
