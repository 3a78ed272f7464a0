"""Contradictions in the policy experiment: its targets, pools, policies, training sets and test assets."""

from collections.abc import Iterator
from math import lcm
from pathlib import Path
from typing import TYPE_CHECKING

from roomkin.stages.config.inputs import list_objects
from roomkin.stages.config.mistakes import Mistake
from roomkin.stages.config.training import list_traits
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.policy_config import DRAW, DRAWN, read_set
from roomkin.stages.plugins import find, shorten_name

if TYPE_CHECKING:
    from roomkin.stages.config.model import Config


def targets(config: "Config") -> Iterator[Mistake]:
    """Targets that their rooms have and that can be opened."""
    experiment = config.experiment
    try:
        rooms = config.rooms()
    except InputError:
        rooms = {}  # said above
    if experiment.policy_variant not in experiment.variants:
        key = "experiment.policy_variant"
        yield Mistake.unknown(key, experiment.policy_variant, "experiment.variants", experiment.variants)
    for name, target in experiment.targets.items():
        key, task = f"experiment.targets.{name}", experiment.task(name)
        try:
            find("tasks", task, config.implementations)
        except InputError as error:
            yield Mistake.of(error, f"{key}.task" if target.task else key)
        if target.room not in experiment.rooms:
            mend = "add it there, or remove the target: `" + name + ": null`"
            yield Mistake(f"{key}.room", f"'{target.room}' is not one of experiment.rooms", mend, "E-CONFIG-UNKNOWN")
        own, room = experiment.inputs.get(target.room), rooms.get(target.room)
        objects = list_objects(Path(own.place(target.room))) if own else room() if room else {}
        if not objects:
            continue  # not known before the scene is read
        able = [item for item, panels in objects.items() if panels.get(task, True)]
        if target.object not in objects:
            what = f"{target.room} has no '{target.object}'"
        elif target.object not in able:
            what = f"'{target.object}' of {target.room} has no {task}"
        else:
            continue
        mend = f"one of {', '.join(able)}" if able else f"no object there has one; remove the target: `{name}: null`"
        yield Mistake(f"{key}.object", what, mend, "E-CONFIG-UNKNOWN")


def pools(config: "Config") -> Iterator[Mistake]:
    """Pools of targets that are one task with the same options; no target is in two."""
    experiment, pool_of = config.experiment, dict[str, str]()
    for pool, names in experiment.pools.items():
        key, known = f"experiment.pools.{pool}", [name for name in names if name in experiment.targets]
        if pool in experiment.targets:
            yield Mistake(key, "is the name of a target, too", "give the pool another name", "E-CONFIG-NAME")
        for name in names:
            if name not in known:
                yield Mistake.unknown(key, name, "experiment.targets", experiment.targets)
            if (first := pool_of.setdefault(name, pool)) != pool:
                yield Mistake(key, f"{name} is in the pool {first}, too", "leave it in one")
        about = {name: (experiment.task(name), config.task_of(name), experiment.share(name, "twin")) for name in known}
        other = next((name for name in known if about[name] != about[known[0]]), None)
        if other:
            what = f"{known[0]} and {other} differ in task, options or episodes"
            yield Mistake(key, what, "pool targets that differ in their object alone")


def training_sets(config: "Config") -> Iterator[Mistake]:
    """Training sets that have cousins enough, and as many demonstrations as each other."""
    experiment = config.experiment
    for rank in experiment.held_out:
        if rank > experiment.cousins:
            what = f"there is no cousin {rank} of experiment.cousins = {experiment.cousins}"
            yield Mistake("experiment.held_out", what, "leave it out or raise experiment.cousins", "E-CONFIG-UNKNOWN")
    left = experiment.training_ranks
    asked = {"experiment.training_sets": experiment.training_sets}
    own = experiment.policies.items()
    asked |= {f"experiment.policies.{name}.training_sets": policy.training_sets or [] for name, policy in own}
    for key, names in asked.items():
        for name in names:
            rule, needed, _ = read_set(name)
            if rule == "cousins" and needed > len(left):
                what = f"{name} needs {needed} cousins, experiment.cousins = {experiment.cousins} leaves {len(left)}"
                yield Mistake(key, what, "raise experiment.cousins or hold fewer out")
            if rule in DRAWN and needed > DRAW:
                yield Mistake(key, f"{name} needs {needed} assets, {DRAW} are drawn", f"{rule}_{DRAW} or fewer")
    uneven: dict[str, Mistake] = {}
    for name, target in experiment.targets.items():
        episodes = target.episodes or experiment.episodes
        numbers = {each: read_set(each).size for each in experiment.sets_of(name)}
        odd = [each for each, number in numbers.items() if episodes % number]
        if odd:
            key = f"experiment.targets.{name}.episodes" if target.episodes else "experiment.episodes"
            what = f"{episodes} cannot be shared evenly by the assets of {', '.join(odd)}"
            uneven[key] = Mistake(key, what, f"a multiple of {lcm(*numbers.values())}")
    yield from uneven.values()


def test_assets(config: "Config") -> Iterator[Mistake]:
    """Roles that the experiment gives."""
    experiment = config.experiment
    roles = ["twin", *(f"cousin_{rank}" for rank in range(1, experiment.cousins + 1)), "dissimilar", "trained"]
    for role in config.evaluation.test_assets:
        if role not in roles:
            what = f"there is no '{role}' among experiment.cousins = {experiment.cousins}"
            mend = f"twin, cousin_1 ... {roles[-3]}, dissimilar, trained"
            yield Mistake("evaluation.test_assets", what, mend, "E-CONFIG-UNKNOWN")
    if config.evaluation.checkpoint == "rollouts":
        plans = [plan for plan in map(experiment.plan, experiment.policies) if plan.targets and plan.training_sets]
        for name in dict.fromkeys(name for plan in plans for name in plan.configs):
            key = f"training.configs.{name}.num_checkpoints"
            if name in config.training.configs and not config.training.configs[name].num_checkpoints:
                what = f"is rollouts, but {key} = 0 leaves none"
                yield Mistake("evaluation.checkpoint", what, f"set {key}, or use best or last")


def simulators(config: "Config") -> Iterator[Mistake]:
    """Policies that are rolled out in a simulator that has their task."""
    for name in config.experiment.targets:
        try:
            known = not config.experiment.sets_of(name) or config.can_simulate(name, config.evaluation.simulator)
        except InputError:
            continue  # reported above
        if not known:
            task = config.experiment.task(name)
            simulator = shorten_name(config.evaluation.simulator)
            what = f"{simulator} does not have the task {task} of experiment.targets.{name}"
            yield Mistake("evaluation.simulator", what, f"maniskill, or remove the target: `{name}: null`")


def policies(config: "Config") -> Iterator[Mistake]:
    """Policies that are trained by configs that there are, for targets that there are."""
    experiment, known = config.experiment, config.training.configs
    for name, policy in experiment.policies.items():
        key = f"experiment.policies.{name}"
        for each in experiment.plan(name).configs:
            if each not in known:
                yield Mistake.unknown(f"{key}.configs" if policy.configs else key, each, "training.configs", known)
        for target in policy.targets or ():
            if target not in experiment.targets and target not in experiment.pools:
                there = [*experiment.targets, *experiment.pools]
                yield Mistake.unknown(f"{key}.targets", target, "experiment.targets", there)


def check_choices(config: "Config") -> Iterator[Mistake]:
    """Policies of several configs: of one kind, of which rollouts choose the best (paper B.4)."""
    experiment, known = config.experiment, config.training.configs
    for name in experiment.policies:
        configs, key = experiment.plan(name).configs, f"experiment.policies.{name}.configs"
        kinds = {list_traits(known[each]): each for each in reversed(configs) if each in known}
        mend = "a policy for each: `policies: {" + ", ".join(f"{each}: {{}}" for each in configs) + "}`"
        if len(kinds) > 1:
            first, other, *_ = reversed(kinds.values())
            yield Mistake(key, f"{first} and {other} are other kinds of policies, which are never pooled", mend)
        elif 1 < len(configs) <= experiment.best_configs:
            what = f"{' and '.join(configs)} are no more than experiment.best_configs = {experiment.best_configs}"
            yield Mistake(key, what, f"{mend}, or lower best_configs: selection rollouts choose so many")


def networks(config: "Config") -> Iterator[Mistake]:
    """Networks that see no more points than there are, checkpoints in reach."""
    experiment, known = config.experiment, config.training.configs
    plans = [experiment.plan(name) for name in experiment.policies]
    for each in dict.fromkeys(each for plan in plans for each in plan.configs if each in known):
        options = known[each]
        opened = [name for plan in plans if each in plan.configs for name in plan.targets if name in experiment.targets]
        points = {config.task_of(name).points: name for name in opened}
        if options.points > (least := min(points, default=options.points)):
            own = "points" in experiment.targets[points[least]].options
            where = f"experiment.targets.{points[least]}.options" if own else "task"
            what = f"{options.points} of {where}.points = {least}"
            yield Mistake(f"training.configs.{each}.points", what, "lower it or raise task.points")
        if options.num_checkpoints > options.steps:
            what = f"{options.num_checkpoints} checkpoints of {options.steps} steps"
            yield Mistake(f"training.configs.{each}.num_checkpoints", what, "lower it")
