"""Whether cousins have as many doors and drawers as were stated for the object."""

from roomkin.stages.contracts import Library
from roomkin.stages.contracts.cousins import Cousin, ObjectCousins
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.contracts.parts import FRONTS
from roomkin.stages.matching.candidates import count_gap


def describe_counts(doors: int, drawers: int) -> str:
    """In words, e.g. `2 doors and no drawer`."""
    parts = zip((doors, drawers), FRONTS, strict=True)
    return " and ".join(f"{number or 'no'} {noun}{'s' * (number > 1)}" for number, noun in parts)


def note_differences(entry: ObjectCousins, item: SceneObject, library: Library) -> ObjectCousins:
    """The entry, where each cousin with other doors or drawers than were stated says so, and which model has them."""
    if item.doors + item.drawers == 0:
        return entry
    models = {one.id: one for one in library.assets}
    stated = describe_counts(item.doors, item.drawers)
    fitting = [one.rank for one in entry.cousins if count_gap(item, models[one.asset]) == 0]

    def describe_difference(one: Cousin) -> str:
        model = models[one.asset]
        if count_gap(item, model) == 0:
            return ""
        kind = one.category.replace("_", " ")
        if fitting:
            better = f"cousin {fitting[0]} has that"
        elif any(other.category == one.category and count_gap(item, other) == 0 for other in library.assets):
            better = f"another {kind} of the library has that"
        else:
            better = f"no {kind} of the library has that"
        return f"was said to have {stated}, the model has {describe_counts(model.doors, model.drawers)}; {better}"

    return entry.model_copy(
        update={"cousins": [one.model_copy(update={"differs": describe_difference(one)}) for one in entry.cousins]}
    )
