"""What is wrong with the rows of the policy experiment: their objects, training sets, test assets and policies."""

from collections.abc import Iterator
from math import lcm
from typing import TYPE_CHECKING

from stages.config import places
from stages.config.experiment import TaskPlan, TaskTarget
from stages.config.mistakes import Mistake
from stages.contracts.errors import InputError
from stages.contracts.training_sets import DRAW, DRAWN, read_set
from stages.plugins import find, short

if TYPE_CHECKING:
    from stages.config.model import Config

UNSAID = TaskTarget()


def tasks(config: "Config") -> Iterator[Mistake]:
    """Tasks about objects that their scenes have and that can be opened."""
    experiment = config.experiment
    try:
        files = config.room_files()
    except InputError:
        files = {}  # said above
    if experiment.tasks and experiment.policy_variant not in experiment.variants:
        mend = f"one of {', '.join(experiment.variants)}"
        what = f"'{experiment.policy_variant}' is not one of experiment.variants"
        yield Mistake("experiment.policy_variant", what, mend, "E-CONFIG-UNKNOWN")
    for name, target in experiment.tasks.items():
        if target.assets_of:
            continue
        key, task = f"experiment.tasks.{name}", experiment.plan(name).task
        try:
            find("tasks", task, config.implementations)
        except InputError as error:
            yield Mistake.of(error, f"{key}.task" if target.task else key)
        if target.scene not in experiment.rooms:
            mend = "add it there, or remove the task: `" + name + ": null`"
            yield Mistake(f"{key}.scene", f"'{target.scene}' is not one of experiment.rooms", mend, "E-CONFIG-UNKNOWN")
        objects = places.objects(target.scene, experiment.inputs, files)
        if not objects:
            continue  # not known before the scene is read
        able = [item for item, panels in objects.items() if panels.get(task, True)]
        if target.object not in objects:
            what = f"{target.scene} has no '{target.object}'"
        elif target.object not in able:
            what = f"'{target.object}' of {target.scene} has no {task}"
        else:
            continue
        mend = f"one of {', '.join(able)}" if able else f"no object there has one; remove the task: `{name}: null`"
        yield Mistake(f"{key}.object", what, mend, "E-CONFIG-UNKNOWN")


def shared_rows(config: "Config") -> Iterator[Mistake]:
    """Rows that share another row's assets say nothing else of them."""
    rows = config.experiment.tasks
    for name, row in rows.items():
        if row.assets_of is None:
            continue
        others = [other for other, its in rows.items() if its.assets_of is None]
        if row.assets_of not in others:
            what = f"'{row.assets_of}' is no row with assets of its own"
            yield Mistake(
                f"experiment.tasks.{name}.assets_of", what, f"one of {', '.join(others) or 'none'}", "E-CONFIG-UNKNOWN"
            )
            continue
        for key in ("task", "scene", "object", "options", "assets", "episodes"):
            if getattr(row, key) not in (getattr(UNSAID, key), getattr(rows[row.assets_of], key)):
                what = f"differs from that of {row.assets_of}, whose assets the row shares"
                yield Mistake(f"experiment.tasks.{name}.{key}", what, "leave it out, or leave out assets_of")


def training_sets(config: "Config") -> Iterator[Mistake]:
    """Training sets that have cousins enough, and as many demonstrations as each other."""
    experiment = config.experiment
    for rank in experiment.held_out:
        if rank > experiment.cousins:
            what = f"there is no cousin {rank} of experiment.cousins = {experiment.cousins}"
            yield Mistake("experiment.held_out", what, "leave it out or raise experiment.cousins", "E-CONFIG-UNKNOWN")
    left = experiment.training_ranks
    asked = {"experiment.training_sets": experiment.training_sets}
    asked |= {
        f"experiment.tasks.{name}.training_sets": row.training_sets or [] for name, row in experiment.tasks.items()
    }
    for key, names in asked.items():
        for name in names:
            rule, needed, _ = read_set(name)
            if rule == "cousins" and needed > len(left):
                what = f"{name} needs {needed} cousins, experiment.cousins = {experiment.cousins} leaves {len(left)}"
                yield Mistake(key, what, "raise experiment.cousins or hold fewer out")
            if rule in DRAWN and needed > DRAW:
                yield Mistake(key, f"{name} needs {needed} assets, {DRAW} are drawn", f"{rule}_{DRAW} or fewer")
    uneven: dict[str, Mistake] = {}
    for task in experiment.tasks:
        plan, source = experiment.plan(task), experiment.source(task)
        numbers = {name: read_set(name).size for name in plan.training_sets}
        odd = [name for name, number in numbers.items() if plan.episodes % number]
        if odd:
            key = "experiment.episodes" if plan.target.episodes is None else f"experiment.tasks.{source}.episodes"
            what = f"{plan.episodes} cannot be shared evenly by the assets of {', '.join(odd)}"
            uneven[key] = Mistake(key, what, f"a multiple of {lcm(*numbers.values())}")
    yield from uneven.values()


def test_assets(config: "Config") -> Iterator[Mistake]:
    """Roles that the experiment gives."""
    experiment = config.experiment
    roles = ["twin", *(f"cousin_{rank}" for rank in range(1, experiment.cousins + 1)), "dissimilar", "trained"]
    for role in config.evaluation.test_assets:
        if role not in roles:
            what = f"there is no '{role}' among experiment.cousins = {experiment.cousins}"
            yield Mistake(
                "evaluation.test_assets",
                what,
                f"twin, cousin_1 ... {roles[-3]}, dissimilar, trained",
                "E-CONFIG-UNKNOWN",
            )
    if config.evaluation.checkpoint == "rollouts":
        for run in dict.fromkeys(run for plan in _plans(config) for run in plan.runs):
            if run in config.training.runs and not config.training.runs[run].keep:
                what = f"is rollouts, but training.runs.{run}.keep = 0 leaves no checkpoints"
                yield Mistake("evaluation.checkpoint", what, f"set training.runs.{run}.keep, or use best or last")


def simulators(config: "Config") -> Iterator[Mistake]:
    """Policies that are rolled out in a simulator that has their task."""
    for name in config.experiment.tasks:
        plan = config.experiment.plan(name)
        try:
            known = not plan.training_sets or config.simulated(name, config.evaluation.simulator)
        except InputError:
            continue  # said above
        if not known:
            what = f"{short(config.evaluation.simulator)} does not have the task {plan.task} of experiment.tasks.{name}"
            yield Mistake("evaluation.simulator", what, f"maniskill, or remove the task: `{name}: null`")


def _plans(config: "Config") -> list[TaskPlan]:
    """What is asked of the tasks for which policies are trained."""
    plans = map(config.experiment.plan, config.experiment.tasks)
    return [plan for plan in plans if plan.training_sets]


def choices(config: "Config") -> Iterator[Mistake]:
    """Hyper-parameter sets that trials choose from, whose best are pooled: one kind of policy alone (paper B.4)."""
    experiment, known = config.experiment, config.training.runs
    found: dict[str, Mistake] = {}
    for name, row in experiment.tasks.items():
        runs = [run for run in experiment.plan(name).runs if run in known]
        other = next((run for run in runs if known[run].kind != known[runs[0]].kind), None)
        if other is None or not experiment.chooses(name):
            continue
        what = f"{runs[0]} and {other} are other kinds of policies; the best of one kind alone are chosen and pooled"
        mend = f"give it a row, `{name}_{other}: {{assets_of: {experiment.source(name)}, runs: [{other}]}}`, or set "
        mend += f"experiment.best_runs: {len(runs)}, so that each is trained and has a row in the tables"
        key = "experiment.runs" if row.runs is None else f"experiment.tasks.{name}.runs"
        found.setdefault(key, Mistake(key, what, mend))
    yield from found.values()


def policies(config: "Config") -> Iterator[Mistake]:
    """Hyper-parameter sets that there are, networks that see no more points than there are, checkpoints in reach."""
    experiment, known = config.experiment, config.training.runs
    asked = {"experiment.runs": experiment.runs}
    asked |= {f"experiment.tasks.{name}.runs": row.runs or [] for name, row in experiment.tasks.items()}
    for key, runs in asked.items():
        for run in runs:
            if run not in known:
                yield Mistake(
                    key, f"'{run}' is not one of training.runs", f"one of {', '.join(known)}", "E-CONFIG-UNKNOWN"
                )
    for run in dict.fromkeys(run for runs in asked.values() for run in runs if run in known):
        options = known[run]
        points = {
            config.task_of(name).points: f"experiment.tasks.{experiment.source(name)}.options"
            if "points" in experiment.plan(name).target.options
            else "task"
            for name in experiment.tasks
            if run in experiment.plan(name).runs
        }
        if points and options.network.points > min(points):
            what = f"{options.network.points} of {points[min(points)]}.points = {min(points)}"
            yield Mistake(f"training.runs.{run}.network.points", what, "lower it or raise task.points")
        if options.keep > options.steps:
            what = f"{options.keep} checkpoints of {options.steps} steps"
            yield Mistake(f"training.runs.{run}.keep", what, "lower it")
