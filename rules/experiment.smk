# The assets of the policy experiment: who is twin, cousin, test asset (paper B.3, B.4).
# Reads:  the cousins and distances of the object that is opened, its generated scene, the library, the room's truth;
#         or a committed file of the assets (experiment.targets.<target>.assets), and the library alone.
# Writes: results/experiment/<variant>/<target>/assets.json.


container: CONFIG.containers.learning


rule select:
    """Name the assets of a target: the object's twin, its cousins, a dissimilar one, those of training and test."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        cousins=expand("results/matching/{variant}/{room}/cousins.json", room=target_room, allow_missing=True),
        distances=expand(
            "results/matching/{variant}/{room}/distances/{object}.json",
            room=target_room,
            object=target_object,
            allow_missing=True,
        ),
        scene=expand("results/generation/{variant}/{room}/scene_1.json", room=target_room, allow_missing=True),
        truth=expand("results/scenes/{room}/truth.json", room=known_scene),
        objects=expand("results/extraction/{room}/objects.json", room=target_room),
    output:
        assets="results/experiment/{variant}/{target}/assets.json",
    log:
        "logs/experiment/{variant}_{target}.log",
    benchmark:
        "benchmarks/experiment/{variant}_{target}.tsv"
    wildcard_constraints:
        target="|".join(name for name in TARGETS if name not in PINNED) or "-",
    localrule: True
    resources:
        **needs(1000, 10),
    params:
        **command("experiment", "select", uses=task_modules, task="assets"),
        task=task,
        object=target_object,
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


rule experiment:
    """The assets of all targets."""
    input:
        expand("results/experiment/{variant}/{target}/assets.json", variant=POLICY_VARIANT, target=TARGETS),
    localrule: True
