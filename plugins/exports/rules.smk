# Scenes, demonstrations and policies for people without this workflow; `snakemake exports`, no part of `all`.
# Reads:  generated scenes; the demonstrations of a training set; a policy.
# Writes: results/exports/scenes/<format>/<variant>/<scene>/rank_<n>/,
#         results/exports/demonstrations/<format>/<target>/<training set>/, results/exports/policies/<target>/.../seed_<n>/.

from plugins.exports.package import with_portable_form


rule export_scenes:
    """The generated scenes of one room in another tool's format."""
    input:
        **LIBRARY,
        scenes=rules.generate.output.scenes,
        look=rules.draw_scenes.output.look,
    output:
        folder=directory("results/exports/scenes/{format}/{variant}/{scene}"),
    log:
        "logs/exports/scenes_{format}_{variant}_{scene}.log",
    benchmark:
        "benchmarks/exports/scenes_{format}_{variant}_{scene}.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(2000, 30),
    params:
        command=command("exports", "scenes"),
        code=lambda wildcards: code("exports", "scenes", f"plugins.exports.scene_formats.{wildcards.format}"),
    shell:
        "{params.command} --scenes {input.scenes:q} --library {input.library:q} --format {wildcards.format} "
        "--look {input.look:q} --out {output.folder:q} 2>&1 | tee {log:q}"


rule export_demonstrations:
    """The demonstrations of a training set, if it was drawn by chance of all draws, in another tool's format."""
    input:
        **LIBRARY,
        episodes=lambda wildcards: files(
            rules.demonstrate.output.episodes,
            target=wildcards.target,
            role=EXPERIMENT.roles_of(wildcards.target, wildcards.training_set),
        ),
    output:
        folder=directory("results/exports/demonstrations/{format}/{target}/{training_set}"),
    log:
        "logs/exports/{format}_{target}_{training_set}.log",
    benchmark:
        "benchmarks/exports/{format}_{target}_{training_set}.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(3000, 60),
    params:
        command=command("exports", "demonstrations"),
        code=task_code("exports", "demonstrations"),
    shell:
        "{params.command} --episodes {input.episodes:q} --format {wildcards.format} --library {input.library:q} "
        "--out {output.folder:q} 2>&1 | tee {log:q}"


rule export_policy:
    """A policy with a loader that needs torch and safetensors alone."""
    input:
        config=rules.train.output.config,
        policy=rules.train.output.policy,
    output:
        folder=directory("results/exports/policies/{target}/{policy}/{training_set}/{run}/seed_{seed}"),
    log:
        "logs/exports/{target}_{policy}_{training_set}_{run}_{seed}.log",
    benchmark:
        "benchmarks/exports/{target}_{policy}_{training_set}_{run}_{seed}.tsv"
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(2000, 10),
    params:
        command=command("exports", "policy"),
        code=lambda wildcards: code("exports", "policy", *modules(CONFIG.training.runs[wildcards.run], "policy")),
        action=CONFIG.evaluation.action,
        policy=subpath(input.policy, parent=True),
    shell:
        "{params.command} --policy {params.policy:q} --action {params.action} --out {output.folder:q} 2>&1 | tee {log:q}"


rule exports:
    """All scenes and demonstrations of this run in all formats, and its policies that have a portable form."""
    input:
        files(rules.export_scenes.output.folder, format=["glb", "urdf", "mjcf", "usd"], variant=VARIANTS, scene=ROOMS),
        with_portable_form(policies(rules.export_policy.output.folder), CONFIG.training.runs),
        [
            folder
            for name in TARGETS
            for folder in files(
                rules.export_demonstrations.output.folder,
                format=["robomimic", "lerobot", "maniskill"],
                target=name,
                training_set=EXPERIMENT.sets_of(name),
            )
        ],
    localrule: True
