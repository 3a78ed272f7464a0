# Helpers: files and code of the policy experiment, row by row. Nothing here makes a file.


def implementation(task):
    """The implementation of a row of the policy experiment."""
    return CONFIG.implementation("tasks", EXPERIMENT.plan(task).task)


def task_code(stage, verb):
    """The code of a verb that works on a task."""
    return lambda wildcards: code(stage, verb, qualified("tasks", implementation(wildcards.task)))


def tested(wildcards):
    """The modules of a task and of the simulator that a job of evaluation meets it in."""
    condition = wildcards.get("condition")
    simulator = (CONFIG.evaluation.under(condition) if condition else CONFIG.evaluation).simulator
    return [qualified("tasks", implementation(wildcards.task)), qualified("simulators", simulator)]


def policy_code(verb):
    """The code of a verb of evaluation that rolls policies out: of the task, the simulator and the policy."""

    def digest(wildcards):
        policy = modules(CONFIG.training.runs[wildcards.run], "policy")
        return code("evaluation", verb, *tested(wildcards), *policy)

    return digest


def runs_of(task, training_set):
    """The hyper-parameter sets that are trained with all seeds; if they must be chosen first, Snakemake waits."""
    if not EXPERIMENT.chooses(task):
        return EXPERIMENT.plan(task).runs
    with checkpoints.choose.get(task=task, training_set=training_set).output.chosen.open() as file:
        return json.load(file)["runs"]


def policies_of(task, training_set, pattern, **more):
    """The files of `pattern` for the policies of one training set, one per run and seed; `more`: other wildcards."""
    runs, seeds = runs_of(task, training_set), EXPERIMENT.plan(task).seeds
    return files(pattern, task=task, training_set=training_set, run=runs, seed=seeds, **more)


def cells(pattern):
    """The files of `pattern` for every task and training set."""
    return [
        file for task in TASKS for file in files(pattern, task=task, training_set=EXPERIMENT.plan(task).training_sets)
    ]


def policies(pattern, first=False):
    """A function of what Snakemake calls a job's inputs: the files of `pattern` for all policies of this run.

    first: only one policy per training set and method: the first seed, of sets that were chosen that of the best.
    """

    def found(wildcards):
        sets = [(task, name) for task in TASKS for name in EXPERIMENT.plan(task).training_sets]
        kept = []
        for task, name in sets:
            all_files = policies_of(task, name, pattern)
            per_method = len(all_files) if EXPERIMENT.chooses(task) else len(EXPERIMENT.plan(task).seeds)
            kept += all_files[::per_method] if first else all_files
        return kept

    return found


def possible_policies(pattern):
    """The files of `pattern` for all policies that this run might train, whichever are chosen."""
    plans = {task: EXPERIMENT.plan(task) for task in TASKS}
    return [
        file
        for task, plan in plans.items()
        for file in files(pattern, task=task, training_set=plan.training_sets, run=plan.runs, seed=plan.seeds)
    ]


def trained(pattern):
    """The files of `pattern` for every task and role on which demonstrations are collected."""
    return [file for task in SOURCES for file in files(pattern, task=task, role=EXPERIMENT.trained_roles(task))]


def demonstrated(pattern, tasks=SOURCES, **more):
    """The files of `pattern` for every task that policies are trained for, once for rows that share their assets."""
    return files(pattern, task=[task for task in tasks if EXPERIMENT.sets_of(task)], **more)


def of_target(wildcards, pattern):
    """The file of `pattern` for a task's object or for the scene that holds it."""
    target = EXPERIMENT.plan(wildcards.task).target
    return files(pattern, variant=wildcards.variant, scene=target.scene, object=target.object)


def task_scenes(wildcards):
    """The generated scenes in which a task is demonstrated: of the first ranks, with the task's object in them."""
    pattern = "results/generation/{variant}/{scene}/scene_{rank}.json"
    scene = EXPERIMENT.plan(wildcards.task).target.scene
    return expand(pattern, variant=EXPERIMENT.policy_variant, scene=scene, rank=RANKS[: EXPERIMENT.in_scene])


def in_scenes(pattern):
    """The files of `pattern` for every task that is demonstrated inside generated scenes."""
    return files(pattern, task=SOURCES) if EXPERIMENT.in_scene else []


def task_assets(task):
    """The file that names the assets of a task's policy experiment; it may be another row's."""
    return f"results/experiment/{EXPERIMENT.policy_variant}/{EXPERIMENT.source(task)}/assets.json"


def under_conditions(wildcards):
    """The rollouts of all skills and policies under every condition whose simulator has their task."""
    if not CONFIG.evaluation.conditions:
        raise WorkflowError("evaluation.conditions: is empty. Fix: name some, e.g. {mujoco: {simulator: mujoco}}")
    found = []
    for condition in CONFIG.evaluation.conditions:
        simulator = CONFIG.evaluation.under(condition).simulator
        tasks = [task for task in TASKS if CONFIG.simulated(task, simulator)]
        found += demonstrated(rules.skill_under.output.rollouts, tasks, condition=condition)
        for task in tasks:
            for name in EXPERIMENT.plan(task).training_sets:
                found += policies_of(task, name, rules.rollout_under.output.rollouts, condition=condition)
    return found
