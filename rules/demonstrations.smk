# Automatic demonstrations by the skills, successes only (paper A.4, A.5), and some inside generated scenes (Figure 7).
# Reads:  the assets of a target, generated scenes, the library.
# Writes: results/demonstrations/<target>/<role>/{episodes.h5,attempts.jsonl,film.png,films.zip},
#         results/demonstrations/<target>/in_scene/{in_scene.json,episodes.zip,film.png,films.zip}.


rule demonstrate:
    """Collect the demonstrations of one asset."""
    input:
        **LIBRARY,
        assets=lambda wildcards: target_assets(wildcards.target),
    output:
        **filmed(
            "demonstrations",
            "collect",
            "results/demonstrations/{target}/{role}",
            target="{target}",
            asset="{role}",
        ),
        episodes="results/demonstrations/{target}/{role}/episodes.h5",
        attempts="results/demonstrations/{target}/{role}/attempts.jsonl",
    log:
        "logs/demonstrations/{target}_{role}.log",
    benchmark:
        "benchmarks/demonstrations/{target}_{role}.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(3000, lambda wildcards: 15 + EXPERIMENT.episodes_of(wildcards.target, wildcards.role) / 5),
    params:
        command=command("demonstrations", "collect"),
        code=task_code("demonstrations", "collect"),
        check=check(episodes="episodes", attempts="attempts"),
        options=options("demonstrations", "collect"),
        task_options=lambda wildcards: CONFIG.task_of(wildcards.target).model_dump_json(),
        episodes=lambda wildcards: EXPERIMENT.episodes_of(wildcards.target, wildcards.role),
        seed=CONFIG.seed,
    shell:
        "({params.command} --assets {input.assets:q} --library {input.library:q} --role {wildcards.role} "
        "--episodes {params.episodes} --options {params.options:q} --task-options {params.task_options:q} "
        "--seed {params.seed} --out {output.episodes:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule demonstrate_in_scene:
    """Demonstrate a task once in the generated scene of every rank, furniture in the way."""
    input:
        **LIBRARY,
        scenes=target_scenes,
    output:
        **(
            {}
            if "scene" in CONFIG.stages.get("demonstrations", {})
            else {name: f"results/demonstrations/{{target}}/in_scene/{file}" for name, file in FILMS.items()}
        ),
        in_scene="results/demonstrations/{target}/in_scene/in_scene.json",
        episodes="results/demonstrations/{target}/in_scene/episodes.zip",
    log:
        "logs/demonstrations/{target}_in_scene.log",
    benchmark:
        "benchmarks/demonstrations/{target}_in_scene.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(3000, 60),
    params:
        command=command("demonstrations", "scene"),
        code=task_code("demonstrations", "scene"),
        check=check(in_scene="in_scene"),
        options=options("demonstrations", "scene"),
        task_options=lambda wildcards: CONFIG.task_of(wildcards.target).model_dump_json(),
        task=lambda wildcards: implementation(wildcards.target),
        object=lambda wildcards: EXPERIMENT.targets[wildcards.target].object,
        seed=CONFIG.seed,
        out=subpath(output.in_scene, parent=True),
    shell:
        "({params.command} --scenes {input.scenes:q} --object {params.object:q} --task {params.task} "
        "--library {input.library:q} --options {params.options:q} --task-options {params.task_options:q} "
        "--seed {params.seed} --out {params.out:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule demonstrations:
    """Demonstrations of every asset that a training set uses, and those inside generated scenes."""
    input:
        trained(rules.demonstrate.output.episodes),
        in_scenes(rules.demonstrate_in_scene.output.in_scene),
    localrule: True
