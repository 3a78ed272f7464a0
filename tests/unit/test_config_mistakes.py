"""Contradictions of the config are found before anything runs: all at once, each with its key and how to mend it."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from roomkin.plugins.furniture.facts import counts_text
from roomkin.stages.config import categories
from roomkin.stages.config.assets import COUNTS, AssetsConfig
from roomkin.stages.config.files import read_file
from roomkin.stages.config.inputs import INPUT_FILES
from roomkin.stages.config.model import load, merge_mappings, with_defaults
from roomkin.stages.contracts import InputError
from tests.packages import needs
from tests.refusals import refused

ROOT = Path(__file__).resolve().parents[2]
DEFAULT = with_defaults({})


def lines(text: str) -> list[str]:
    """The mistakes of the default config with an overlay."""
    try:
        load(merge_mappings(DEFAULT, yaml.safe_load(text)))
    except InputError as error:
        return [line.removeprefix("config: ").strip() for line in str(error).splitlines() if "mistakes:" not in line]
    return []


CASES = [
    (
        "{experiment: {rooms: [0012]}}",
        "experiment.rooms.0: Input should be a valid string (got 10). Fix: in quotes, as ",
    ),
    ("{experiment: {seeds: 3}}", "experiment.seeds: Input should be a valid list (got 3). Fix: write [3] or [0, 1, 2]"),
    ("{experiment: {rooms: mine}}", "experiment.rooms: Input should be a valid list (got 'mine'). Fix: write ['mine']"),
    ("evaluation: {test_assets: [twin, uncle]}", "evaluation.test_assets: there is no 'uncle'"),
    ("evaluation: {test_assets: [cousin_0]}", "evaluation.test_assets: there is no 'cousin_0'"),
    ("evaluation: {test_assets: [cousin_11]}", "evaluation.test_assets: there is no 'cousin_11'"),
    ("evaluation: {test_assets: []}", "evaluation.test_assets: List should have at least 1 item"),
    (
        "{evaluation: {checkpoint: rollouts}, experiment: {policies: {lite_handle: null}}}",
        "evaluation.checkpoint: is rollouts, but training.configs.lite.num_checkpoints = 0",
    ),
    ("evaluation: {rollouts: 0}", "evaluation.rollouts: Input should be greater than or equal to 1"),
    (
        "training: {configs: {lite: {points: 600}}}",
        "training.configs.lite.points: 600 of task.points = 512",
    ),
    ("training: {configs: {lite: {network: {gmm_modes: 9}}}}", "training.configs.lite.network: unknown key"),
    ("training: {configs: {lite: {kwargs: {gmm_modes: on}}}}", "training.configs.lite.kwargs.gmm_modes: is True"),
    ("extraction: {kwargs: {noise: 1}}", "extraction.kwargs.noise: unknown key. Fix: leave it out"),
    (
        "training: {configs: {lite: {kwargs: {mlp: [-5]}}}}",
        "training.configs.lite.kwargs.mlp.0: Input should be greater",
    ),
    (
        "training: {configs: {lite: {handle: {hide: 0.5}}}}",
        "training.configs.lite.handle: Input should be a valid boolean",
    ),
    (
        "training: {configs: {mine: {handle: true, kwargs: {cloud: false}}}}",
        "training.configs.mine: handle: flags points of a cloud",
    ),
    (
        "training: {configs: {lite: {num_checkpoints: 9, steps: 5}}}",
        "training.configs.lite.num_checkpoints: 9 checkpoints of 5 steps. Fix: lower it",
    ),
    ("training: {configs: {'a/b': {}}}", "training.configs: 'a/b' is no name"),
    ("task: {control_frequency: 0}", "task.control_frequency: Input should be greater than 0"),
    ("task: {control_frequency: 12}", "task.control_frequency: 12 does not divide 100"),
    ("task: {scale_range: [1.1, 0.9]}", "task.scale_range: 1.1 is above 0.9"),
    ("task: {camera_jitter: [-1, 0]}", "task.camera_jitter.0: Input should be greater than or equal to 0"),
    ("task: {workspace_min: [2, -0.5, 0]}", "task.workspace_min: x = 2 is not below workspace_max's 1"),
    ("generation: {support_overlap: 0.5}", "generation.support_overlap: unknown key. Fix: there are: ranks"),
    (
        "experiment: {variants: {default: {coverage: 0.4}}}",
        "experiment.variants.default.coverage: unknown key. Fix: did you mean",
    ),
    ("demonstrations: {noise: -1}", "demonstrations.noise: Input should be greater"),
    ("generation: {ranks: 11}", "generation.ranks: 11 scenes from matching.k_cousins = 10"),
    ("{demonstrations: {goal_margin: 0.5}, task: {success_fraction: 0.9}}", "demonstrations.goal_margin: 0.5 past"),
    ("assets: {counts: {mug: -1}}", "assets.counts.mug: Input should be greater than or equal to 0"),
    ("assets: {counts: {mugs: 1}}", "assets.counts: no category 'mugs'. Fix: did you mean 'mug'?"),
    ("perception: {heights: {frigde: 1.8}}", "perception.heights.frigde: is no name that is known. Fix: did you mean"),
    ("perception: {heights: {fridge: 180}}", "perception.heights.fridge: is 180.0 m. Fix: metres, from 0.01 to 100"),
    ("perception: {heights: {camera: 0}}", "perception.heights.camera: is 0.0 m. Fix: metres, from 0.01 to 100"),
    ("assets: {counts: {fridge: 0}}", "assets.counts.fridge: the rooms up to room_3 need 1"),
    ("assets: {own_only: true}", "assets.own_only: there are no models of yours"),
    ("matching: {k_ori: 25}", "matching.k_ori: 25 views of assets.n_snap = 24"),
    ("experiment: {variants: {far: {views: 25}}}", "experiment.variants.far.views: 25 views of assets.n_snap = 24"),
    ("experiment: {rooms: [room_3, room_9]}", "experiment.rooms: unknown scene 'room_9'"),
    ("experiment: {rooms: [room_3, room_3]}", "experiment.rooms: 'room_3' is named 2 times"),
    ("experiment: {placements: {c: {}}}", "experiment.placements: 'c' is not one of experiment.variants"),
    ("experiment: {placements: {default: {ranks: 2}}}", "experiment.placements.default.ranks: is one for all variants"),
    (
        "experiment: {placements: {default: {trim: -1}}}",
        "experiment.placements.default.trim: Input should be greater than or",
    ),
    ("experiment: {placements: {default: {touch: 1}}}", "experiment.placements.default.touch: unknown key"),
    ("experiment: {rooms: [room_1]}", "experiment.targets.door.room: 'room_3' is not one of experiment.rooms"),
    ("experiment: {rooms: []}", "experiment.rooms: List should have at least 1 item"),
    ("experiment: {targets: {door: {object: cabinet_7}}}", "experiment.targets.door.object: room_3 has no 'cabinet_7'"),
    (
        "experiment: {targets: {door: {object: stool_1}}}",
        "experiment.targets.door.object: 'stool_1' of room_3 has no door",
    ),
    ("experiment: {targets: {dor: {}}}", "experiment.targets.dor: there is no 'dor'. Fix: did you mean 'door'?"),
    (
        "experiment: {targets: {drawer: {room: room_1, object: cabinet_1}}}",
        "experiment.targets.drawer.object: 'cabinet_1' of room_1 has no drawer",
    ),
    ("experiment: {inputs: {mine: nowhere}, rooms: [room_3, mine]}", "experiment.inputs.mine: no folder nowhere"),
    ("experiment: {inputs: {room_2: nowhere}}", "experiment.inputs.room_2: is the name of a room"),
    ("experiment: {inputs: {'my scene': x}}", "experiment.inputs: 'my scene' is no name"),
    ("experiment: {variants: {'c/d': {}}}", "experiment.variants: 'c/d' is no name"),
    (
        "experiment: {variants: {default: null, c: {}}, targets: null}",
        "experiment.policy_variant: 'default' is not one of",
    ),
    (
        "experiment: {policy_variant: b}",
        "experiment.policy_variant: 'b' is not one of experiment.variants. Fix: one of default",
    ),
    (
        "experiment: {variants: {c: {k_modl: 3}}}",
        "experiment.variants.c.k_modl: unknown key. Fix: did you mean 'k_model'?",
    ),
    (
        "experiment: {variants: {c: {hog: {grid: 7}}}}",
        "experiment.variants.c.hog: grid 7 does not divide image_size 192",
    ),
    ("experiment: {held_out: [1, 11]}", "experiment.held_out: there is no cousin 11 of experiment.cousins = 10"),
    ("experiment: {held_out: [-2]}", "experiment.held_out.0: Input should be greater than or equal to 1"),
    (
        "experiment: {training_sets: [cousins_2], held_out: [1, 2, 3, 4, 5, 6, 7, 8, 9]}",
        "experiment.training_sets: cousins_2 needs 2 cousins, experiment.cousins = 10 leaves 1",
    ),
    (
        "{experiment: {cousins: 6, policies: {lite: {training_sets: [cousins_8]}}}}",
        "experiment.policies.lite.training_sets: cousins_8 needs 8 cousins, experiment.cousins = 6 leaves 4",
    ),
    (
        "experiment: {policies: {huge: {}}}",
        "experiment.policies.huge: 'huge' is not one of training.configs. Fix: one of",
    ),
    (
        "experiment: {policies: {a: {configs: [huge]}}}",
        "experiment.policies.a.configs: 'huge' is not one of training.configs",
    ),
    (
        "experiment: {policies: {lite: {configs: []}}}",
        "experiment.policies.lite.configs: List should have at least 1 item",
    ),
    ("experiment: {policies: {lite: {seeds: [1, 1]}}}", "experiment.policies.lite.seeds: '1' is named 2 times"),
    (
        "experiment: {policies: {lite: {targets: [dor]}}}",
        "experiment.policies.lite.targets: 'dor' is not one of experiment.targets. Fix: one of door",
    ),
    (
        "experiment: {policies: {both: {configs: [lite, lite_handle]}}}",
        "experiment.policies.both.configs: lite and lite_handle are other kinds of policies, which are never pooled. "
        "Fix: a policy for each: `policies: {lite: {}, lite_handle: {}}`",
    ),
    (
        "{training: {configs: {wide: {steps: 9}}}, experiment: {policies: {a: {configs: [lite, wide]}}}}",
        "experiment.policies.a.configs: lite and wide are no more than experiment.best_configs = 2. Fix: a policy for",
    ),
    ("experiment: {targets: {far: {task: dor}}}", "experiment.targets.far.task: there is no 'dor'. Fix: did you mean"),
    ("experiment: {pools: {all: [door, dor]}}", "experiment.pools.all: 'dor' is not one of experiment.targets"),
    ("experiment: {pools: {door: [door]}}", "experiment.pools.door: is the name of a target, too"),
    ("experiment: {pools: {a: [door], b: [door]}}", "experiment.pools.b: door is in the pool a, too"),
    *(
        (
            f"experiment: {{targets: {{far: {{task: door, {differs}}}}}, pools: {{doors: [door, far]}}}}",
            "experiment.pools.doors: door and far differ in task, options or episodes. Fix: pool targets that",
        )
        for differs in ("options: {max_steps: 50}", "episodes: 80")
    ),
    ("experiment: {runs: [lite, wide]}", "experiment.runs: unknown key. Fix: did you mean"),
    ("experiment: {targets: {door: {scene: room_3}}}", "experiment.targets.door.scene: unknown key. Fix: there are"),
    ("experiment: {targets: {'a/b': {task: door}}}", "experiment.targets: 'a/b' is no name"),
    (
        "experiment: {targets: {door: {options: {camera_eyes: [0, 0, 0]}}}}",
        "experiment.targets.door.options.camera_eyes: unknown key. Fix: did you mean 'camera_eye'?",
    ),
    (
        "experiment: {targets: {door: {options: {points: 128}}}, policies: {lite_handle: null}}",
        "training.configs.lite.points: 192 of experiment.targets.door.options.points = 128",
    ),
    (  # beside a target that has enough
        "experiment: {targets: {near: {task: door, options: {points: 128}}}, policies: {lite_handle: null}}",
        "training.configs.lite.points: 192 of experiment.targets.near.options.points = 128",
    ),
    (
        "{experiment: {cousins: 6, training_sets: [cousins_8]}}",
        "experiment.training_sets: cousins_8 needs 8 cousins, experiment.cousins = 6 leaves 4",
    ),
    ("seed: yes", "seed: is True (YAML's yes and no, too), not a number"),
    ("experiment: {seeds: [no]}", "experiment.seeds: is False"),
    ("training: {configs: {lite: {steps: on}}}", "training.configs.lite.steps: is True"),
    ("generation: {snap_other: yes}", "generation.snap_other: is True"),
    ("experiment: {variants: {default: {k_model: yes}}}", "experiment.variants.default.k_model: is True"),
    (
        "experiment: {targets: {door: {options: {scale_variants: yes}}}}",
        "experiment.targets.door.options.scale_variants: is True",
    ),
    (f"seed: {2**53}", "seed: Input should be less than 9007199254740992"),
    ("generation: {settle_seconds: 1e9}", "generation.settle_seconds: Input should be less than or equal to 60"),
    (
        "experiment: {training_sets: [twin, cousins_2, cousins_4], episodes: 3}",
        "experiment.episodes: 3 cannot be shared evenly by the assets of cousins_2, cousins_4. Fix: a multiple of 4",
    ),
    (
        "experiment: {targets: {door: {episodes: 4}}, training_sets: [random_3]}",
        "experiment.targets.door.episodes: 4 cannot be shared evenly by the assets of random_3",
    ),
    (
        "experiment: {training_sets: [cousins_9_randomised], episodes: 9}",
        "experiment.training_sets: cousins_9_randomised needs 9 cousins, experiment.cousins = 10 leaves 8",
    ),
    (
        "experiment: {training_sets: [cover_17], episodes: 17}",
        "experiment.training_sets: cover_17 needs 17 assets, 16 are drawn. Fix: cover_16 or fewer",
    ),
    (
        "experiment: {training_sets: [twin, cousin_4]}",
        "experiment.training_sets.1: 'cousin_4' is no training set. Fix: did you mean 'cousins_4'?",
    ),
    (
        "experiment: {policies: {lite: {training_sets: [cousin_8_randomized]}}}",
        "experiment.policies.lite.training_sets.0: 'cousin_8_randomized' is no training set. Fix: did you mean "
        "'cousins_8_randomised'?",
    ),
    (
        "experiment: {training_sets: [xyz]}",
        "experiment.training_sets.0: 'xyz' is no training set. Fix: there are: twin, all, cousins_4, random_4, cover_4",
    ),
    ("experiment: {draws: 0}", "experiment.draws: Input should be greater than or equal to 1"),
    ("experiment: {seeds: [-1]}", "experiment.seeds.0: Input should be greater than or equal to 0"),
    (
        "training: {configs: {lite: {steps: 10, num_checkpoints: 20}}}",
        "training.configs.lite.num_checkpoints: 20 checkpoints of 10 steps. Fix: lower it",
    ),
    ("tables: {scenes: {room_1: 9}}", "tables.scenes.room_1: Input should be less than or equal to 8"),
    (
        "stages: {matching: {match: {command: x, code: [gone.sh]}}}",
        "stages.matching.match.code: no file or folder gone.sh",
    ),
    (
        "stages: {matching: {match: {command: ./gone.sh --fast}}}",
        "stages.matching.match.command: ./gone.sh cannot be executed",
    ),
    (
        f"stages: {{matching: {{match: {{command: {__file__}}}}}}}",
        f"stages.matching.match.command: {__file__} cannot be executed. Fix: chmod +x",
    ),
    ("maching: {encoder: hog}", "maching: unknown key. Fix: did you mean 'matching'?"),
]


OF_PACKAGES = [
    (
        ("diffusion",),
        "plugins: [roomkin.plugins.diffusion]\n"
        "training: {configs: {lite: {policy: diffusion, kwargs: {gmm_modes: 9}}}}",
        "training.configs.lite.kwargs.gmm_modes: unknown key. Fix: there are: cloud, cloud_frame",
    ),
    (
        ("diffusion",),
        "plugins: [roomkin.plugins.diffusion]\n"
        "training: {configs: {lite: {policy: diffusion, kwargs: {n_action_step: 9}}}}",
        "training.configs.lite.kwargs.n_action_step: unknown key. Fix: did you mean 'n_action_steps'?",
    ),
    (
        ("efficientnet",),
        "matching: {kwargs: {efficientnet: {positon: 1}}}",
        "matching.kwargs.efficientnet.positon: unknown key. Fix: did you",
    ),
    (("vlm",), "matching: {vlm: {model: x}}", "matching.vlm: unknown key. Fix: do you mean vlm?"),
    (
        ("robustness",),
        "experiment: {protocols: {a: {variants: [c]}}}",
        "experiment.protocols.a.variants: 'c' is not one of",
    ),
    (("robustness",), "experiment: {protocols: {a.b: {}}}", "experiment.protocols: 'a.b' is no name"),
    (
        ("robustness",),
        "experiment: {protocols: {a: {seeds: [1, 1]}}}",
        "experiment.protocols.a.seeds: '1' is named 2 times",
    ),
    (("studies",), "evaluation: {conditions: {'a/b': {own_size: true}}}", "evaluation.conditions: 'a/b' is no name"),
    (
        ("studies",),
        "evaluation: {conditions: {usual: {own_size: true}}}",
        "evaluation.conditions: 'usual' is what the table calls",
    ),
    ((), "perception: {detector: {path: a}}", "perception.detector: Input should be a valid string"),
    (
        ("importing",),
        f"assets: {{own_only: true, folders: [{ROOT}/stages]}}",
        "assets.own_only: room_1 is furnished with procedural models",
    ),
    (("importing",), "assets: {folders: [nowhere]}", "assets.folders: no folder nowhere"),
    (
        ("vlm",),
        "vlm: {key_env: sk-1234}",
        "vlm.key_env: is no name of an environment variable. Fix: e.g. OPENAI_API_KEY; the key itself",
    ),
    (("pretrained",), "matching: {encoder: dinov2, dinov2: {path: a}}", "matching.dinov2.path: no config.json in 'a'"),
    (
        ("mujoco", "bowl"),
        "{evaluation: {simulator: mujoco}, experiment: {targets: {bowl: {task: put_away_bowl, object: oven_1}}}}",
        "evaluation.simulator: mujoco does not have the task put_away_bowl of experiment.targets.bowl",
    ),
]
ROWS = [pytest.param(text, line, id=line.partition(": ")[0]) for text, line in CASES]
ROWS += [pytest.param(text, line, id=line.partition(": ")[0], marks=needs(*names)) for names, text, line in OF_PACKAGES]


@pytest.mark.parametrize(("text", "line"), ROWS)
def test_a_mistake_is_one_line_with_its_key(text: str, line: str) -> None:
    found = lines(text)
    assert [each for each in found if each.startswith(line)], found
    assert len(found) == 1


@needs("diffusion", "pretrained")
@pytest.mark.parametrize("file", sorted(ROOT.glob("config/swaps/*.yaml")), ids=lambda file: str(file.stem))
def test_the_shipped_swaps_are_no_mistake(file: Path) -> None:
    found = lines(file.read_text(encoding="utf-8"))
    assert [line for line in found if not line.startswith("matching.dinov2.path: no vit_s_focus.onnx in ")] == []


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("seed: 1\nassets: {n_snap: 4}\nseed: 2\n", r"mine\.yaml:3: 'seed' stands in line 1, too"),
        ("assets: {n_snap: 4, n_snap: 8}\n", r"mine\.yaml:1: 'n_snap'"),
        ("task: [{a: 1}, {b: 1,\n b: 2}]\n", r"mine\.yaml:2: 'b'"),
        ('{"seed": 1, "seed": 2}', r"mine\.yaml:1: 'seed'"),
    ],
)
def test_a_key_given_twice_is_refused(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "mine.yaml").write_text(text)
    with refused("E-CONFIG-KEY-TWICE") as caught:
        read_file(tmp_path / "mine.yaml")
    assert re.search(words, str(caught.value))


def test_keys_given_once_are_no_fault(tmp_path: Path) -> None:
    for file in ROOT.glob("config/**/*.yaml"):
        read_file(file)
    (tmp_path / "mine.yaml").write_text("a: &one {x: 1}\nb: {<<: *one, <<: *one, y: 1}\nc: [&all [*all]]\n")
    read_file(tmp_path / "mine.yaml")


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("maching: {}", "E-CONFIG-KEY"),
        ("seed: -1", "E-CONFIG-VALUE"),
        ("seed: yes", "E-CONFIG-VALUE"),
        ("experiment: {rooms: [room_3, room_9]}", "E-CONFIG-UNKNOWN"),
        ("experiment: {rooms: [room_3, room_3]}", "E-CONFIG-TWICE"),
        ("training: {configs: {'a/b': {}}}", "E-CONFIG-NAME"),
        pytest.param("assets: {folders: [nowhere]}", "E-CONFIG-FILE", marks=needs("importing")),
        ("task: {control_frequency: 12}", "E-CONFIG-CLASH"),
        ("matching: {encoder: hogg}", "E-PLUGIN-UNKNOWN"),
        ("plugins: [nowhere]", "E-PLUGIN-PACKAGE"),
        ("{seed: -1, maching: {}}", "E-CONFIG"),
    ],
)
def test_a_mistake_has_the_code_of_its_kind(text: str, code: str) -> None:
    with refused(code):
        load(merge_mappings(DEFAULT, yaml.safe_load(text)))


def test_all_mistakes_are_told_at_once() -> None:
    text = """
    experiment: {rooms: [room_3, room_9], held_out: [-1], variants: {c: {hog: {postion: 1}}}}
    evaluation: {test_assets: [uncle]}
    task: {control_frequency: 0}
    training: {configs: {lite: {kwargs: {pionts: 3}}}}
    """
    keys = {line.partition(":")[0] for line in lines(text)}
    assert keys == {"experiment.held_out.0", "task.control_frequency", "training.configs.lite.kwargs.pionts",
                    "experiment.variants.c.hog.postion", "experiment.rooms", "evaluation.test_assets"}  # fmt: skip


@pytest.mark.parametrize(
    ("text", "path", "left"),
    [
        ("experiment: {targets: {door: null}}", "experiment.targets", set()),
        ("experiment: {targets: null}", "experiment.targets", set()),
        ("experiment: {variants: {default: null, c: {}}, policy_variant: c}", "experiment.variants", {"c"}),
        (
            "{training: {configs: {lite_handle: null}}, experiment: {policies: {lite_handle: null}}}",
            "training.configs",
            {"lite"},
        ),
        ("tables: {variants: {a: null, b: null}}", "tables.variants", {"c", "d"}),
        ("assets: {counts: {book: null}}", "assets.counts", set(COUNTS) - {"book"}),
        ("stages: {matching: null}", "stages", set()),
    ],
)
def test_an_overlay_removes_what_the_default_has(text: str, path: str, left: set[str]) -> None:
    value: Any = load(merge_mappings(DEFAULT, yaml.safe_load(text)))
    for part in path.split("."):
        value = getattr(value, part)
    assert set(value) == left


def test_null_stays_a_value_where_it_means_something() -> None:
    text = "{generation: {snap_other: null}, experiment: {variants: {default: {count_threshold: null}}}}"
    config = load(merge_mappings(DEFAULT, yaml.safe_load(text)))
    assert config.generation.snap_other is None
    assert config.matching_of("default").count_threshold is None


def test_a_variant_changes_only_what_it_names() -> None:
    text = "{matching: {hog: {grid: 12, normals: 9.0}}, experiment: {variants: {hog: {hog: {position: 1.0}}}}}"
    hog = load(merge_mappings(DEFAULT, yaml.safe_load(text))).matching_of("hog").hog
    assert (hog.position, hog.grid, hog.normals, hog.image_size) == (1.0, 12, 9.0, 192)


def test_objects_of_an_own_scene_are_known_by_its_annotations(tmp_path: Path) -> None:
    for name in INPUT_FILES:
        (tmp_path / name).touch()
    objects = [{"mask": 1, "label": "Tall Cabinet", "articulated": True, "doors": 1}, {"mask": 2, "label": "bowl"}]
    (tmp_path / "annotations.json").write_text(json.dumps({"objects": objects}))
    text = "experiment: {{rooms: [mine], inputs: {{mine: {}}}, targets: {{door: {{room: mine, object: {}}}}}}}"
    assert lines(text.format(tmp_path, "tall_cabinet_1")) == []
    assert "has no 'cabinet_1'. Fix: one of tall_cabinet_1" in lines(text.format(tmp_path, "cabinet_1"))[0]
    assert "'bowl_1' of mine has no door" in lines(text.format(tmp_path, "bowl_1"))[0]
    (said,) = lines(text.format(tmp_path, "tall_cabinet_1").replace("door:", "door: null, drawer:"))
    assert "has no drawer. Fix: no object there has one; remove the target: `drawer: null`" in said
    (tmp_path / "depth.npz").unlink()
    assert f"experiment.inputs.mine: {tmp_path} has no depth.npz" in lines(text.format(tmp_path, "tall_cabinet_1"))[0]


def test_rooms_of_the_users_are_known(tmp_path: Path) -> None:
    file = tmp_path / "attic.yaml"
    file.write_text((ROOT / "plugins/scenes/rooms/room_2.yaml").read_text())
    targets = "targets: {{drawer: {{room: attic, object: {}}}, door: null}}"
    text = f"experiment: {{{{room_files: [{file}], rooms: [attic], {targets}}}}}"
    assert lines(text.format("chest_of_drawers_1")) == []
    assert "'tv_1' of attic has no drawer" in lines(text.format("tv_1"))[0]
    file.write_text(file.read_text().replace("category: television", "category: televison"))
    (said,) = lines(text.format("chest_of_drawers_1"))
    assert said == (
        "experiment.rooms: attic has an item of the category 'televison', which is not known. "
        "Fix: did you mean 'television'?"
    )
    file.unlink()
    assert f"experiment.room_files: there is no file {file}" in lines(text.format("tv_1"))[0]


def test_what_is_known_here_is_what_the_stages_do() -> None:
    assert categories.FILE.read_text() == counts_text(), "make config"


def test_own_models_alone_leave_none_of_ours() -> None:
    ours = load(merge_mappings(DEFAULT, yaml.safe_load("assets: {counts: {mug: 3}}"))).assets
    own = {"own_only": True, "folders": ["mine"], "counts": {"mug": 3}}
    assert sum(ours.counts.values()) > 3 and AssetsConfig.model_validate(own).counts == {}
    assert AssetsConfig.model_validate(own | {"own_only": False}).counts == {"mug": 3}


def test_only_the_categories_that_are_named() -> None:
    named = with_defaults(yaml.safe_load("assets: {only: true, counts: {mug: 3}}"))["assets"]["counts"]
    assert {category: count for category, count in named.items() if count} == {"mug": 3}
    every = with_defaults(yaml.safe_load("assets: {counts: {mug: 3}}"))["assets"]["counts"]
    assert every["mug"] == 3 and every["plate"] > 0


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("matching: {encodr: hog}", "did you mean 'encoder'?"),
        ("learning_rate: 0.1", "training.configs.*.learning_rate"),
        ("experiment: {folders: [mine]}", "assets.folders"),
        ("evaluation: {episodes: 3}", "experiment.episodes"),
        ("extraction: {dbscan_eps: 0.1}", "leave it out: it is no option any more"),
        ("demonstrations: {approach_speed: [0.5, 1]}", "leave it out: it is no option any more"),
    ],
)
def test_an_unknown_key_names_the_one_that_was_meant(text: str, meant: str) -> None:
    with refused("E-CONFIG-KEY", meant):
        load(yaml.safe_load(text))
