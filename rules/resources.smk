# Helpers: what jobs ask an engine for, and which of them are one submission (docs/cluster.md). No rules.


def needs(mem_mb, minutes, gpu=False):
    """Resources of a rule: megabytes and minutes, numbers or functions of wildcards, as much again at each new attempt.

    gpu: whether it asks for a GPU if the config says `device: cuda`. `step` keeps jobs of one submission from running
    at once (profiles/slurm), so that it asks for no more than its largest job.
    """

    def grown(amount):
        def at(wildcards, attempt):
            return round((amount(wildcards) if callable(amount) else amount) * attempt)

        return at

    asked = {"mem_mb": grown(mem_mb), "runtime": grown(minutes), "step": 1}
    return asked | ({"gpu": 1} if gpu and CONFIG.device == "cuda" else {})


def models_in(wildcards):
    """How many models a shard has."""
    if wildcards.shard in OWN_SHARDS:
        return len(OWN_SHARDS[wildcards.shard].models)
    if wildcards.shard.startswith("part_"):
        return min(LIBRARY_SIZE, 200)
    return -(-sum(CONFIG.assets.counts.values()) // max(len(PROCEDURAL_SHARDS), 1))


def views_in(wildcards):
    """How many pictures are taken of a shard's models."""
    return models_in(wildcards) * CONFIG.assets.n_snap


def episodes_of(wildcards):
    """How many demonstrations are collected on an asset."""
    return EXPERIMENT.episodes_of(wildcards.target, wildcards.role)


def selection_episodes(wildcards):
    """How many episodes one policy is tried for."""
    return CONFIG.evaluation.selection_rollouts * max(1, CONFIG.training.configs[wildcards.run].num_checkpoints)


def training_minutes(wildcards):
    """Three times what a config takes: measured on one core, for a GPU reckoned at 20 TFLOP/s."""
    options = CONFIG.training.configs[wildcards.run]
    width, layers = options.kwargs.get("pointnet_width", 1), options.kwargs.get("pointnet_layers", 1)
    seconds = 3e-13 if CONFIG.device == "cuda" else 2.5e-11
    clouds = options.batch_size * options.horizon * options.points
    products = clouds * width * (8 + width * (layers - 1))
    return 30 + 3 * options.steps * (0.015 + seconds * products) / 60


# Submissions of several jobs, which share a shell: profiles/podman gives every rule its own.
GROUPED = not any("shell_exec" in asked for asked in workflow.resource_settings.overwrite_resources.values())
SHARD_GROUP = "shard" if GROUPED else None


def scene_group(wildcards):
    """The submission of a job about one scene: one per variant, the first makes what they share.

    None, for a picture alone: its jobs await a checkpoint, for which Snakemake has no groups.
    """
    alone = PICTURE and wildcards.get("scene") == PICTURE
    return f"scene_{wildcards.get('variant', VARIANTS[0])}" if GROUPED and not alone else None
