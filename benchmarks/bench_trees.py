"""Trees: listing, growth counts. Each timing starts from nothing remembered."""

from glmref.method.component import GENERAL
from glmref.theory import trees as module
from glmref.theory.trees import pruned, trees_up_to


def forget():
    pruned.cache_clear()
    module._LISTINGS.clear()
    for made in module._MADE.values():
        for children in [key for key in made if key]:
            del made[children]


class Listing:
    params = [6, 8, 10, 12]
    param_names = ["order"]
    number = 1

    def setup(self, order):
        forget()

    def time_rooted(self, order):
        trees_up_to(order)


class TwoColours:
    params = [4, 6]
    param_names = ["order"]
    number = 1

    def setup(self, order):
        forget()

    def time_general(self, order):
        trees_up_to(order, GENERAL)


class Cuts:
    params = [6, 8]
    param_names = ["order"]
    number = 1

    def setup(self, order):
        forget()
        self.trees = trees_up_to(order)

    def time_growth_counts(self, order):
        for t in self.trees:
            pruned(t)
