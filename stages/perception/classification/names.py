"""Names of a thing with their probabilities, what further signs make of them, and when a name is sure enough."""

from collections.abc import Collection, Mapping
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.category import log_extents

Array = NDArray[np.float64]
NO_KIND, NO_NAME = "more likely nothing that the library has", "no name is sure enough"
CARRIERS = {"appliance", "storage", "table"}  # kinds that carry things; chosen
LIKELY = 0.2  # least probability of all kinds that carry, of what is placed for what it carries; chosen
STRETCH = float(np.log(2.0))  # by which a thing is larger than the largest models of a category at most; chosen
HARDLY = 1e-3  # how likely it is larger; chosen
LEAST = 1e-3  # metres: no extent is smaller
UNSURE = (NO_KIND, NO_NAME)
# What measuring an outline may raise: no point or pixel of it, none that agree, numbers that are none.
ODD = (ValueError, IndexError, ArithmeticError, np.linalg.LinAlgError, cv2.error)
UNMEASURED = "its outline cannot be measured: too few pixels, or none that agree"


class LikelyName(NamedTuple):
    """A category of the library, in words, and how sure it is, 0 to 1."""

    name: str
    probability: float

    @property
    def category(self) -> str:
        """The name of the category."""
        return self.name.replace(" ", "_")


class Names(NamedTuple):
    """Categories, surest first, and the probability that it is none of them: together 1."""

    proposals: list[LikelyName]
    other: float

    def weigh(self, weights: Mapping[str, float], other: float = 1.0) -> "Names":
        """The names by a further sign.

        Args:
            weights: how likely the sign is of a thing of each category; 1 where nothing is said.
            other: how likely it is of what is none of them.
        """
        shares = [(one.name, one.probability * weights.get(one.category, 1.0)) for one in self.proposals]
        return normalise(shares, other * self.other)

    def restrict(self, priors: Mapping[str, float]) -> "Names":
        """The names of what is one of a few categories: what none of them is, is shared by priors."""
        said = {one.category: one.probability for one in self.proposals}
        shares = [(kind, said.get(kind, 0.0) + prior * self.other) for kind, prior in priors.items()]
        shares = shares if sum(share for _, share in shares) else list(priors.items())
        return normalise([(kind.replace("_", " "), share) for kind, share in shares], 0.0)

    def doubt(self, other: float) -> "Names":
        """The same names of what is so likely none of any."""
        return normalise([(one.name, one.probability * (1 - other)) for one in self.proposals], other)

    def choose_among(self, before: Mapping[str, float], sign: Mapping[str, float]) -> "Names":
        """The names of what is one of some categories, by how likely each was before, and by a further sign."""
        total = sum(before.values())
        return self.restrict({name: share / total for name, share in before.items()}).weigh(sign)


def normalise(shares: list[tuple[str, float]], other: float) -> Names:
    """The names of these shares, in words, and of `other`."""
    total = sum(share for _, share in shares) + other
    found = [LikelyName(name, share / total) for name, share in shares]
    return Names(sorted(found, key=lambda one: -one.probability), other / total)


def find_surest(named: Mapping[int, Names]) -> int:
    """The thing with the surest name: a scene has one thing at least."""
    return max(named, key=lambda value: named[value].proposals[0].probability)


def measure_kin(names: Names) -> float:
    """How likely it is of the kin of its first name: a sofa of .4 with an armchair of .4 is a seat."""
    known = known_categories()
    first = names.proposals[0]
    kin = set(known[first.category].kin) if first.category in known else set()
    alike = [one for one in names.proposals if one.category in known and kin & set(known[one.category].kin)]
    return sum(one.probability for one in alike or [first])


def find_reason(names: Names, sure: float) -> str:
    """Why a thing of these names is left out; empty: it is placed. One rule for pictures with depth and without.

    sure: least probability of the kin of the first name.
    """
    kin = measure_kin(names)
    if names.other > kin:
        return NO_KIND
    return NO_NAME if kin < sure else ""


def refuse_size(names: Names, extents: Array) -> Names:
    """The names of what is seen to be so large: those whose things would be stretched beyond reason are hardly so.

    extents: (3,) metres, z up, of what is seen; of any thing there may be more. The shorter one on the ground does not
        count: of a thing that is flat it is the noise of its depth.
    """
    seen = log_extents(np.maximum(extents, LEAST))
    usual = {name: one.measure_usual_size(further=True) for name, one in known_categories().items()}
    hardly = {name: HARDLY for name, one in usual.items() if one and (seen - one.high > STRETCH)[1:].any()}
    return names.weigh(hardly)


def carries(kind: str) -> bool:
    """Whether things of a category carry others."""
    return bool(CARRIERS & set(known_categories()[kind].kin))


def may_carry(names: Names) -> bool:
    """Whether a thing of these names is placed for what it carries, however unsure which name is right."""
    known = known_categories()
    each = [one.probability for one in names.proposals if one.category in known and carries(one.category)]
    return sum(each) >= LIKELY


def place_sure(named: Mapping[int, Names], sure: float, carriers: Collection[int] = ()) -> dict[int, str]:
    """Labels of what is placed: what has a sure name, and what may carry something that stands on others alone."""
    return {
        value: names.proposals[0].name
        for value, names in named.items()
        if (value in carriers and may_carry(names)) or not find_reason(names, sure)
    }
