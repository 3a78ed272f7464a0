"""Command `scenes`: generated scenes as pictures from the input camera, as GLB, and side by side with the input."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from roomkin.plugins.pictures import glb
from roomkin.plugins.pictures.look import draw_preview, draw_side_by_side, estimate_look, furnish, resize_to
from roomkin.stages.cli import progress
from roomkin.stages.config.code import code_digest
from roomkin.stages.contracts import GeneratedScene, Objects, read_json, write_atomically, write_json
from roomkin.stages.contracts.extracted import read_metres, read_object_masks
from roomkin.stages.contracts.images import check_size, read_rgb
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.generation.scene_file import read_items, room_of

THUMBNAIL = 144  # pixels: width of each of its two pictures
VIEW_TEXTURE = 128  # pixels: textures of the scenes that pages let turn; chosen


def run(
    *,
    scenes: tuple[Path, ...],
    objects: Path,
    image: Path,
    library: Path,
    out: Path,
    width: int = 640,
) -> None:
    """Draw the scenes that `generate` wrote for one picture, ours or another's.

    Args:
        scenes: scene_<rank>.json files.
        objects: objects.json of the picture, with masks.png beside it; depth.npz is used if it is there.
        image: the input picture.
        library: library.json.
        out: folder; gets a .png and a .glb for each scene, a view_<rank>.glb with small textures, for pages,
            comparison.png, thumbnail.webp (input and first scene), look.json. The text chunks of every .png hold what
            its scenes were made of (seed and digests), and the digest of the code that drew them.
        width: of the pictures, pixels.
    """
    folders = AssetFolders(library)
    extracted, rgb = read_json(Objects, objects), read_rgb(image)
    check_size(image, rgb, extracted.width, extracted.height, objects.name)
    seen = rgb, read_object_masks(objects, extracted), read_metres(objects, extracted)
    pictures = [("input", resize_to(rgb, width))]
    found, origins = None, {}
    with TemporaryDirectory(prefix="acdc-sized-") as cache:
        for path in progress(scenes, "scenes drawn", len(scenes)):
            generated = read_json(GeneratedScene, path)
            origins[path.name] = generated.made.model_dump_json() if generated.made else "{}"
            items = read_items(generated, folders, Path(cache), path)
            found = found or estimate_look(extracted, seen, generated, items)
            picture = draw_preview(furnish(generated, items, found), generated, width)
            with write_atomically(out / f"{path.stem}.png") as temporary:
                Image.fromarray(picture).save(temporary, pnginfo=_text({path.name: origins[path.name]}))
            room = room_of(generated, items, found)
            glb.write(room, out / f"{path.stem}.glb")
            glb.write(room, out / f"view_{generated.rank}.glb", VIEW_TEXTURE)
            pictures.append((f"rank {generated.rank}", picture))
    with write_atomically(out / "comparison.png") as temporary:
        draw_side_by_side(pictures).save(temporary, pnginfo=_text(origins))
    with write_atomically(out / "thumbnail.webp") as temporary:
        small = [resize_to(picture, THUMBNAIL) for _, picture in pictures[:2]]
        Image.fromarray(np.hstack(small)).save(temporary, quality=70)
    if found is not None:
        write_json(out / "look.json", found)


def _text(origins: dict[str, str]) -> PngInfo:
    """Text chunks of a picture: what its scenes were made of, by file, and the code that drew them."""
    chunks = PngInfo()
    for name, text in ({"code": code_digest("roomkin.plugins.pictures.scenes")} | origins).items():
        chunks.add_text(name, text)
    return chunks
