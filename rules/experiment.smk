# The assets of the policy experiment: who is twin, cousin, test asset (paper B.3, B.4).
# Reads:  the cousins and distances of the object that a task is about, its generated scene, the library.
# Writes: results/experiment/<variant>/<task>/assets.json, and for people assets.png.


rule select:
    """Name the assets of a task: the matched object's twin, its cousins and a dissimilar one."""
    input:
        cousins=lambda wildcards: of_target(wildcards, rules.match.output.cousins),
        distances=lambda wildcards: of_target(wildcards, rules.distances.output.distances),
        scene=lambda wildcards: of_target(wildcards, rules.generate.output.scenes[0]),
        library=rules.library.output.library,
    output:
        assets="results/experiment/{variant}/{task}/assets.json",
    log:
        "logs/experiment/{variant}_{task}.log",
    benchmark:
        "benchmarks/experiment/{variant}_{task}.tsv"
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        mem_mb=1000,
    params:
        command=command("experiment", "select"),
        code=task_code("experiment", "select"),
        check=check(task="assets"),
        task=lambda wildcards: implementation(wildcards.task),
        object=lambda wildcards: EXPERIMENT.plan(wildcards.task).target.object,
        cousins=EXPERIMENT.cousins,
        held_out=EXPERIMENT.held_out,
    shell:
        "({params.command} --cousins {input.cousins:q} --scene-file {input.scene:q} --object {params.object:q} "
        "--task {params.task} --library {input.library:q} --distances {input.distances:q} "
        "--count {params.cousins} --held-out {params.held_out} --out {output.assets:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule draw_roles:
    """Draw the assets of a task with their roles and what a gripper meets there."""
    input:
        assets=rules.select.output.assets,
        snapshots=expand(rules.snapshots.output.images, shard=SHARDS),
    output:
        picture=report(
            "results/experiment/{variant}/{task}/assets.png",
            caption="../report/captions/roles.rst",
            category="Policies",
            labels={"task": "{task}", "picture": "assets"},
        ),
    log:
        "logs/experiment/draw_{variant}_{task}.log",
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        mem_mb=1000,
    params:
        command=command("experiment", "draw"),
        code=code("experiment", "draw"),
    shell:
        "{params.command} --assets {input.assets:q} --snapshots {input.snapshots:q} --out {output.picture:q} 2>&1 "
        "| tee {log:q}"


rule experiment:
    """The assets of all tasks, and their pictures."""
    input:
        expand(rules.draw_roles.output.picture, variant=EXPERIMENT.policy_variant, task=SOURCES),
    localrule: True
