"""One model in the place of one object: turned, sized and mounted; not yet on its support (paper A.3, A.7)."""

from dataclasses import dataclass, field, replace

import numpy as np

from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts import Asset, read_json
from roomkin.stages.contracts.cousins import Cousin
from roomkin.stages.contracts.doubt import DoubtKind
from roomkin.stages.contracts.errors import ObjectError
from roomkin.stages.contracts.objects import Mounting
from roomkin.stages.generation.inputs import Inputs, MatchedObject
from roomkin.stages.generation.mounting import PLACE_TOLERANCE, fit_stated_box, move_out_of_walls
from roomkin.stages.generation.placed import FLOOR, Placed
from roomkin.stages.generation.sizing import size
from roomkin.stages.generation.turning import find_yaw
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
