"""Exact theory: arithmetic with nested roots, orders, starting methods, proofs by enclosure."""

from glmref.catalogue.lookup import load
from glmref.exact.expression import parse
from glmref.prove.kernel import Kernel
from glmref.prove.verifier import verify_file
from glmref.theory.order import order_of


class Arithmetic:
    def setup(self):
        self.x = parse("sqrt((65274*sqrt(330)-347009)/1265902)*sqrt(3)+sqrt(5)")
        self.y = parse("sqrt((5934*sqrt(330)-70541)/115082)+sqrt(15)/7")

    def time_multiply(self):
        self.x * self.y

    def time_divide(self):
        self.x / self.y

    def time_decide_zero(self):
        (self.x * self.y - self.y * self.x).is_zero()


class OfMethod:
    param_names = ["method"]

    def setup(self, name):
        self.method = load(name)


class Order(OfMethod):
    params = ["rk4", "gauss-2", "gauss-4", "gsymplectic-n", "g4123", "g6245-w3", "bdf-6"]

    def setup(self, name):
        super().setup(name)
        order_of(self.method)

    def time_free(self, name):
        order_of(self.method)

    def time_identity(self, name):
        order_of(self.method, principal="identity")


class Pairs(OfMethod):
    params = ["stormer-verlet", "suzuki-verlet-4", "lobatto-iiia-iiib-3"]
    param_names = ["pair"]

    def setup(self, name):
        super().setup(name)
        order_of(self.method)

    def time_order(self, name):
        order_of(self.method)


class Starting(OfMethod):
    params = ["gsymplectic-n", "thesis-3-8"]

    def time_starting_order(self, name):
        Kernel(self.method).range("starting-order")


class Proofs:
    """All claims of one file, the interval tests of its method and of its start included."""

    params = ["g6245-w3", "t115a-w3", "order8-s3-w3-i", "order8-s5-w3", "kahan-li-8"]
    param_names = ["file"]
    timeout = 120

    def setup(self, name):
        verify_file(name)

    def time_verify(self, name):
        verify_file(name)
