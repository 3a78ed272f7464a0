# Helpers: files and code of the policy experiment, cell by cell. Nothing here makes a file.
from stages.config.targets import Cell


def implementation(target):
    """The implementation of a target's task."""
    return CONFIG.implementation("tasks", EXPERIMENT.task(target))


def task_code(stage, verb):
    """The code of a verb that works on a task."""
    return lambda wildcards: code(stage, verb, qualify_module("tasks", implementation(wildcards.target)))


def tested(wildcards):
    """The modules of a task and of the simulator that a job of evaluation meets it in."""
    condition = wildcards.get("condition")
    simulator = (CONFIG.evaluation.under(condition) if condition else CONFIG.evaluation).simulator
    return [qualify_module("tasks", implementation(wildcards.target)), qualify_module("simulators", simulator)]


def policy_code(verb):
    """The code of a verb of evaluation that rolls policies out: of the task, the simulator and the policy."""

    def digest(wildcards):
        policy = modules(CONFIG.training.runs[wildcards.run], "policy")
        return code("evaluation", verb, *tested(wildcards), *policy)

    return digest


def policies_of(cell, pattern, **more):
    """The files of `pattern` for the policies of a cell, one per run and seed; `more`: other wildcards.

    If its runs must be chosen first, Snakemake waits.
    """
    plan = EXPERIMENT.plan(cell.policy)
    runs = plan.runs
    if EXPERIMENT.chooses(cell.policy):
        with checkpoints.choose.get(**cell._asdict()).output.chosen.open() as file:
            runs = json.load(file)["runs"]
    return files(pattern, **cell._asdict(), run=runs, seed=plan.seeds, **more)


def cells(pattern):
    """The files of `pattern` for every cell."""
    return [file for cell in EXPERIMENT.cells for file in files(pattern, **cell._asdict())]


def policies(pattern, first=False):
    """A function of what Snakemake calls a job's inputs: the files of `pattern` for all policies of this run.

    first: only one policy per cell: the first seed, of runs that were chosen that of the best.
    """
    return lambda wildcards: [
        file for cell in EXPERIMENT.cells for file in policies_of(cell, pattern)[: 1 if first else None]
    ]


def possible_policies(pattern):
    """The files of `pattern` for all policies that this run might train, whichever are chosen."""
    plans = {cell: EXPERIMENT.plan(cell.policy) for cell in EXPERIMENT.cells}
    return [
        file
        for cell, plan in plans.items()
        for file in files(pattern, **cell._asdict(), run=plan.runs, seed=plan.seeds)
    ]


def trained(pattern):
    """The files of `pattern` for every target and role on which demonstrations are collected."""
    return [file for name in TARGETS for file in files(pattern, target=name, role=EXPERIMENT.trained_roles(name))]


def demonstrated(pattern, targets=TARGETS, **more):
    """The files of `pattern` for every target that policies are trained for."""
    return files(pattern, target=[name for name in targets if EXPERIMENT.sets_of(name)], **more)


def of_target(wildcards, pattern):
    """The file of `pattern` for a target's object or for the scene that holds it."""
    target = EXPERIMENT.targets[wildcards.target]
    return files(pattern, variant=wildcards.variant, scene=target.room, object=target.object)


def target_scenes(wildcards):
    """The generated scenes in which a task is demonstrated: of the first ranks, with the target in them."""
    pattern = "results/generation/{variant}/{scene}/scene_{rank}.json"
    room = EXPERIMENT.targets[wildcards.target].room
    return expand(pattern, variant=EXPERIMENT.policy_variant, scene=room, rank=RANKS[: EXPERIMENT.in_scene])


def in_scenes(pattern):
    """The files of `pattern` for every target that is demonstrated inside generated scenes."""
    return files(pattern, target=TARGETS) if EXPERIMENT.in_scene else []


def target_assets(target):
    """The file that names the assets of a target."""
    return f"results/experiment/{EXPERIMENT.policy_variant}/{target}/assets.json"
