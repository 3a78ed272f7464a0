# Automatic demonstrations by the Open skill, successes only (paper A.4, A.5).
# Reads:  the assets of a task, the library.
# Writes: results/demonstrations/<task>/<role>/{episodes.h5,attempts.jsonl,film.png,films/}.


rule demonstrate:
    """Collect the demonstrations of one asset."""
    input:
        assets=lambda wildcards: task_assets(wildcards.task),
        library=rules.library.output.library,
    output:
        **filmed(
            "demonstrations",
            "collect",
            "results/demonstrations/{task}/{role}",
            task="{task}",
            asset="{role}",
        ),
        episodes="results/demonstrations/{task}/{role}/episodes.h5",
        attempts="results/demonstrations/{task}/{role}/attempts.jsonl",
    log:
        "logs/demonstrations/{task}_{role}.log",
    benchmark:
        "benchmarks/demonstrations/{task}_{role}.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        mem_mb=3000,
    params:
        command=command("demonstrations", "collect"),
        code=task_code("demonstrations", "collect"),
        check=check(episodes="episodes", attempts="attempts"),
        options=options("demonstrations", "collect"),
        task_options=lambda wildcards: CONFIG.task_of(wildcards.task).model_dump_json(),
        episodes=lambda wildcards: EXPERIMENT.episodes_of(wildcards.task, wildcards.role),
        seed=CONFIG.seed,
    shell:
        "({params.command} --assets {input.assets:q} --library {input.library:q} --role {wildcards.role} "
        "--episodes {params.episodes} --options {params.options:q} --task-options {params.task_options:q} "
        "--seed {params.seed} --out {output.episodes:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule demonstrations:
    """Demonstrations of every asset that a training set uses."""
    input:
        trained(rules.demonstrate.output.episodes),
    localrule: True
