"""Contract of the models that `studies choose` says to train on."""

from pydantic import Field, model_validator

from stages.contracts.files import Contract, Document
from stages.contracts.library import HandleKind
from stages.contracts.parts import HingeSide
from stages.contracts.types import Count, Extent, Finite, Fraction, Id, NonNegative, Seed, Size, Text, check_unique


class ChosenModel(Contract):
    """A model to train on, and what a policy and a gripper meet there."""

    asset: Id
    category: Id
    family: Id = Field(description="the model that it is a variation of; its own id if it is none")
    digest: Text = Field(description="checksum of the model (asset.json)")
    joint: Text = Field(description="the joint that the task opens")
    size: Size = Field(description="box at which it is loaded, metres")
    handle: HandleKind
    hinge: HingeSide = Field(description="side on which the front hangs, seen from before it; slide: a drawer")
    panel_size: tuple[Extent, Extent] = Field(description="width and height of the front at this size, metres")
    handle_length: NonNegative = Field(description="longest extent of the handle at this size, metres")
    handle_height: Finite = Field(
        description="of the handle's centre on the front: 0 at its lower edge, 1 at its upper"
    )


class Choice(Document):
    """`choice.json`: models to train on, one per family, and what they cover of the usable models of the library.

    Usable is what the task can open at one side. Distance 1 is a front 1.42 times as wide, or a handle higher by 18 %
    of the front (`plugins/studies/coverage.py`).
    """

    task: Id
    rule: Id = Field(description="by which they were chosen: chance, cover or nearest")
    seed: Seed = Field(description="of the draw")
    like: Id | None = Field(description="model of the object that policies are for; null: none was named")
    box: Size | None = Field(description="box of that object, in which all are loaded, metres; null: own sizes")
    usable: Count
    families: Count = Field(description="of the usable models")
    models: list[ChosenModel] = Field(min_length=1)
    within_1: Fraction = Field(description="share of the usable models within distance 1 of one that was chosen")
    within_2: Fraction = Field(description="likewise distance 2")
    greedy_within_1: Fraction = Field(description="`within_1` of as many that were picked for that alone")
    most_within_1: Fraction = Field(description="no set of as many reaches more")
    forecast: Fraction | None = Field(
        description="expected success at the usable models of other families; null: no study tells, or there is none"
    )
    alone: list[Id] = Field(description="usable models with none of another family within distance 1")

    @model_validator(mode="after")
    def _once(self) -> "Choice":
        check_unique("models: families", [model.family for model in self.models])
        check_unique("alone", self.alone)
        if not self.within_1 <= self.most_within_1 or not self.within_1 <= self.within_2:
            raise ValueError(f"within_1: is {self.within_1:g}, more than within_2 or most_within_1")
        return self
