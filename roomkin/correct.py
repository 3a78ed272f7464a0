"""Command `correct`: the page on which a scene is put right."""

from pathlib import Path

from roomkin.stages.config.inputs import describe_missing, scene_of_folder
from roomkin.stages.config.packages import load_command
from roomkin.stages.config.pictures import name_scene
from roomkin.stages.contracts.errors import InputError, suggest_nearest
from roomkin.stages.contracts.hand import is_drawn


def run(
    picture: Path | None = None, /, *, results: Path = Path("results"), choose: str | None = None, browser: bool = True
) -> None:
    """Open the page of a picture: what was found in it, beside its scene; or, without depth, what was drawn into it.

    What you say there is kept, and *Make it again* makes the scene anew. `roomkin picture` ends with the same page.

    Args:
        picture: the picture's file or its scene's name, as `roomkin picture` had it; or an input folder. It may be left
            out where there is one.
        results: what the last run left.
        choose: the object of the scene that is chosen when the page opens, e.g. cabinet_1.
        browser: open the page; else its address is only printed.
    """
    places = [path for place in ("scenes/*/input", "scenes/*/frame", "photo/*") for path in sorted(results.glob(place))]
    made = {scene_of_folder(folder): folder for folder in places if not describe_missing(folder)}
    if picture is None:
        scene = next(iter(made)) if len(made) == 1 else ""
    elif picture.is_dir():
        scene = scene_of_folder(picture)
        made[scene] = picture
    else:
        scene = name_scene(picture)
        scene = f"{scene}-photo" if f"{scene}-photo" in made else scene  # a room of ours is called as the picture
    if scene not in made:
        what = f"has no scene of {picture}." if picture else "has several scenes." if made else "has no scene."
        mend = suggest_nearest(scene, made) if made else "roomkin picture kitchen.jpg"
        raise InputError(results, what, mend, code="E-OBJECT-MISSING")
    open_page, folder = load_command("annotator", "annotate"), made[scene]
    if is_drawn(folder) and choose is None:
        image = picture if picture is not None and picture.is_file() else folder / "rgb.png"
        open_page(image, out=folder, results=results, browser=browser)
    else:
        open_page(folder, results=results, scene=scene, choose=choose, browser=browser)
