"""What a person corrects of found boxes, masks and labels: `corrections.json`, and the masks that come of it."""

from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from stages.contracts import Annotations
from stages.contracts.files import Contract, Document
from stages.contracts.objects import object_ids
from stages.contracts.scenes import Annotation, Held
from stages.contracts.types import Id, MaskValue, Panels, Side, Text, check_unique
from stages.extraction.by_hand.paint import polygon
from stages.extraction.by_hand.project import Pixel
from stages.geometry.masks import pixel_bounds

CORRECTIONS = "corrections.json"
FLOOR, WALL = "floor", "wall"
ROOM = (FLOOR, WALL)
AROUND = 0.25  # share of a box by which the picture around it is looked at, to tell what is behind
LONGEST = 320  # pixels at which a box's content is cut out
ROUNDS = 4
LEAST = 0.05  # share of its box that a thing fills; what is found to be smaller is not believed


class Hanging(Contract):
    """How a thing is held (paper A.2), the walls by their ids here."""

    type: Literal[1, 2, 3]
    walls: list[Id] = []


class Region(Contract):
    """A thing, the floor or a wall: what was found, unless it has a box or an outline of its own."""

    id: Id
    label: str = Field("", max_length=1000, description="floor and wall mean what they say")
    found: MaskValue | None = Field(None, description="its value in the masks that were found")
    box: tuple[Pixel, Pixel] | None = Field(None, description="opposite corners; its content is cut out of the picture")
    outline: list[Pixel] = Field([], max_length=1000, description="the pixels that show it")
    articulated: bool = False
    doors: Panels = 0
    drawers: Panels = 0
    mounting: Hanging | None = Field(None, description="null: geometry tells")

    @model_validator(mode="after")
    def _somewhere(self) -> "Region":
        if self.found is None and self.box is None and len(self.outline) < 3:
            raise ValueError("neither found, nor with a box or an outline")
        return self

    @property
    def drawn(self) -> bool:
        """Whether it is not as it was found."""
        return self.box is not None or len(self.outline) > 2


class Corrections(Document):
    """All that is in a picture, as a person sees it."""

    picture: Text = Field(description="the folder with what was found, for people")
    width: Side
    height: Side
    objects: list[Region] = Field([], max_length=500, description="floor and walls among them")

    @model_validator(mode="after")
    def _once(self) -> "Corrections":
        check_unique("ids", [item.id for item in self.objects])
        check_unique("found", [item.found for item in self.objects if item.found is not None])
        return self


def as_found(name: str, masks: NDArray[np.uint16], annotations: Annotations) -> Corrections:
    """An input folder's content, with nothing corrected."""
    rooms = [(value, FLOOR) for value in [annotations.floor] if value is not None]
    rooms += [(value, WALL) for value in annotations.walls]
    labels = [*(item.label for item in annotations.objects), *(label for _, label in rooms)]
    ids = object_ids(labels)
    by_value = dict(
        zip([*(item.mask for item in annotations.objects), *(value for value, _ in rooms)], ids, strict=True)
    )
    regions = []
    for item in annotations.objects:
        held = item.mounting and Hanging(type=item.mounting.type, walls=[by_value[v] for v in item.mounting.walls])
        said = item.model_dump(include={"label", "articulated", "doors", "drawers"})
        regions.append(Region(id=by_value[item.mask], found=item.mask, mounting=held, **said))
    regions += [Region(id=by_value[value], found=value, label=label) for value, label in rooms]
    shown = set(np.unique(masks).tolist())
    height, width = masks.shape
    return Corrections(
        picture=name, width=width, height=height, objects=[item for item in regions if item.found in shown]
    )


class Cutter:
    """Cuts things out of a picture by their boxes (GrabCut), each box once."""

    def __init__(self, rgb: NDArray[np.uint8]) -> None:
        self.rgb = rgb
        self._done: dict[tuple[int, int, int, int], NDArray[np.bool_]] = {}

    def __call__(self, box: tuple[int, int, int, int]) -> NDArray[np.bool_]:
        """Mask (H, W) of what the box x0, y0, x1, y1 (exclusive) shows."""
        if box not in self._done:
            self._done[box] = self._cut(*box)
        return self._done[box]

    def _cut(self, x0: int, y0: int, x1: int, y1: int) -> NDArray[np.bool_]:
        height, width = self.rgb.shape[:2]
        mask = np.zeros((height, width), dtype=bool)
        margin = 2 + round(AROUND * max(x1 - x0, y1 - y0))
        left, top = max(0, x0 - margin), max(0, y0 - margin)
        part = self.rgb[top : y1 + margin, left : x1 + margin]
        scale = min(1.0, LONGEST / max(part.shape[:2]))
        size = tuple(max(8, round(side * scale)) for side in part.shape[1::-1])
        small = np.ascontiguousarray(cv2.resize(part, size, interpolation=cv2.INTER_AREA))
        zoom = size[0] / part.shape[1], size[1] / part.shape[0]
        low = round((x0 - left) * zoom[0]), round((y0 - top) * zoom[1])
        high = round((x1 - left) * zoom[0]), round((y1 - top) * zoom[1])
        kinds = np.full(small.shape[:2], cv2.GC_BGD, dtype=np.uint8)
        kinds[low[1] : high[1], low[0] : high[0]] = cv2.GC_PR_FGD
        box = np.s_[y0:y1, x0:x1]
        if (kinds == cv2.GC_BGD).any() and (kinds == cv2.GC_PR_FGD).any():
            cv2.setRNGSeed(0)
            background, foreground = np.zeros((1, 65)), np.zeros((1, 65))
            cv2.grabCut(small, kinds, (0, 0, 0, 0), background, foreground, ROUNDS, cv2.GC_INIT_WITH_MASK)
        seen = ((kinds == cv2.GC_FGD) | (kinds == cv2.GC_PR_FGD)).astype(np.uint8)
        whole = cv2.resize(seen, part.shape[1::-1], interpolation=cv2.INTER_NEAREST) > 0
        mask[top : top + part.shape[0], left : left + part.shape[1]] = whole
        if mask[box].sum() < LEAST * (x1 - x0) * (y1 - y0):
            mask[box] = True
        return mask


def pixel_box(box: tuple[Pixel, Pixel], width: int, height: int) -> tuple[int, int, int, int]:
    """Whole pixels of a drawn box, inside the picture, at least one."""
    (xa, ya), (xb, yb) = box
    x0, x1 = (int(np.clip(round(x), 0, width)) for x in sorted((xa, xb)))
    y0, y1 = (int(np.clip(round(y), 0, height)) for y in sorted((ya, yb)))
    x0, y0 = min(x0, width - 1), min(y0, height - 1)
    return x0, y0, max(x1, x0 + 1), max(y1, y0 + 1)


def painted(drawing: Corrections, found: NDArray[np.uint16], cut: Cutter) -> tuple[NDArray[np.uint16], dict[str, int]]:
    """Masks (H, W) and every region's value there; floor and walls lie below things, what was found below the drawn."""
    masks = np.zeros((drawing.height, drawing.width), dtype=np.uint16)
    values: dict[str, int] = {}
    free = int(found.max()) + 1
    for item in drawing.objects:
        values[item.id] = free if item.found is None else item.found
        free += item.found is None
    for item in sorted(drawing.objects, key=lambda item: (item.label not in ROOM, item.drawn)):
        if len(item.outline) > 2:
            shown = polygon(item.outline, masks.shape)
        elif item.box is not None:
            shown = cut(pixel_box(item.box, drawing.width, drawing.height))
        else:
            shown = found == item.found
        masks[shown] = values[item.id]
    return masks, values


def corrected(
    drawing: Corrections, masks: NDArray[np.uint16], values: dict[str, int], given: Annotations
) -> tuple[NDArray[np.uint16], Annotations | None, list[str]]:
    """masks.png and annotations.json of a drawing, and lines on what was left out; None: there is no object."""
    shown = set(np.unique(masks).tolist())
    seen = [item for item in drawing.objects if values[item.id] in shown]
    notes = [f"{item.label or item.id}: no pixel shows it, left out" for item in drawing.objects if item not in seen]
    floors = [values[item.id] for item in seen if item.label == FLOOR]
    masks = np.where(np.isin(masks, floors), floors[0], masks).astype(np.uint16) if floors else masks
    walls = {item.id: values[item.id] for item in seen if item.label == WALL}
    known = {item.mask: item for item in given.objects}
    objects = []
    for item in (entry for entry in seen if entry.label not in ROOM):
        held = None
        if item.mounting is not None and all(name in walls for name in item.mounting.walls):
            held = Held(type=item.mounting.type, walls=[walls[name] for name in item.mounting.walls])
        elif item.mounting is not None:
            notes.append(f"{item.label or item.id}: its wall is gone, mounting by geometry")
        before = known.get(item.found or 0)
        keep = before is not None and not item.drawn
        objects.append(
            Annotation(
                mask=values[item.id],
                label=item.label.strip() or "object",
                articulated=item.articulated or item.doors + item.drawers > 0,
                doors=item.doors,
                drawers=item.drawers,
                mounting=held,
                box=before.box if before and keep else None,
                guessed=bool(before and keep and before.guessed),
                front=before.front if before and keep else None,
            )
        )
    if not objects:
        return masks, None, notes
    return masks, Annotations(objects=objects, floor=floors[0] if floors else None, walls=[*walls.values()]), notes


def bounds(mask: NDArray[np.bool_]) -> tuple[Pixel, Pixel] | None:
    """Opposite corners of a mask's pixels."""
    if not mask.any():
        return None
    x0, y0, x1, y1 = pixel_bounds(mask)
    return (x0, y0), (x1, y1)
