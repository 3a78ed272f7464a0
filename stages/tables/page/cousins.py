"""Every object of a room as a picture, beside the pictures of its cousins."""

from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from stages.contracts.cousins import Cousins, ObjectCousins
from stages.contracts.objects import SceneObject
from stages.contracts.snapshot_pictures import Snapshots
from stages.tables.page.pictures import Album, Picture, load
from stages.tables.page.stories import Evidence, Story, story

MOUNTING = {1: "on the wall", 2: "stands free", 3: "stands, touches a wall"}
SHOWN = 5  # cousins of an object with a picture
SIZE = 132  # pixels of a picture
LARGEST = 2000  # pixels across the input from which objects are cut


@dataclass(frozen=True)
class Relative:
    """A cousin: `part` is its distance as a part of the largest one shown, for its bar."""

    rank: int
    asset: str
    distance: float
    part: float
    picture: Picture | None


@dataclass(frozen=True)
class Match:
    """One object of the image and the cousins found for it; `more` cousins have no picture."""

    id: str
    about: str
    decided_by: str
    picture: Picture | None
    cousins: list[Relative]
    more: int
    story: Story | None


def matches(
    found: Cousins, evidence: Evidence | None, image: Path | None, album: Album, snapshots: Snapshots
) -> list[Match]:
    """The objects that have cousins, in the order of matching."""
    objects = evidence.objects if evidence else None
    seen = {item.id: item for item in objects.objects} if objects else {}
    whole = load(image, LARGEST) if image and objects else None
    made = []
    for entry in found.objects:
        if entry.status == "ok":
            item = seen.get(entry.id)
            crop = _crop(whole, item, objects.width) if whole and item and objects else None
            told = story(entry, item, evidence, album, snapshots) if evidence and item else None
            made.append(_match(entry, item, album.put(crop, f"{entry.id} in the input", SIZE) if crop else None,
                               album, snapshots, told))  # fmt: skip
    return made


def _match(
    entry: ObjectCousins,
    item: SceneObject | None,
    crop: Picture | None,
    album: Album,
    snapshots: Snapshots,
    told: Story | None,
) -> Match:
    deciders = dict.fromkeys(name for name in (entry.decided_by, entry.orientation_decided_by) if name)
    shown = entry.cousins[:SHOWN]
    largest = max((cousin.distance for cousin in shown), default=0.0) or 1.0
    relatives = []
    for cousin in shown:
        view = snapshots.picture(cousin.asset, cousin.orientation.yaw)
        alt = f"{cousin.asset}, cousin {cousin.rank} of {entry.id}"
        picture = album.put(view, alt, SIZE) if view else None
        relatives.append(Relative(cousin.rank, cousin.asset, cousin.distance, cousin.distance / largest, picture))
    return Match(entry.id, _about(item), " / ".join(deciders), crop, relatives, len(entry.cousins) - len(shown), told)


def _crop(whole: Image.Image, item: SceneObject, width: int) -> Image.Image | None:
    """The object's part of the input; `width` is that of the picture in which its pixels count."""
    if item.pixels is None:
        return None
    scale = whole.width / width
    x0, y0, x1, y1 = (scale * edge for edge in item.pixels)
    margin = 0.08 * max(x1 - x0, y1 - y0)
    left, top = max(0, round(x0 - margin)), max(0, round(y0 - margin))
    right, bottom = min(whole.width, round(x1 + margin)), min(whole.height, round(y1 + margin))
    return whole.crop((left, top, right, bottom)) if right > left and bottom > top else None


def _about(item: SceneObject | None) -> str:
    """'on the wall, 2 doors, 0.60 × 0.40 × 0.90 m'."""
    if item is None:
        return ""
    parts = [MOUNTING[item.mounting.type]] if item.mounting else []
    for count, noun in ((item.doors, "door"), (item.drawers, "drawer")):
        parts += [f"{count} {noun}{'s' if count > 1 else ''}"] if count else []
    if item.box:
        parts.append(" × ".join(f"{length:.2f}" for length in item.box.size) + " m")
    return ", ".join(parts)
