# The assets of the policy experiment: who is twin, cousin, test asset (paper B.3, B.4).
# Reads:  the cousins and distances of the object that a task is about, its generated scene, the library.
# Writes: results/experiment/<variant>/<task>/assets.json.


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
        object=lambda wildcards: EXPERIMENT.tasks[wildcards.task].object,
        cousins=EXPERIMENT.cousins,
        held_out=EXPERIMENT.held_out,
    shell:
        "({params.command} --cousins {input.cousins:q} --scene-file {input.scene:q} --object {params.object:q} "
        "--task {params.task} --library {input.library:q} --distances {input.distances:q} "
        "--count {params.cousins} --held-out {params.held_out} --out {output.assets:q} && "
        "{params.check}) 2>&1 | tee {log:q}"
