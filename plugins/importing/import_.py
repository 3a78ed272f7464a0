"""Command `import`: say what each model of a folder is taken for, on a page; write what the library takes."""

import base64
import io
import sys
import tempfile
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import get_args

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from sapien.physx import PhysxArticulation

from roomkin.plugins.importing.discover import (
    PACK,
    PAGE,
    Given,
    describe_single_file,
    discover,
    find_unread_end,
    is_model,
    is_part,
)
from roomkin.plugins.importing.evidence import (
    UNITS,
    Evidence,
    Pack,
    complete_pack,
    find_shared_facts,
    read_pack,
    write_pack,
)
from roomkin.plugins.importing.examine import NOTES, Examined, examine_model, explain, read
from roomkin.plugins.importing.hinges import seen_points
from roomkin.plugins.importing.importers import Axis
from roomkin.plugins.importing.imports import IMPORTERS, by_suffix, in_one_line
from roomkin.plugins.importing.reach import list_unreachable
from roomkin.plugins.importing.sandbox import number_names, snake_case
from roomkin.stages.articulated.asset_folder import read_asset, read_model
from roomkin.stages.articulated.model import link_frames
from roomkin.stages.assets.snapshots import VisibilityCheck
from roomkin.stages.cli import progress
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.errors import InputError, escape_control
from roomkin.stages.contracts.files import write_text
from roomkin.stages.simulation.framing import frame_all, intrinsics_of
from roomkin.stages.simulation.loading import load_visual, remove
from roomkin.stages.simulation.rendering import RenderCamera, make_scene
from roomkin.stages.tables.text import environment

WIDTH, HEIGHT = 360, 288
OPEN = 0.6  # of its range
FROM = np.array([0.8, 0.5, 0.45])  # before it, from its left
ARROW = (200, 40, 30)


class Portraits:
    """The camera; made once, as the first picture of a scene takes seconds."""

    def __init__(self) -> None:
        self.scene = make_scene(light=(-0.65, -0.35, -1.0))
        self.intrinsics = intrinsics_of(WIDTH, HEIGHT)
        self.camera = RenderCamera(self.scene, self.intrinsics, WIDTH, HEIGHT)

    def take(self, folder: Path) -> Image.Image:
        """The picture of an asset folder."""
        asset = read_asset(folder)
        body = load_visual(self.scene, folder, 1.0)
        if isinstance(body, PhysxArticulation):
            limits = body.get_qlimits()
            body.set_qpos((limits[:, 0] + OPEN * (limits[:, 1] - limits[:, 0])).astype(np.float32))
        low, high = np.array(asset.box_min), np.array(asset.box_max)
        reach = 0.35 * float((high - low).max())
        foot = np.array([high[0] + 0.3 * reach, (low[1] + high[1]) / 2, low[2]])
        robot = read_model(folder)
        seen = seen_points(robot, robot.links, link_frames(robot, OPEN))
        opened = np.array([seen.min(axis=0), seen.max(axis=0)])
        foot[0] = max(foot[0], opened[1, 0] + 0.1 * reach)
        tip = foot + np.array([[reach, -0.3 * reach, 0], [reach, 0.3 * reach, 0]])
        view = frame_all(np.concatenate([trimesh.bounds.corners(opened), tip]), FROM, HEIGHT / WIDTH)
        picture = Image.fromarray(self.camera.render(view).rgb)
        remove(self.scene, body)
        self._arrow(picture, view, foot, reach)
        return picture

    def _arrow(self, picture: Image.Image, view: NDArray[np.float64], foot: NDArray[np.float64], reach: float) -> None:
        """Draw an arrow on the ground, towards the front."""
        outline = [(0, 0.08), (0.6, 0.08), (0.6, 0.24), (1, 0), (0.6, -0.24), (0.6, -0.08), (0, -0.08)]
        points = np.array([foot + reach * np.array([x, y, 0]) for x, y in outline])
        seen = (points - view[:3, 3]) @ view[:3, :3] @ self.intrinsics.T
        ImageDraw.Draw(picture).polygon([tuple(point) for point in (seen[:, :2] / seen[:, 2:]).tolist()], fill=ARROW)


def write_page(path: Path, source: Path, models: Sequence[Examined], pack: Pack, counts: Mapping[str, str]) -> None:
    """Write the page, which lets its reader change and save `pack`; models by folder, those that are not used last."""
    page = (
        environment("roomkin.plugins.importing")
        .get_template("import_page.html.jinja")
        .render(
            source=source.name,
            notes=NOTES,
            used=[(model, _place(model, path), _inline(model.picture)) for model in models if model.asset is not None],
            pack=pack,
            counts=counts,
            axes=get_args(Axis),
            units=UNITS,
            known=sorted(known_categories()),
            file=PACK,
            refused=[(model, _place(model, path)) for model in models if model.asset is None],
        )
    )
    write_text(path, page)


def _place(model: Examined, page: Path) -> str:
    return model.folder.relative_to(page.parent).as_posix()


def _inline(picture: Image.Image | None) -> str:
    """A picture as part of the page."""
    if picture is None:
        return ""
    buffer = io.BytesIO()
    picture.save(buffer, "WEBP")
    return "data:image/webp;base64," + base64.b64encode(buffer.getvalue()).decode()


def run(folder: Path, /, *, out: Path | None = None) -> None:
    """Look at the models of a folder; `assets.folders: [<out>]` then uses them.

    Writes <out>/<category>/<name>/ per model: a URDF in the file's own frame and unit, and asset.json; and
    <out>/pack.yaml, what they share. Correct either and run it again. <out>/index.html shows what each is taken for.

    Args:
        folder: with models, <category>/<model> or PartNet-Mobility's <number>/, or one model's file; it stays as it is.
        out: folder to write; default: imported/<name of the folder>.
    """
    out = out or Path("imported", folder.stem)
    kinds = by_suffix(IMPORTERS)
    found = models_of(folder, out, list(kinds))
    pack = read_pack(out / PACK)
    models: dict[Path, Examined] = {}
    evidence: dict[Path, Evidence] = {}
    where = {one.path: out / place for one, place in zip(found, places(found), strict=True)}
    for one in progress(found, "models read", len(found)):
        try:
            evidence[one.path] = read(one, kinds[one.path.suffix.lower()], where[one.path])
        except InputError as error:
            models[one.path] = Examined(one.path, where[one.path], doubts=[explain(error, one.path)])
            print(models[one.path].text(), flush=True)
    left = [one for one in found if one.path in evidence]
    tell = [(one.path.suffix.lower(), one.category, evidence[one.path]) for one in left]
    common, words = find_shared_facts(tell, kinds)
    pack = complete_pack(pack, common, [snake_case(one.category) for one in left])
    write_pack(out / PACK, pack, words)
    with tempfile.TemporaryDirectory() as scratch:
        portraits, visibility = Portraits(), VisibilityCheck()
        for number, one in enumerate(left):
            work, kind = Path(scratch) / str(number), one.path.suffix.lower()
            category = pack.categories[snake_case(one.category)]
            before, tells = list(models.values()), evidence[one.path]
            model = examine_model(one, kinds[kind], where[one.path], work, before, tells, pack.kinds[kind], category)
            model.doubts = [*tells.remarks, *model.doubts]
            if model.asset is not None:
                try:
                    with in_one_line(one.path):
                        visibility.check(work / model.asset.id, one.path)
                        model.picture = portraits.take(work / model.asset.id)
                        model.doubts += list_unreachable(work / model.asset.id)
                except InputError as error:
                    model.asset = None
                    model.doubts.append(explain(error, one.path))
            models[one.path] = model
            print(model.text(), flush=True)
    write_page(out / PAGE, folder, list(models.values()), pack, words)
    for line in describe_left_behind(out, set(where.values())):
        print(line)
    taken = sum(model.asset is not None for model in models.values())
    told = f"{taken} of {len(models)} models can be used: assets: {{folders: [{out}]}}. Look at {out / PAGE}"
    print(escape_control(told))
    if not taken:
        raise InputError(folder, "none of its models can be used.", "see above", code="E-MODELS-UNUSABLE")


def describe_left_behind(out: Path, now: Collection[Path]) -> Iterator[str]:
    """What lies in `out` of models that are not among those of `now`, and would be used: a line if there is any."""
    old = sorted(path.parent for path in out.glob("*/*/asset.json") if path.parent not in now)
    if old:
        what = "still has models that are gone from the source, and they are used: delete"
        yield escape_control(f"{out}: {what} {', '.join(path.relative_to(out).as_posix() for path in old)}")


def models_of(given: Path, out: Path, kinds: Sequence[str]) -> list[Given]:
    """The models that are to be looked at: those of a folder, or a file.

    Raises:
        InputError: there are none, or `out` is in the folder.
    """
    if given.is_file():
        if not is_model(given, given.resolve().parent, kinds):
            what = "is no model."
            raise InputError(given, what, f"one of {', '.join(kinds)}, or a folder of them", code="E-MODELS-NONE")
        if is_part(given, given.resolve().parent):
            what = "is a part that MJCF models include."
            raise InputError(given, what, "give the file that includes it", code="E-MJCF-PART")
        return [describe_single_file(given)]
    if not given.is_dir():
        raise InputError(given, "is not there.", "a folder of models, or a model's file", code="E-MODELS-NONE")
    inside, outside = sorted([given.resolve(), out.resolve()], key=lambda path: -len(path.parts))
    if inside.is_relative_to(outside):
        what = f"{out} and {given} lie in one another."
        raise InputError("--out", what, "give a folder beside it", code="E-OUT-INSIDE")
    if found := discover(given, kinds):
        if left_out := describe_unread(given):
            print(escape_control(f"{given}: {left_out}"), file=sys.stderr)
        return found
    parts = [path for path in given.rglob("*") if is_model(path, given, kinds)]
    if parts:
        what = f"holds no model, only parts of models ({parts[0].name} and such)."
        mend = describe_unread(given) or "give the folder or the file of the model that they are part of"
        raise InputError(given, what, mend, code="E-MODELS-NONE")
    fix = "see docs/your-models.md for the layout"
    what = f"holds no models ({', '.join(kinds)})."
    raise InputError(given, what, describe_unread(given) or fix, code="E-MODELS-NONE")


def describe_unread(folder: Path) -> str:
    """How many models there are of kinds that are not read, and what to do; empty: none."""
    found = Counter(end for path in sorted(folder.rglob("*")) if (end := find_unread_end(path, folder)))
    counts = ", ".join(f"{count} {kind}" for kind, count in sorted(found.items()))
    mend = "export them as URDF, MJCF or GLB" + (" (xacro FILE > model.urdf)" if ".xacro" in found else "")
    return f"files of kinds that are not read ({counts}): {mend}" if found else ""


def places(found: Iterable[Given]) -> list[str]:
    """<category>/<name> of every model; names that are taken get a number."""
    return number_names([f"{snake_case(one.category)}/{snake_case(one.name)}" for one in found], [])
