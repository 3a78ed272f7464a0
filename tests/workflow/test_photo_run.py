"""A picture by tiny networks of random weights, saved and loaded as real ones are: the whole way to its page."""

import json
import shutil
from pathlib import Path

from PIL import Image

from roomkin.stages.contracts import Annotations, Camera, Library, Objects, read_json
from roomkin.stages.contracts.library_folder import SceneShards, holds
from tests.unit.tiny_networks import save_all
from tests.workflow.workspace import MICRO, ROOT, copy, dry_run, planned, snakemake


def test_a_picture_goes_all_the_way_to_its_page(run: Path, tmp_path: Path) -> None:
    folder = copy(run, tmp_path / "run")
    for drawn in ("assets/snapshots", "matching/features"):
        shutil.rmtree(folder / "results" / drawn)
    with Image.open(ROOT / "tests/data/photographed_room/rgb.jpg") as picture:
        picture.reduce(2).save(folder / "my kitchen.jpg")
    options = save_all(folder / "weights") | {"labels": ["cabinet", "mug", "coffee table"]}
    (folder / "mine.yaml").write_text(json.dumps({"perception": options}))
    photo = ("photo", "--configfile", MICRO[1], "mine.yaml", "--config", "image=my kitchen.jpg")
    done = snakemake(folder, *photo)
    assert done.returncode == 0, done.stdout[-4000:]
    assert "library" not in planned(done.stdout)
    results = folder / "results"
    named = read_json(SceneShards, results / "matching/default/my_kitchen-32bc6e/shards.json").shards
    assert {path.stem for path in (results / "assets/snapshots").iterdir()} == {f"shard_{name}" for name in named}
    whole = read_json(Library, results / "assets/library/library.json")
    assert any(not any(holds(name, entry) for name in named) for entry in whole.assets)  # not all of it is drawn
    said = read_json(Annotations, results / "scenes/my_kitchen-32bc6e/frame/annotations.json")
    assert {item.label for item in said.objects} <= {"cabinet", "mug", "coffee table"}
    camera = read_json(Camera, results / "scenes/my_kitchen-32bc6e/frame/camera.json")
    objects = read_json(Objects, results / "extraction/my_kitchen-32bc6e/objects.json")
    assert len(objects.objects) == len(said.objects)
    page = (results / "report/scenes/my_kitchen-32bc6e.html").read_text()
    assert camera.note and camera.note in page and objects.objects[0].id.replace("_", " ") in page
    assert "Nothing to be done" in dry_run(folder, *photo).stdout
