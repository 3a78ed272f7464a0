"""What may be wrong in the scenes of later ranks, and how many different models there are."""

from typing import Any

from roomkin.plugins.report.doubts import collect_doubts
from roomkin.plugins.report.page.overview import Findings
from roomkin.stages.contracts.cousins import Cousin, Cousins, ObjectCousins, Orientation
from roomkin.stages.contracts.doubt import Doubt
from roomkin.stages.contracts.generated import GeneratedScene, PlacedObject
from roomkin.stages.contracts.objects import Box, Mounting, Objects, SceneObject

CAMERA = [[0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 1.1], [0.0, 0.0, 0.0, 1.0]]
VIEW: dict[str, Any] = {"width": 90, "height": 60, "intrinsics": [[60, 0, 45], [0, 60, 30], [0, 0, 1]]}
VIEW |= {"scene": "kitchen", "floor_from_camera": CAMERA, "walls": []}
TOWARDS = 3.141593  # its front looks at the camera


def cabinet(**changes: Any) -> SceneObject:
    box = Box(center=(4.0, 0.0, 0.4), size=(0.6, 1.0, 0.8), yaw=0.0)
    known = {"id": "cabinet_1", "label": "cabinet", "mask": 1, "points": 5000, "box": box, "pixels": (9, 9, 40, 40)}
    return SceneObject.model_validate(known | {"mounting": Mounting(type=2)} | changes)


def placed(asset: str, depth: float, back: float = 4.3, **changes: Any) -> PlacedObject:
    """A model whose rear stands `back` metres from the camera."""
    known = {"id": "cabinet_1", "label": "cabinet", "asset": asset, "category": "cabinet", "yaw": TOWARDS}
    known |= {"size": (depth, 1.0, 0.8), "position": (back - depth / 2, 0.0, 0.4)}
    return PlacedObject.model_validate(known | changes)


def entry() -> ObjectCousins:
    turn = Orientation(yaw=0.0, distance=0.0)
    told: dict[str, Any] = {"orientation": turn, "orientations": [turn], "votes": None}
    cousins = [Cousin(rank=1, asset="a", category="cabinet", distance=0.0, **told)]
    return ObjectCousins(id="cabinet_1", label="cabinet", cousins=cousins)


def found(item: SceneObject, *things: PlacedObject) -> Findings:
    scenes = [GeneratedScene(variant="default", rank=rank, objects=[one], **VIEW) for rank, one in enumerate(things, 1)]
    return Findings(Objects(objects=[item], **VIEW), Cousins.model_construct(objects=[entry()]), scenes)


def told(item: SceneObject, thing: PlacedObject) -> list[str]:
    return [one.what for one in collect_doubts(entry(), item, thing, Objects(objects=[item], **VIEW))]


def test_what_reaches_before_the_front_that_is_seen_is_doubted() -> None:
    assert told(cabinet(), placed("a", 1.5)) == ["reaches 90 cm before the front that the picture shows"]
    assert told(cabinet(), placed("a", 0.7)) == [], "as much as boxes are off"
    assert told(cabinet(), placed("a", 1.5, back=5.2)) == [], "it is deeper to its rear, which nobody sees"
    assert told(cabinet(), placed("a", 1.5, yaw=0.0)) == [], "its front looks away"
    assert told(cabinet(told=["size"]), placed("a", 1.5)) == [], "a person says so"


def test_what_the_border_cuts_is_doubted_where_no_fit_says_how_sure_it_is() -> None:
    cut = cabinet(pixels=(0, 9, 40, 40))
    assert told(cut, placed("a", 0.6)) == ["cut off by the picture's border"]
    assert told(cut, placed("a", 0.6, size_spread=(0.02, 0.02, 0.02))) == []


def test_that_no_model_fits_is_doubted_until_a_person_chooses_one() -> None:
    none = entry()
    first = none.cousins[0].model_copy(update={"score": -2.0, "terms": {"priors": 2.0}})
    none = none.model_copy(update={"cousins": [first, *none.cousins[1:]]})
    item, thing = cabinet(), placed("a", 0.6)
    view = Objects(objects=[item], **VIEW)
    (doubt,) = collect_doubts(none, item, thing, view)
    assert doubt.what.startswith("no model fits what is seen of it") and "call it otherwise" in str(doubt)
    assert collect_doubts(none, item, thing.model_copy(update={"chosen": True}), view) == []


def test_what_was_guessed_in_a_drawing_is_doubted_until_a_person_says_its_size() -> None:
    guessed = Doubt(cause="size", what="depth is guessed")
    moved = Doubt(cause="place", what="11 % nearer")
    assert told(cabinet(doubts=[guessed, moved]), placed("a", 0.6)) == ["depth is guessed", "11 % nearer"]
    assert told(cabinet(doubts=[guessed, moved], told=["size"]), placed("a", 0.6)) == ["11 % nearer"]


def test_later_ranks_tell_what_the_first_does_not() -> None:
    odd = [Doubt(cause="affordance", what="has 1 drawer")]
    run = found(cabinet(), placed("a", 0.6), placed("a", 0.6), placed("b", 0.6, doubts=odd))
    assert [[doubt.what for _, doubt in run.list_further_doubts(scene)] for scene in run.scenes] == [
        [],
        [],
        ["has 1 drawer"],
    ]
    assert [run.count_new_models(scene) for scene in run.scenes] == [1, 0, 1] and run.distinct == {"cabinet_1": 2}
