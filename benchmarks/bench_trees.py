"""Trees: listing, growth counts. Each timing starts from nothing remembered."""

from glmref.judge import trees as judged
from glmref.method.component import GENERAL
from glmref.theory import trees as module
from glmref.theory.trees import pruned, trees_up_to


def forget():
    for kept in (pruned, module._level, judged.trees):
        kept.cache_clear()
    module._MADE.clear()


class FromNothing:
    param_names = ["order"]
    number = 1

    def setup(self, order):
        forget()


class Listing(FromNothing):
    params = [6, 8, 10, 12]

    def time_rooted(self, order):
        trees_up_to(order)


class TwoColours(FromNothing):
    params = [4, 6]

    def time_general(self, order):
        trees_up_to(order, GENERAL)


class Cuts(FromNothing):
    params = [6, 8]

    def setup(self, order):
        super().setup(order)
        self.trees = trees_up_to(order)

    def time_growth_counts(self, order):
        for t in self.trees:
            pruned(t)
