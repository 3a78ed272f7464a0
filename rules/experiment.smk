# The assets of the policy experiment: who is twin, cousin, test asset (paper B.3, B.4).
# Reads:  the cousins and distances of the object that is opened, its generated scene, the library, the room's truth;
#         or a committed file of the assets (experiment.targets.<target>.assets), and the library alone.
# Writes: results/experiment/<variant>/<target>/assets.json, and for people assets.png, splits.png.


rule select:
    """Name the assets of a target: the object's twin, its cousins, a dissimilar one, those of training and test."""
    input:
        **LIBRARY,
        cousins=lambda wildcards: of_target(wildcards, rules.match.output.cousins),
        distances=lambda wildcards: of_target(wildcards, rules.distances.output.distances),
        scene=lambda wildcards: of_target(wildcards, rules.generate.output.scenes[0]),
        truth=known_truth,
        objects=lambda wildcards: of_target(wildcards, rules.extract.output.objects),
    output:
        assets="results/experiment/{variant}/{target}/assets.json",
    log:
        "logs/experiment/{variant}_{target}.log",
    benchmark:
        "benchmarks/experiment/{variant}_{target}.tsv"
    wildcard_constraints:
        target="|".join(name for name in TARGETS if name not in PINNED) or "-",
    localrule: True
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(1000, 10),
    params:
        command=command("experiment", "select"),
        code=task_code("experiment", "select"),
        check=check(task="assets"),
        task=lambda wildcards: implementation(wildcards.target),
        object=lambda wildcards: EXPERIMENT.targets[wildcards.target].object,
        cousins=EXPERIMENT.cousins,
        held_out=EXPERIMENT.held_out,
        truth=truth_flags,
        test_assets=max(40, CONFIG.evaluation.assets),
        draws=EXPERIMENT.draws,
        seed=CONFIG.seed,
    shell:
        "({params.command} --cousins {input.cousins:q} --scene-file {input.scene:q} --object {params.object:q} "
        "--task {params.task} --library {input.library:q} --distances {input.distances:q} "
        "--count {params.cousins} --held-out {params.held_out} {params.truth} "
        "--test-assets {params.test_assets} --draws {params.draws} --seed {params.seed} --out {output.assets:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule pinned:
    """Take the assets of a target from a committed file, if the library has the very same models."""
    input:
        **LIBRARY,
        assets=lambda wildcards: PINNED[wildcards.target],
    output:
        assets="results/experiment/{variant}/{target}/assets.json",
    log:
        "logs/experiment/pinned_{variant}_{target}.log",
    benchmark:
        "benchmarks/experiment/{variant}_{target}.tsv"
    wildcard_constraints:
        target="|".join(PINNED) or "-",
    localrule: True
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(1000, 10),
    params:
        command=command("experiment", "pinned"),
        code=task_code("experiment", "pinned"),
        check=check(task="assets"),
        task=lambda wildcards: implementation(wildcards.target),
    shell:
        "({params.command} --assets {input.assets:q} --task {params.task} --library {input.library:q} "
        "--out {output.assets:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule draw_roles:
    """Draw the assets of a target with their roles and what a gripper meets there."""
    input:
        assets=lambda wildcards: target_assets(wildcards.target),
        snapshots=files(rules.snapshots.output.images, shard=SHARDS),
        indices=files(rules.snapshots.output.index, shard=SHARDS),
    output:
        picture=report(
            "results/experiment/{variant}/{target}/assets.png",
            caption="../report/captions/roles.rst",
            category="Policies",
            labels={"target": "{target}", "picture": "assets"},
        ),
        splits=report(
            "results/experiment/{variant}/{target}/splits.png",
            caption="../report/captions/roles.rst",
            category="Policies",
            labels={"target": "{target}", "picture": "validation and test assets"},
        ),
    log:
        "logs/experiment/draw_{variant}_{target}.log",
    localrule: True
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(1000, 10),
    params:
        command=command("experiment", "draw"),
        code=code("experiment", "draw"),
    shell:
        "{params.command} --assets {input.assets:q} --snapshots {input.snapshots:q} --out {output.picture:q} "
        "--splits {output.splits:q} 2>&1 | tee {log:q}"


rule experiment:
    """The assets of all targets, and their pictures."""
    input:
        [target_assets(name) for name in TARGETS],
        files(rules.draw_roles.output.picture, variant=EXPERIMENT.policy_variant, target=TARGETS),
    localrule: True
