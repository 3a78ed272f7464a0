"""Verb `draw`: generated scenes as pictures from the input camera, as GLB, and side by side with the input."""

from pathlib import Path

from PIL import Image

from stages.articulated.asset_folder import read_asset
from stages.cli import progress
from stages.contracts import GeneratedScene, InputError, Library, Objects, atomic, read_json, write_json
from stages.contracts.extracted import read_metres, read_object_masks
from stages.contracts.images import check_size, read_rgb
from stages.contracts.objects import Mounting
from stages.generation.export import write_glb
from stages.generation.painting import furnished, look_of
from stages.generation.pictures import preview, resized_to, side_by_side
from stages.generation.placed import Placed
from stages.geometry.boxes import UprightBox
from stages.procedural.resize import resized

STANDING = Mounting(type=2)  # for scenes that do not say


def run(*, scenes: tuple[Path, ...], objects: Path, image: Path, library: Path, out: Path, width: int = 640) -> None:
    """Draw the scenes that `generate` wrote for one picture, ours or another's, in its light and colours.

    Args:
        scenes: scene_<rank>.json files.
        objects: objects.json of the picture, with masks.png beside it; depth.npz is used if it is there.
        image: the input picture.
        library: library.json.
        out: folder; gets a .png and a .glb for each scene, comparison.png, look.json, and in assets/ resized models it
            lacks.
        width: of the pictures, pixels.
    """
    folders = {entry.id: library.parent / entry.folder for entry in read_json(Library, library).assets}
    extracted, rgb = read_json(Objects, objects), read_rgb(image)
    check_size(image, rgb, extracted.width, extracted.height, objects.name)
    seen = rgb, read_object_masks(objects, extracted), read_metres(objects, extracted)
    pictures = [("input", resized_to(rgb, width))]
    look = None
    for path in progress(scenes, "scenes drawn", len(scenes)):
        made = read_json(GeneratedScene, path)
        items, sized = placed_items(made, folders, out / "assets", path)
        look = look or look_of(extracted, seen, made, items, sized)
        picture = preview(furnished(made, items, sized, look), made, width)
        with atomic(out / f"{path.stem}.png") as temporary:
            Image.fromarray(picture).save(temporary)
        write_glb(items, sized, out / f"{path.stem}.glb")
        pictures.append((f"rank {made.rank}", picture))
    with atomic(out / "comparison.png") as temporary:
        side_by_side(pictures).save(temporary)
    if look is not None:
        write_json(out / "look.json", look)


def placed_items(
    made: GeneratedScene, folders: dict[str, Path], cache: Path, path: Path
) -> tuple[list[Placed], dict[str, Path]]:
    """What stands in a scene, and by id the folders of the models at their sizes.

    Raises:
        InputError: nothing stands in it, or an asset is not in the library.
    """
    items, sized = [], {}
    for item in made.objects:
        if item.status != "ok":
            continue
        if item.asset not in folders:
            raise InputError(path, f"{item.id} is '{item.asset}', which the library does not have.")
        sized[item.id] = resized(folders[item.asset], item.size, cache)
        box = UprightBox(item.position, item.size, item.yaw)
        items.append(
            Placed(item.id, item.label, read_asset(sized[item.id]), box, item.mounting or STANDING, item.support)
        )
    if not items:
        raise InputError(path, "has no object that stands in it.")
    return items, sized
