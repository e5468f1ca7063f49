"""Functions that are sent to workers, or that fail in every way in which one can."""

import os
import sys
import time

import numpy as np

from kneecore import Input, Model, Output

SQUARE = [Input("a", lower=0.0, upper=1.0), Input("b", lower=0.0, upper=2.0)]
PAIR = [Output("y", axis=(1, 2))]


def plain(x):
    return [x.sum(), x[0] * x[1]]


def slow(x):
    time.sleep(0.01)
    return plain(x)


def slowly(x):
    """Too slow to follow a slider."""
    time.sleep(0.1)
    return plain(x)


def many(x):
    """The same, of many points at once."""
    return np.stack([x.sum(axis=1), x[:, 0] * x[:, 1]], axis=1)


class Failing:
    """Fails where a is above a limit, in the way that is asked for."""

    def __init__(self, how, above=0.8):
        self.how, self.above = how, above

    def __call__(self, x):
        return getattr(self, self.how)(x) if x[0] > self.above else plain(x)

    def raises(self, x):
        raise ValueError("no\nconvergence")

    def exits(self, x):
        sys.exit("enough")

    def dies(self, x):
        os._exit(3)

    def hangs(self, x):
        time.sleep(60)

    def nan(self, x):
        return [np.nan, x.sum()]

    def shape(self, x):
        return [1.0, 2.0, 3.0]

    def complex(self, x):
        return [1j, 2.0]

    def ragged(self, x):
        return [[1.0], 2.0]

    def text(self, x):
        return "broken"


def moody(x):
    """Fails in another way in each part of its bounds; hangs above 0.8."""
    how = {0: "nan", 1: "raises", 2: "dies", 8: "hangs", 9: "hangs"}.get(int(10.0 * x[0]))
    return plain(x) if how is None else getattr(Failing(how), how)(x)


def square(run=plain, **options):
    """Return a model of two inputs and two outputs."""
    return Model(run, SQUARE, PAIR, name="square", **options)


def points(n, seed=0):
    """Return points of its box, the first one without failure."""
    x = np.random.default_rng(seed).random((n, 2)) * [1.0, 2.0]
    x[0] = 0.1
    return x
