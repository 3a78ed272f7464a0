"""Which cousin represents an object, a person's choice first, and it in its place: turned, sized, mounted (A.3)."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts import Asset, read_json
from roomkin.stages.contracts.cousins import Cousin
from roomkin.stages.contracts.doubt import DoubtKind
from roomkin.stages.contracts.errors import ObjectError
from roomkin.stages.contracts.objects import Mounting
from roomkin.stages.contracts.types import FLOOR
from roomkin.stages.generation.inputs import Inputs, MatchedObject
from roomkin.stages.generation.placed import Placed, paint, resize
from roomkin.stages.generation.sizing import size
from roomkin.stages.generation.turning import PLACE_TOLERANCE, find_yaw, fit_stated_box, move_out_of_walls
from roomkin.stages.geometry.boxes import THINNEST, UprightBox


@dataclass
class Places:
    """Cousins in the places of their objects, each found once for the scenes of all ranks."""

    inputs: Inputs
    options: GenerationConfig
    _found: dict[tuple[str, str], Placed] = field(default_factory=dict)  # by the ids of an object and of a model

    def find(self, one: MatchedObject, cousin: Cousin) -> Placed:
        """A cousin in the place of an object; see `place`."""
        key = one.object.id, cousin.asset
        if key not in self._found:
            self._found[key] = place(one, cousin, self.inputs, self.options)
        return self._found[key]


def place(one: MatchedObject, cousin: Cousin, inputs: Inputs, options: GenerationConfig) -> Placed:
    """A cousin with the object's yaw, extents and position.

    The paper takes extents as they are measured. Here the model is fitted to the picture, and what the camera could not
    see comes from its own proportions and the sizes of its category (`sizes`).

    Raises:
        ObjectError: the library lacks it.
    """
    item, scene = one.object, inputs.objects
    if cousin.asset not in inputs.folders:
        raise ObjectError("--library", f"asset '{cousin.asset}' is not in the library", code="E-LIBRARY-ASSET")
    folder = inputs.folders[cousin.asset]
    asset = read_json(Asset, folder / "asset.json")
    assert item.box is not None
    box, mounting = UprightBox(item.box.center, item.box.size, item.box.yaw), item.mounting or Mounting(type=2)
    camera = np.array(scene.floor_from_camera)[:3, 3]
    walls = {wall.id: wall for wall in scene.walls}
    touched = [walls[name] for name in mounting.walls if name in walls and mounting.type != 2]  # the dominant one first
    is_round = options.sizes == "fitted" and asset.symmetry == "full"
    reached = touched if reaches_walls(mounting, box, is_round) else []
    rank = next((each.rank for each in one.cousins if each.asset == cousin.asset), None)
    support = item.measured_support or FLOOR
    placed = Placed(item.id, item.label, asset, folder, box, mounting, support, cousin=rank)
    if cousin.differs:
        placed = replace(placed, doubts=(DoubtKind.OPENINGS.of(what=cousin.differs),))
    category = inputs.categories.get(asset.category)
    yaw = find_yaw(cousin, box, one.cloud, camera, touched, asset.articulated, options, category)
    if item.whole:
        placed = placed.change_box("as the input tells it", fit_stated_box(box, yaw, reached))
    else:
        placed = size(placed, yaw, one, scene, category, reached, options)
    if not reached:
        placed = placed.change_box("out of walls", move_out_of_walls(placed.box, scene.walls))
    return placed.change_box("least extent", replace(placed.box, size=np.maximum(placed.box.size, THINNEST)))


def reaches_walls(mounting: Mounting, box: UprightBox, is_round: bool) -> bool:
    """Whether a model is extended to the walls that the object touches. Not if it stands on furniture or is as deep
    as it is wide."""
    return mounting.type != 3 or not (is_round or box.bottom > PLACE_TOLERANCE)


SAME_MEANING = 0.05  # of distances of labels: a lamp is a table lamp (0.14) or a floor lamp (0.15); chosen


def choose_models(inputs: Inputs, rank: int, places: Places) -> tuple[list[Placed], dict[str, str]]:
    """The cousins of one rank: turned, sized and mounted where their objects are; and why others cannot be, by id.

    Raises:
        InputError: a file of the library is broken: no fault of the object.
    """
    items, failed, models = list[Placed](), dict[str, str](), dict[int, str]()
    for one in inputs.matched:
        try:
            item = choose(one, rank, models, places)
            models[one.object.mask] = item.asset.id
            items.append(resize(paint(item, one.color)))
        except ObjectError as error:
            failed[one.object.id] = error.what
    return items, failed


def choose(one: MatchedObject, rank: int, models: Mapping[int, str], places: Places) -> Placed:
    """The model for an object in the scene of a rank: the one that a person chose, else the cousin of that rank that
    fits.

    Args:
        models: asset by mask value, of what stands in this scene already.

    Raises:
        ObjectError: the object has no cousin left, or the library lacks it.
    """
    stated, name = one.correction, one.object.id
    if one.failed:
        raise ObjectError(name, one.failed, code="E-OBJECT-FAILED")
    if stated.like is not None and stated.like in models:
        return take_stated(models[stated.like], one, places, "the model of what it is like, as a person says")
    if stated.model is not None and (stated.pinned or rank == 1):
        return take_stated(stated.model, one, places, "chosen by a person")
    cousins = [cousin for cousin in one.cousins if cousin.asset not in {stated.model, *stated.banned}]
    if not cousins:
        raise ObjectError(name, "all of its cousins are banned", code="E-COUSINS-BANNED")
    rank -= stated.model is not None and rank > 1
    categories = find_synonyms(one.distances, cousins[0].category)
    placed = (places.find(one, cousin) for cousin in cousins)
    return choose_by_rank(placed, rank, places.options.max_stretch, categories)


def take_stated(asset: str, one: MatchedObject, places: Places, why: str) -> Placed:
    """Any model: as matching turned it, or as it turned the nearest cousin, for all models face +x."""
    found = next((cousin for cousin in one.cousins if cousin.asset == asset), None)
    placed = places.find(one, found or one.cousins[0].model_copy(update={"asset": asset}))
    return replace(placed, chosen=True, doubts=(), steps=(why, *placed.steps))


def find_synonyms(distances: Mapping[str, float], category: str) -> set[str]:
    """The categories as near to a label as a given one, which is among them; `distances`: from the label to each."""
    limit = distances.get(category, -np.inf) + SAME_MEANING
    return {category, *(name for name, far in distances.items() if far <= limit)}


def choose_by_rank(placed: Iterable[Placed], rank: int, limit: float | None, categories: Collection[str]) -> Placed:
    """The cousin that stands in the scene of a rank: of those that fit, best first, the one of that rank.

    Cousins of the object's category with the doors and drawers of the nearest cousin come first: label and counts are
    stated, a size is only measured. Then come those with other doors and drawers. Other categories are never used. If
    fewer fit, the last that fits is used again; if none of the first group fits, the one that is stretched least. Its
    `steps` say so.

    Args:
        placed: the cousins at their places, best first.
        limit: how far they may be stretched; None: they all fit.
        categories: that the object's label means, that of the nearest among them.
    """
    same_fronts: list[Placed] = []
    other_fronts: list[Placed] = []
    passed: list[tuple[float, Placed]] = []
    nearest: Asset | None = None
    for one in placed:
        nearest, times = nearest or one.asset, one.stretch
        if one.asset.category not in categories:
            continue
        same = (one.asset.doors, one.asset.drawers) == (nearest.doors, nearest.drawers)
        if limit is None or times <= limit:
            (same_fronts if same else other_fronts).append(one)
        elif same:
            passed.append((times, one))
        if len(same_fronts) == rank:
            break
    if not same_fronts:
        least = min(passed, key=lambda one: one[0])
        passed.remove(least)
        same_fronts = [replace(least[1], doubts=(*least[1].doubts, DoubtKind.STRETCHED.of(times=least[0])))]
    fitting = same_fronts + other_fronts
    one = fitting[min(rank, len(fitting)) - 1]
    steps: tuple[str, ...] = ()
    if len(fitting) < rank:
        steps = (f"only {len(fitting)} of its cousins have its size: the last of them stands here again",)
    over = ", ".join(f"{each.cousin} ({times:.1f})" for times, each in passed)
    if over:
        steps = (*steps, f"passed over, for so many times they would be stretched: cousins {over}")
    return replace(one, steps=(*steps, *one.steps))
