"""Every kind of implementation from a package outside the checkout: that of docs/extending.md, through the commands."""

import importlib
import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
import trimesh
import yaml

from roomkin.plugins.importing.own import run as own
from roomkin.plugins.importing.shards import own_shards
from roomkin.plugins.scenes.layout import arrange
from roomkin.plugins.scenes.recipe import read_room, room_files
from roomkin.stages.config import code
from roomkin.stages.config.assets import AssetsConfig
from roomkin.stages.config.model import load, merge_mappings, with_defaults
from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.contracts import InputError, Library, LibraryPart, Objects, read_json, write_json
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.contracts.trained import read_config
from roomkin.stages.demonstrations.attempt import Recorder
from roomkin.stages.extraction.extract import run as extract
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.plugins import KINDS, find, list_available
from roomkin.stages.plugins import load as implementation
from roomkin.stages.policies.base import load_network
from roomkin.stages.tasks.api import EnvWrapper
from roomkin.stages.tasks.base_placement import CLOSED
from roomkin.stages.training import state
from roomkin.stages.training.state import Logbook
from roomkin.stages.training.train import run as train
from tests.refusals import refused
from tests.toy_reach import write_store
from tests.unit.demo_assets import cabinet
from tests.unit.matching_data import MODELS, World
from tests.unit.synthetic_room import write_room
from tests.workflow.workspace import ROOT, make, snakemake

DEFAULT = with_defaults({})
OURS = {"mesh_files", "makers", "depth_sources", "captioners"}
YOURS = [kind for kind in KINDS if kind not in OURS]  # those are found among ours alone
BLOCK = re.compile(r"```(?:python|yaml)\n# (my_package/\S+)\n(.*?)```", re.DOTALL)


def write_package(folder: Path) -> Path:
    """The package that the page shows, below `folder`."""
    for name, text in BLOCK.findall((ROOT / "docs/extending.md").read_text()):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder / "my_package"


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder = tmp_path_factory.mktemp("outside")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        yield write_package(folder)
    for name in [name for name in sys.modules if name.split(".")[0] == "my_package"]:
        del sys.modules[name]


def test_the_page_has_one_of_every_kind(package: Path) -> None:
    yours = {kind: set(list_available(kind, ["my_package"])) - set(list_available(kind)) for kind in YOURS}
    assert yours.pop("tasks") == {"touch", "shut"}
    assert all(len(names) == 1 for names in yours.values()), yours
    assert "my_package" not in sys.modules  # found without being imported
    table = (ROOT / "docs/extending.md").read_text()
    shown = {"tasks": {"touch"}} | yours
    assert all(f"`{kind}/{name}" in table for kind, names in shown.items() for name in names)


def test_every_config_line_of_the_page_is_one(package: Path) -> None:
    page = (ROOT / "docs/extending.md").read_text()
    lines = re.findall(r"^\| .* \| `(\w+: \{.*?\})`[^|]*\|$", page, re.MULTILINE)
    lines += [text for text in re.findall(r"```yaml\n(.*?)```", page, re.DOTALL) if not text.startswith("#")]
    assert len(lines) == len(YOURS) + 1  # a skill is named by its task; plugins, and options of an own one
    base = merge_mappings(DEFAULT, {"plugins": ["my_package"], "experiment": {"targets": {"door": None}}})
    for line in lines:
        assert "my_package" in load(merge_mappings(base, yaml.safe_load(line))).model_dump_json()


def test_names_are_made_loadable_and_wrong_ones_are_explained(package: Path) -> None:
    training = {"configs": {"mine": {"policy": "mean_action"}}}
    experiment = {
        "variants": {"default": {"model_selection": "by_height"}},
        "rooms": ["attic"],
        "targets": {},
        "policies": {"mine": {}},
    }
    config = load(
        {
            "plugins": ["my_package"],
            "matching": {"encoder": "colors", "kwargs": {"colors": {"grid": 8}}},
            "assets": {"importers": ["urdf", "off"]},
            "experiment": experiment,
            "training": training,
        }
    )
    assert config.matching.encoder == "my_package.encoders.colors" and config.matching.search == "torch"
    assert config.assets.importers == ["urdf", "my_package.importers.off"]
    assert config.matching_of("default").model_selection == "my_package.judges.by_height"
    assert config.training.configs["mine"].policy == "my_package.policies.mean_action"
    for wrong, kind, named in (
        ({"matching": {"encoder": "color"}}, "E-PLUGIN-UNKNOWN", "did you mean 'colors'?"),
        ({"matching": {"kwargs": {"paints": {}}}}, "E-PLUGIN-UNKNOWN", "matching.kwargs.paints"),
        ({"matching": {"kwargs": {"colors": {"gird": 8}}}}, "E-CONFIG-KEY", "did you mean 'grid'?"),
        (
            {"training": {"configs": {"lite": {"policy": "mean_action", "kwargs": {"gain": 2}}}}},
            "E-CONFIG-KEY",
            "no options",
        ),
        ({"plugins": ["your_package"]}, "E-PLUGIN-PACKAGE", "your_package"),
    ):
        with refused(kind) as caught:
            load({"plugins": ["my_package"], "experiment": {"targets": {}, "policies": {"lite": {}}}} | wrong)
        assert named in str(caught.value)


def test_a_module_that_is_not_there_or_defines_nothing_is_one_line(package: Path) -> None:
    with refused("E-PLUGIN-PACKAGE"):
        implementation("encoders", "my_package.encoders.color")
    with refused("E-PLUGIN-SYMBOL"):
        implementation("encoders", "my_package.judges.by_height")
    (package / "judges" / "broken.py").write_text("import nothing_of_that_name\nclass Judge: ...")
    with pytest.raises(ModuleNotFoundError, match="nothing_of_that_name"):
        implementation("judges", "my_package.judges.broken")
    (package / "judges" / "broken.py").unlink()


def test_a_name_that_is_taken_is_refused(package: Path) -> None:
    (package / "searches" / "torch.py").write_text("def search(): ...")
    try:
        with refused("E-PLUGIN-TWICE"):
            find("searches", "torch", ["my_package"])
    finally:
        (package / "searches" / "torch.py").unlink()


def test_an_edit_of_a_plugin_or_of_what_it_imports_changes_the_digest(
    package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(code, "ROOTS", dict(code.ROOTS))
    code.cover(["my_package"])

    def digest() -> str:
        code.forget()
        return code.code_digest("roomkin.stages.matching.match", "my_package.encoders.colors")

    seen = {digest()}
    encoder, helper = package / "encoders" / "colors.py", package / "helper.py"
    text = encoder.read_text()
    for path, content in ((encoder, "from ..helper import x\n" + text), (helper, "x = 1"), (helper, "x = 2")):
        path.write_text(content)
        seen.add(digest())
    assert len(seen) == 4
    (package / "judges" / "by_height.py").touch()
    encoder.write_text(text)
    helper.unlink()
    assert digest() in seen


@pytest.mark.parametrize(
    ("models", "orientations", "words"),
    [
        ("None", "by_distance", "gives None, no list of Candidate"),
        ("[]", "by_distance", r"gives \[\], no list of Candidate"),
        ("[by_distance[0], by_distance[0]]", "by_distance", "gives cabinet_00 twice"),
        (
            "[by_distance[0].model_copy(update={'asset': 'sofa_9'})]",
            "by_distance",
            "gives sofa_9, which it was not shown",
        ),
        ("[one.asset for one in by_distance]", "by_distance", r"gives \['cabinet_00'.*, no list of Candidate"),
        ("by_distance", "[]", r"gives \[\], no list of Orientation"),
        ("by_distance", "None", "gives None, no list of Orientation"),
        ("by_distance", "[0.5]", r"gives \[0\.5\], no list of Orientation"),
    ],
)
def test_a_judge_that_answers_wrongly_is_named(
    package: Path, tmp_path: Path, models: str, orientations: str, words: str
) -> None:
    judge = package / "judges" / "wrong.py"
    judge.write_text(
        "class Judge:\n"
        "    def __init__(self, options): pass\n"
        f"    def models(self, question, by_votes, by_distance): return {models}\n"
        f"    def orientations(self, question, asset, by_votes, by_distance): return {orientations}\n"
    )
    sys.modules.pop("my_package.judges.wrong", None)
    importlib.invalidate_caches()
    name = "my_package.judges.wrong"
    try:
        world = World(tmp_path, model_selection=name, orientation_selection=name)
        with pytest.raises(InputError, match=f"judge {name}: {words}"):
            world.match(tmp_path / "cousins.json")
    finally:
        judge.unlink()


def test_encoder_text_encoder_search_and_judge(package: Path, tmp_path: Path) -> None:
    world = World(
        tmp_path,
        encoder="my_package.encoders.colors",
        text_encoder="my_package.text_encoders.last_word",
        search="my_package.searches.brute",
        model_selection="my_package.judges.by_height",
        kwargs={"colors": {"grid": 8}},
    )
    library = read_json(Library, world.library)
    sized = [entry.model_copy(update={"size": MODELS[entry.id][1]}) for entry in library.assets]
    write_json(world.library, library.model_copy(update={"assets": sized}))
    first = world.match(tmp_path / "cousins.json", count_threshold=None).objects[0]
    assert first.decided_by == "my_package.judges.by_height" and first.orientation_decided_by == "distance"
    high = read_json(Objects, world.objects).objects[0].box.size[2]  # type: ignore[union-attr]
    gaps = [abs(MODELS[cousin.asset][1][2] - high) for cousin in first.cousins]
    assert gaps == sorted(gaps) and gaps[0] < gaps[-1]
    assert {category.category for category in first.categories} == {"cabinet"}
    nearest = first.by_distance[0]
    assert (
        nearest.asset == "cabinet_00" and np.load(world.features[0]).shape[1] == 5 + 3
    )  # and the color that every row has


def test_source(package: Path, tmp_path: Path) -> None:
    boxes = [UprightBox([3.7, -0.8, 0.4], [0.6, 0.8, 0.8], 0.0), UprightBox([2.4, 0.5, 0.25], [0.5, 0.5, 0.5], 0.5)]
    folder = write_room(tmp_path / "input", boxes, ["cabinet", "box"])
    out = tmp_path / "out" / "objects.json"
    extract(input=folder, scene="s", out=out, options='{"source": "my_package.sources.smoothed"}')
    assert {item.status for item in read_json(Objects, out).objects} == {"ok"}
    with np.load(folder / "depth.npz") as given, np.load(tmp_path / "out" / "depth.npz") as used:
        assert np.array_equal(used["depth"], cv2.medianBlur(given["depth"].astype(np.float32), 5))


def test_importer(package: Path, tmp_path: Path) -> None:
    (tmp_path / "mine" / "box").mkdir(parents=True)
    trimesh.creation.box((0.3, 0.4, 0.5)).export(tmp_path / "mine" / "box" / "crate.off")
    assets = AssetsConfig(counts={}, folders=[str(tmp_path / "mine")])
    with pytest.raises(InputError, match=r"holds no model \(.urdf, .xml, .glb, .gltf, .obj, .dae, .ply, .stl\)"):
        own_shards(assets)
    importers = ["urdf", "my_package.importers.off"]
    ((name, shard),) = own_shards(assets.model_copy(update={"importers": importers})).items()
    own(
        folder=shard.folder,
        models=tuple(f"{model}={file}" for model, file in shard.models.items()),
        out=tmp_path / f"{name}.json",
        options=json.dumps({"importers": importers}),
    )
    assert [entry.id for entry in read_json(LibraryPart, tmp_path / f"{name}.json").assets] == ["box_crate"]


def test_task_and_skill(package: Path, tmp_path: Path) -> None:
    cabinet(tmp_path / "door")
    options = TaskConfig(scale_variants=1)
    name = find("tasks", "touch", ["my_package"])
    task = EnvWrapper(name, tmp_path / "door", "door_0_joint", None, options, render=False)
    episode, outcome = Recorder(task, DemonstrationsConfig()).attempt(3)
    assert outcome.success and task.success and task.opened < 0.1 and 2 < len(episode.actions) < 30
    assert task.task.target_joint(tmp_path / "door") is not None
    task.close()


def test_a_simulator_of_yours(package: Path, tmp_path: Path) -> None:
    cabinet(tmp_path / "door")
    late = implementation("simulators", find("simulators", "late", ["my_package"]))
    task = late("door", tmp_path / "door", "door_0_joint", None, TaskConfig(scale_variants=1), render=False)
    task.place(3)
    start = task.hand()[:3, 3].copy()
    moved = []
    for _ in range(2):
        task.act(np.array([-1.0, 0, 0, 0, 0, 0, 1], np.float32))
        moved.append(float(np.linalg.norm(task.hand()[:3, 3] - start)))
    assert moved[0] < 0.002 < moved[1]
    task.close()


def test_a_task_that_begins_with_an_open_drawer(package: Path, tmp_path: Path) -> None:
    cabinet(tmp_path / "chest", layout=[["drawer"]])
    name, options = find("tasks", "shut", ["my_package"]), TaskConfig(scale_variants=1)
    task = EnvWrapper(name, tmp_path / "chest", "drawer_0_joint", None, options, render=False)
    task.place(2)
    assert task.opened == pytest.approx(0.5, abs=0.01)
    _, outcome = Recorder(task, DemonstrationsConfig(noise=0.0, recovery=0.0)).attempt(2)
    assert outcome.success and outcome.retries == 0 and task.success and task.opened < CLOSED
    task.close()


def test_room(package: Path) -> None:
    room = read_room(room_files([], ["my_package"])["attic"])
    layout = arrange(room, {"chest": (0.5, 0.9, 0.8), "stool": (0.4, 0.4, 0.45)})
    assert room.name == "attic" and layout is not None and set(layout.standing) == {"chest", "stool"}


def test_policy(package: Path, tmp_path: Path) -> None:
    store = write_store(tmp_path / "episodes.h5", 4)
    options = {"policy": "my_package.policies.mean_action", "steps": 60, "batch_size": 8, "learning_rate": 0.05}
    train(episodes=(store,), per_store=4, options=json.dumps(options | {"points": 16}), out=tmp_path / "p")
    policy = load_network(tmp_path / "p", "best")
    policy.make_rollout_policy(2, "most_likely").start_episode(0, 0)
    action = policy.make_rollout_policy(2, "most_likely").get_action([0, 1], [], [])
    assert action.shape == (2, 7) and 0.1 < action[0, 0] < 1.0  # the objects of the toy are ahead


def stop(self: object) -> None:
    raise KeyboardInterrupt


FITTED = """\
import torch

from roomkin.stages.policies.base import TrainablePolicy


class Policy(TrainablePolicy):
    def __init__(self, config):
        super().__init__(config)
        self.register_buffer("hands", torch.zeros(64, 3))
        self.register_buffer("actions", torch.zeros(64, 7))

    def fit(self, clouds, proprio, actions, frames):
        some = frames[torch.linspace(0, len(frames) - 1, 64).long()]
        self.hands.copy_(proprio[some, :3])
        self.actions.copy_(actions[some])

    def nearest(self, proprio):
        return self.actions[torch.cdist(proprio[..., :3], self.hands).argmin(-1)]

    def loss(self, clouds, proprio, actions, weights):
        assert self.training == torch.is_grad_enabled()
        squared = (actions - self.nearest(proprio)).square().mean(-1)
        mean = (squared * weights).sum() / weights.sum()
        return mean, mean.sqrt()

    def make_rollout_policy(self, num_envs, mode):
        raise NotImplementedError
"""


def test_a_policy_without_parameters_is_fitted_alone(
    package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run that stopped at a saved step goes on, too."""
    (package / "policies" / "fitted.py").write_text(FITTED)
    store = write_store(tmp_path / "episodes.h5", 8)
    options = {"policy": "my_package.policies.fitted", "steps": 3, "log_freq": 1, "points": 16}

    def fitted(out: str) -> dict[str, torch.Tensor]:
        train(episodes=(store,), per_store=8, options=json.dumps(options), out=tmp_path / out)
        assert read_config(tmp_path / out).parameters == 0 and read_config(tmp_path / out).learned
        return dict(load_network(tmp_path / out, "best").state_dict())

    monkeypatch.setattr(state, "SAVE_FREQ", 1)
    whole = fitted("whole")
    assert whole["hands"].std(0).min() > 0
    with monkeypatch.context() as patch:
        patch.setattr(Logbook, "close", stop)
        with pytest.raises(KeyboardInterrupt):
            fitted("stopped")
    stopped = fitted("stopped")
    assert all(torch.equal(whole[name], stopped[name]) for name in whole)
    (package / "policies" / "fitted.py").unlink()


def test_a_run_with_plugins_has_a_dag(tmp_path: Path) -> None:
    folder = make(tmp_path / "run")
    write_package(folder)
    (folder / "mine.yaml").write_text(
        "plugins: [my_package]\n"
        "assets: {importers: [urdf, 'off']}\n"
        "extraction: {source: smoothed}\n"
        "matching: {encoder: colors, text_encoder: last_word, search: brute, model_selection: by_height}\n"
        "training: {configs: {mean: {policy: mean_action, points: 64, num_checkpoints: 1}}}\n"
        "experiment: {rooms: [room_1, attic], targets: {touch: {room: room_1, object: cabinet_1}, door: null},\n"
        "  policies: {mean: {}, micro: null, micro_handle: null}}\n"
    )
    files = ("config.yaml", "config/test/micro.yaml", "mine.yaml")
    done = snakemake(folder, "-n", "-p", "--configfile", *files, "--", "all")
    assert done.returncode == 0, done.stdout[-3000:]
    for text in (
        "my_package/rooms/attic.yaml",
        '"encoder": "my_package.encoders.colors"',
        '"policy": "my_package.policies.mean_action"',
        "--task my_package.tasks.touch",
        "results/demonstrations/touch/twin/episodes.h5",
    ):
        assert text in done.stdout, text
