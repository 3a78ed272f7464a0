# Automatic demonstrations by the skills, successes only (paper A.4, A.5).
# Reads:  the assets of a target, the library.
# Writes: results/demonstrations/<target>/<role>/{episodes.h5,attempts.jsonl,film.png,films.zip}.


container: CONFIG.containers.simulation


rule demonstrate:
    """Collect the demonstrations of one asset."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        assets=f"results/experiment/{POLICY_VARIANT}/{{target}}/assets.json",
    output:
        **unless_replaced(
            "demonstrations",
            "collect",
            film="results/demonstrations/{target}/{role}/film.png",
            films="results/demonstrations/{target}/{role}/films.zip",
        ),
        episodes="results/demonstrations/{target}/{role}/episodes.h5",
        attempts="results/demonstrations/{target}/{role}/attempts.jsonl",
    log:
        "logs/demonstrations/{target}_{role}.log",
    benchmark:
        "benchmarks/demonstrations/{target}_{role}.tsv"
    resources:
        **needs(3000, lambda wildcards: 15 + episodes_of(wildcards) / 5),
    params:
        **command(
            "demonstrations",
            "collect",
            uses=with_films("demonstrations", task_modules),
            episodes="episodes",
            attempts="attempts",
        ),
        task_options=task_options,
        episodes=episodes_of,
        films=FILMS["demonstrations"],
        seed=CONFIG.seed,
    shell:
        "({params.command} --assets {input.assets:q} --library {input.library:q} --role {wildcards.role} "
        "--episodes {params.episodes} --options {params.options:q} --task-options {params.task_options:q} "
        "--films {params.films:q} --seed {params.seed} --out {output.episodes:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule demonstrations:
    """Demonstrations of every asset that a training set uses, and those inside generated scenes."""
    input:
        expand("results/demonstrations/{target}/{role}/episodes.h5", zip, **DEMONSTRATED),
        added("demonstrations"),
    localrule: True
