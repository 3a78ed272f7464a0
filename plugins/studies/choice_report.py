"""What `choose` prints, and why it chooses so."""

from collections.abc import Iterator, Sequence

from plugins.studies.choice import Choice, ChosenModel
from plugins.studies.coverage import ERRORS
from stages.contracts.policies import TaskAsset

SEEN = (
    "at eleven of twelve objects policies opened more after eight by chance than after the nearest, often hardly more"
)
WHY = {
    "chance": SEEN,
    "cover": f"you asked for it; at two objects it opened about as many as chance; {SEEN}",
    "nearest": f"you asked for it; {SEEN}",
}  # docs/results/registered.md
NAMED = 6  # models whose names stand in a line
STEP = "distance 1: a front 1.42 times as wide, or a handle higher by 18 % of the front"


def report(choice: Choice, pool: Sequence[TaskAsset]) -> Iterator[str]:
    """The lines: reason and models, what they show and cover, what is expected of them, and what is out of reach."""
    models = choice.models
    side = "slide" if models[0].hinge == "slide" else f"hinge {models[0].hinge}"
    drawn = f"by {choice.rule}" + f", seed {choice.seed}" * (choice.rule != "nearest")
    yield f"{choice.task}: {len(models)} of {choice.usable} models in {choice.families} families ({side}), {drawn}"
    yield f"  why: {WHY[choice.rule]}"
    yield from (f"  {line_of(model)}" for model in models)
    widths, heights = (f"{one} (library: {all})" for one, all in zip(spans(models), spans(pool), strict=True))
    yield f"shows: fronts {widths} cm wide, handles at {heights} % of the front"
    yield f"covers: {share(choice.within_1)} of the models within 1, {share(choice.within_2)} within 2 ({STEP})"
    best = f"  a set of {len(models)} picked for that alone covers {share(choice.greedy_within_1)} within 1"
    yield best + f", no set more than {share(choice.most_within_1)}" * (choice.most_within_1 < 1)
    if choice.forecast is not None:
        off = f"give or take {100 * ERRORS[choice.task]:.0f} points, as in our study (`lite`, 240 demonstrations)"
        yield f"expects: {share(choice.forecast)} success at the models of other families, {off}"
    if choice.alone:
        names = ", ".join(choice.alone[:NAMED]) + ", ..." * (len(choice.alone) > NAMED)
        yield f"alone: {len(choice.alone)} models are within 1 of none of another family: {names}"


def share(value: float) -> str:
    """In whole percent."""
    return f"{100 * value:.0f} %"


def line_of(model: ChosenModel) -> str:
    """A model and its front."""
    wide, tall = (f"{100 * side:.0f}" for side in model.panel_size)
    return f"{model.asset:<24} {model.handle} at {share(model.handle_height)} of a front of {wide} x {tall} cm"


def spans(models: Sequence[TaskAsset | ChosenModel]) -> tuple[str, str]:
    """From the least to the greatest width of fronts, cm, and height of handles, %."""
    sides = [(100 * model.panel_size[0], 100 * model.handle_height) for model in models]
    widths, heights = (f"{min(side):.0f} to {max(side):.0f}" for side in zip(*sides, strict=True))
    return widths, heights
