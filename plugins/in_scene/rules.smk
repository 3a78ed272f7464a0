# Demonstrations inside generated scenes, with furniture in the way (the paper's Figure 7).
# Reads:  generated scenes, the library.
# Writes: results/demonstrations/<target>/in_scene/{in_scene.json,episodes.zip,film.png,films.zip}.


container: CONFIG.containers.simulation


rule demonstrate_in_scene:
    """Demonstrate a task once in the generated scene of every rank, furniture in the way."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        scenes=expand(
            "results/generation/{variant}/{room}/scene_{rank}.json",
            variant=POLICY_VARIANT,
            room=target_room,
            rank=RANKS[: EXPERIMENT.in_scene],
        ),
    output:
        **unless_replaced(
            "in_scene",
            "demonstrate",
            film="results/demonstrations/{target}/in_scene/film.png",
            films="results/demonstrations/{target}/in_scene/films.zip",
        ),
        in_scene="results/demonstrations/{target}/in_scene/in_scene.json",
        episodes="results/demonstrations/{target}/in_scene/episodes.zip",
    log:
        "logs/demonstrations/{target}_in_scene.log",
    benchmark:
        "benchmarks/demonstrations/{target}_in_scene.tsv"
    resources:
        **needs(3000, 60),
    params:
        **command("in_scene", "demonstrate", uses=task_modules, in_scene="in_scene"),
        task_options=task_options,
        task=task,
        object=target_object,
        seed=CONFIG.seed,
        out=subpath(output.in_scene, parent=True),
    shell:
        "({params.command} --scenes {input.scenes:q} --object {params.object:q} --task {params.task} "
        "--library {input.library:q} --options {params.options:q} --task-options {params.task_options:q} "
        "--seed {params.seed} --out {params.out:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


ADDED["demonstrations"] += expand(
    rules.demonstrate_in_scene.output.in_scene, target=TARGETS if EXPERIMENT.in_scene else []
)
