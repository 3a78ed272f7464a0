"""Contradictions in a config: found before anything runs, all at once, each with its mend."""

import os
import shlex
from collections import Counter
from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

from roomkin.stages.config import experiment_contradictions as experiment
from roomkin.stages.config import other_pictures
from roomkin.stages.config.categories import CATEGORIES
from roomkin.stages.config.evaluation import USUAL
from roomkin.stages.config.inputs import NAME, is_scene, suggest_scene
from roomkin.stages.config.mistakes import Mistake
from roomkin.stages.config.other_pictures import hand_file
from roomkin.stages.config.packages import packages_on
from roomkin.stages.config.weights import DINOV2, FOLDER, list_lacking
from roomkin.stages.contracts.errors import InputError, suggest_nearest
from roomkin.stages.contracts.hand import CORRECTIONS, read_corrections
from roomkin.stages.contracts.policy_config import SIMULATION_FREQUENCY, TaskConfig

if TYPE_CHECKING:
    from roomkin.stages.config.model import Config


def contradictions(config: "Config") -> list[Mistake]:
    """All of them, in the order of config.yaml."""
    checks = (
        _packages, _perception, _names, _scenes, other_pictures.find_mistakes, experiment.targets, experiment.pools,
        experiment.training_sets, experiment.test_assets, experiment.simulators, _library, _matching,
        experiment.policies, experiment.check_choices, experiment.networks, _environment, _stages,
    )  # fmt: skip
    return [found for check in checks for found in check(config)]


def _packages(config: "Config") -> Iterator[Mistake]:
    """Keys of packages that are off or not here, and the mistakes that packages which are on find."""
    rooms = [config.experiment.inputs[room] for room in config.experiment.rooms if room in config.experiment.inputs]
    asked = (
        ("scenes", "experiment.room_files", bool(config.experiment.room_files)),
        ("furniture", "assets.counts", any(config.assets.counts.values())),
        ("importing", "assets.folders", bool(config.assets.folders)),
        ("studies", "evaluation.conditions", bool(config.evaluation.conditions)),
        ("studies", "experiment.targets", any(target.assets for target in config.experiment.targets.values())),
        ("robustness", "experiment.protocols", bool(config.experiment.protocols)),
        ("vlm", "perception.captions", bool(config.image or rooms) and config.perception.captions == "vlm"),
        ("pretrained", "perception.by", bool(config.experiment.pictures) and config.perception.by == "networks"),
    )
    for name, key, wanted in asked:
        if wanted and not config.packages.get(name):
            what = f"is read by the package {name}, which is off or not here"
            yield Mistake(key, what, f"packages: {{{name}: true}}")
    for package in packages_on(config.packages):
        yield from package.mistakes(config)


def _perception(config: "Config") -> Iterator[Mistake]:
    """Pictures that `image` names, heights that are none, and weights that find what pictures without depth show."""
    names = ["camera", *(category.replace("_", " ") for category in CATEGORIES), *config.perception.labels]
    for name, height in config.perception.heights.items():
        if name not in names and get_close_matches(name, names, cutoff=0.8):  # other names a person may have drawn
            mend = suggest_nearest(name, names)
            yield Mistake(f"perception.heights.{name}", "is no name that is known", mend, "E-CONFIG-UNKNOWN")
        if not 0.01 <= height <= 100:
            yield Mistake(f"perception.heights.{name}", f"is {height} m", "metres, from 0.01 to 100", "E-CONFIG-VALUE")
    if config.image:
        for picture in config.experiment.inputs.values():
            yield from picture.mistakes("")
    elif config.depth or config.camera:
        key = "depth" if config.depth else "camera"
        yield Mistake(key, "is said of no picture", "--config image=color.png")
    pictures = config.experiment.pictures
    if not pictures or "draw" in config.stages.get("perception", {}):
        return
    key = "image" if config.image else "experiment.inputs"
    by_hand = f"draw it: roomkin annotator annotate {shlex.quote(pictures[0])}"
    if config.perception.asks_networks() and (lacking := config.perception.list_lacking()):
        folders = ", ".join(f"perception.{name} ({config.perception.networks()[name]})" for name in lacking)
        mend = f"roomkin perception fetch --networks, or without weights {by_hand}"
        yield Mistake(key, f"there are no weights in {folders}", mend, "E-CONFIG-FILE")
    elif not config.perception.asks_networks() and (lacking := list_lacking()):
        what = f"is a picture without depth, and there are no weights ({', '.join(lacking)})"
        yield Mistake(key, what, f"make weights, or without weights {by_hand}", "E-CONFIG-FILE")


def _names(config: "Config") -> Iterator[Mistake]:
    """Names that become paths, and lists that name a thing twice."""
    experiment = config.experiment
    named: dict[str, Iterable[str]] = {
        "experiment.variants": experiment.variants, "experiment.protocols": experiment.protocols,
        "experiment.targets": experiment.targets, "experiment.policies": experiment.policies,
        "experiment.pools": experiment.pools, "training.configs": config.training.configs,
        "evaluation.conditions": config.evaluation.conditions,
    }  # fmt: skip
    for name in experiment.inputs:
        if not is_scene(name):
            yield Mistake("experiment.inputs", f"'{name}' is no name", suggest_scene(name), "E-CONFIG-NAME")
    for key, names in named.items():
        for name in names:
            if not NAME.fullmatch(name):
                yield Mistake(key, f"'{name}' is no name", "letters, digits, - and single _ inside", "E-CONFIG-NAME")
    if USUAL in config.evaluation.conditions:
        what = f"'{USUAL}' is what the table calls section evaluation itself"
        yield Mistake("evaluation.conditions", what, "give the condition another name", "E-CONFIG-NAME")
    for key in ("rooms", "training_sets", "held_out", "seeds"):
        yield from _list_repeated(f"experiment.{key}", getattr(experiment, key))
    for key, chosen in (
        ("placements", experiment.placements),
        *((f"protocols.{name}.variants", change.variants or []) for name, change in experiment.protocols.items()),
    ):
        for variant in chosen:
            if variant not in experiment.variants:
                yield Mistake.unknown(f"experiment.{key}", variant, "experiment.variants", experiment.variants)
    for variant, changes in experiment.placements.items():
        if "ranks" in changes:
            yield Mistake(f"experiment.placements.{variant}.ranks", "is one for all variants", "set generation.ranks")
    for name, policy in experiment.policies.items():
        for key in ("targets", "training_sets", "configs", "seeds"):
            yield from _list_repeated(f"experiment.policies.{name}.{key}", getattr(policy, key) or ())
    for name, perturbation in experiment.protocols.items():
        yield from _list_repeated(f"experiment.protocols.{name}.seeds", perturbation.seeds)
    yield from _list_repeated("evaluation.test_assets", config.evaluation.test_assets)


def _list_repeated(key: str, values: Iterable[object]) -> Iterator[Mistake]:
    for value, count in Counter(values).items():
        if count > 1:
            yield Mistake(key, f"'{value}' is named {count} times", "name it once", "E-CONFIG-TWICE")


def _scenes(config: "Config") -> Iterator[Mistake]:
    """Scenes that exist, folders that hold what they must, files of corrections that can be read."""
    experiment = config.experiment
    try:
        rooms = config.rooms()
    except InputError:
        return  # said above
    for name in experiment.rooms:
        if name not in rooms and name not in experiment.inputs:
            near = suggest_nearest(name, [*rooms, *experiment.inputs]) if rooms else "packages: {scenes: true}"
            mend = f"{near}, or a picture of yours in experiment.inputs"
            yield Mistake("experiment.rooms", f"unknown scene '{name}'", mend, "E-CONFIG-UNKNOWN")
    for name, given in experiment.inputs.items():
        key = f"experiment.inputs.{name}"
        if name in rooms:
            yield Mistake(key, "is the name of a room", "give your scene another name")
        elif name in experiment.rooms and not config.image:
            yield from given.mistakes(key)
    for scene in (*experiment.rooms, *experiment.perturbed_scenes()):
        path = hand_file(experiment, scene, CORRECTIONS)
        try:
            read_corrections((path,) if path.is_file() else ())
        except InputError as error:
            yield Mistake.of(error)


def _library(config: "Config") -> Iterator[Mistake]:
    """Categories that exist, folders that exist, a library that is not empty."""
    for category in config.assets.counts:
        if category not in CATEGORIES:
            mend = suggest_nearest(category, CATEGORIES)
            yield Mistake("assets.counts", f"no category '{category}'", mend, "E-CONFIG-UNKNOWN")
    for folder in config.assets.folders:
        if not Path(folder).is_dir():
            yield Mistake("assets.folders", f"no folder {folder}", "correct it or leave it out", "E-CONFIG-FILE")
        elif not any(path.is_file() for path in Path(folder).glob("*/*")) and not any(Path(folder).glob("*/*/*")):
            mend = "see docs/your-models.md for the layout"
            yield Mistake("assets.folders", f"{folder} has no models", mend, "E-CONFIG-FILE")
    if config.assets.own_only and not config.assets.folders:
        what = "there are no models of yours"
        yield Mistake("assets.own_only", what, "name their folder in assets.folders (docs/your-models.md)")
    elif not any(config.assets.counts.values()) and not config.assets.folders:
        yield Mistake("assets", "the library would be empty", "set assets.counts or assets.folders")


def _matching(config: "Config") -> Iterator[Mistake]:
    """Views that were photographed, cousins for every rank, weights that lie where the config has them."""
    for variant in config.experiment.variants:
        matching = config.matching_of(variant)
        where = f"experiment.variants.{variant}" if config.experiment.variants[variant] else "matching"
        for key in ("views", "k_ori"):
            if getattr(matching, key) > config.assets.n_snap:
                what = f"{getattr(matching, key)} views of assets.n_snap = {config.assets.n_snap}"
                yield Mistake(f"{where}.{key}", what, "lower it or raise assets.n_snap")
        if config.generation.ranks > matching.k_cousins:
            what = f"{config.generation.ranks} scenes from {where}.k_cousins = {matching.k_cousins} cousins"
            yield Mistake("generation.ranks", what, "lower it or raise k_cousins")
        for key, folder in matching.weights().items():
            if key == "dinov2.path" and not folder:
                if list_lacking([DINOV2]):
                    yield Mistake(f"{where}.{key}", f"no {DINOV2.name} in '{FOLDER}'", "make weights", "E-CONFIG-FILE")
                continue
            files = [Path(folder, name) for name in ("config.json", "model.safetensors")]
            lacking = [file.name for file in files if not folder or not file.is_file()]
            if lacking:
                what = f"no {lacking[0]} in '{folder}'"
                yield Mistake(f"{where}.{key}", what, "the folder of the weights", "E-CONFIG-FILE")


def _environment(config: "Config") -> Iterator[Mistake]:
    """Options of the task, and of the targets that change them, that fit together."""
    found = list(_of_environment(config, "task", config.task))
    for name, target in config.experiment.targets.items():
        if target.options and not found:
            yield from _of_environment(config, f"experiment.targets.{name}.options", config.task_of(name))
    yield from found


def _of_environment(config: "Config", key: str, task: TaskConfig) -> Iterator[Mistake]:
    for axis, low, high in zip("xyz", task.workspace_min, task.workspace_max, strict=True):
        if low >= high:
            what = f"{axis} = {low:g} is not below workspace_max's {high:g}"
            yield Mistake(f"{key}.workspace_min", what, "swap them")
    if SIMULATION_FREQUENCY % task.control_frequency:
        what = f"{task.control_frequency} does not divide {SIMULATION_FREQUENCY} steps per second"
        yield Mistake(f"{key}.control_frequency", what, "e.g. 10 or 20")
    margin = config.demonstrations.goal_margin
    if task.success_fraction + margin / 2 > 1:
        what = f"{margin} past {key}.success_fraction = {task.success_fraction} cannot be reached"
        yield Mistake("demonstrations.goal_margin", what, "lower one of them")


def _stages(config: "Config") -> Iterator[Mistake]:
    """Replaced commands: scripts that can be executed, files that exist."""
    for stage, commands in config.stages.items():
        for command, own in commands.items():
            key, script = f"stages.{stage}.{command}", own.command.partition(" ")[0]
            here = script.startswith(".") or Path(script).is_file()  # else it may be in an image alone
            if "/" in script and here and not os.access(script, os.X_OK):
                mend = f"chmod +x {script}, or correct the path"
                yield Mistake(f"{key}.command", f"{script} cannot be executed", mend, "E-CONFIG-FILE")
            for name in own.code:
                if not Path(name).exists():
                    yield Mistake(f"{key}.code", f"no file or folder {name}", "correct the path", "E-CONFIG-FILE")
