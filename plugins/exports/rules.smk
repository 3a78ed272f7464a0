# Scenes, demonstrations and policies for people without this workflow; `snakemake exports`, no part of `all`.
# Reads:  generated scenes; the demonstrations of a training set; a policy.
# Writes: results/exports/scenes/<format>/<variant>/<scene>/rank_<n>/,
#         results/exports/demonstrations/<format>/<target>/<training set>/, results/exports/policies/<target>/.../seed_<n>/.


container: CONFIG.containers.simulation


from roomkin.plugins.exports.package import with_portable_form


rule export_scenes:
    """The generated scenes of one room in another tool's format."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        scenes=expand("results/generation/{variant}/{scene}/scene_{rank}.json", rank=RANKS, allow_missing=True),
        look="results/generation/{variant}/{scene}/look.json",
    output:
        folder=directory("results/exports/scenes/{format}/{variant}/{scene}"),
    log:
        "logs/exports/scenes_{format}_{variant}_{scene}.log",
    benchmark:
        "benchmarks/exports/scenes_{format}_{variant}_{scene}.tsv"
    resources:
        **needs(2000, 30),
    params:
        **command(
            "exports", "scenes", uses=lambda wildcards: [f"roomkin.plugins.exports.scene_formats.{wildcards.format}"]
        ),
    shell:
        "{params.command} --scenes {input.scenes:q} --library {input.library:q} --format {wildcards.format} "
        "--look {input.look:q} --out {output.folder:q} 2>&1 | tee {log:q}"


rule export_demonstrations:
    """The demonstrations of a training set, if it was drawn by chance of all draws, in another tool's format."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        episodes=expand(
            "results/demonstrations/{target}/{role}/episodes.h5",
            role=lambda wildcards: EXPERIMENT.roles_of(wildcards.target, wildcards.training_set),
            allow_missing=True,
        ),
    output:
        folder=directory("results/exports/demonstrations/{format}/{target}/{training_set}"),
    log:
        "logs/exports/{format}_{target}_{training_set}.log",
    benchmark:
        "benchmarks/exports/{format}_{target}_{training_set}.tsv"
    resources:
        **needs(3000, 60),
    params:
        **command("exports", "demonstrations", uses=task_modules),
    shell:
        "{params.command} --episodes {input.episodes:q} --format {wildcards.format} --library {input.library:q} "
        "--out {output.folder:q} 2>&1 | tee {log:q}"


rule export_policy:
    """A policy with a loader that needs torch and safetensors alone."""
    input:
        config="results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/config.json",
        policy="results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/policy.safetensors",
    output:
        folder=directory("results/exports/policies/{target}/{policy}/{training_set}/{run}/seed_{seed}"),
    log:
        "logs/exports/{target}_{policy}_{training_set}_{run}_{seed}.log",
    benchmark:
        "benchmarks/exports/{target}_{policy}_{training_set}_{run}_{seed}.tsv"
    container:
        CONFIG.containers.learning
    resources:
        **needs(2000, 10),
    params:
        **command("exports", "policy", uses=policy_modules),
        action=CONFIG.evaluation.action,
        policy=subpath(input.policy, parent=True),
    shell:
        "{params.command} --policy {params.policy:q} --action {params.action} --out {output.folder:q} 2>&1 | tee {log:q}"


rule exports:
    """All scenes and demonstrations of this run in all formats, and its policies that have a portable form."""
    input:
        expand(
            "results/exports/scenes/{format}/{variant}/{scene}",
            format=["glb", "urdf", "mjcf", "usd"],
            variant=VARIANTS,
            scene=ROOMS,
        ),
        with_portable_form(
            policies("results/exports/policies/{target}/{policy}/{training_set}/{run}/seed_{seed}"),
            CONFIG.training.configs,
        ),
        [
            folder
            for name in TARGETS
            for folder in expand(
                "results/exports/demonstrations/{format}/{target}/{training_set}",
                format=["robomimic", "lerobot", "maniskill"],
                target=name,
                training_set=EXPERIMENT.sets_of(name),
            )
        ],
    localrule: True
