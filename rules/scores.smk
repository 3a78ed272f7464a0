# Scores of the generated scenes, one row per object (command `score` of `evaluation`; paper B.1).
# Reads:  generated scenes and the truth of their rooms; the library.
# Writes: results/evaluation/scenes/<variant>/<scene>/scores.csv.


container: CONFIG.containers.learning


rule score:
    """Compare the generated scenes of one room with its truth."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        scenes=expand("results/generation/{variant}/{scene}/scene_{rank}.json", rank=RANKS, allow_missing=True),
        cousins="results/matching/{variant}/{scene}/cousins.json",
        objects="results/extraction/{scene}/objects.json",
        truth=expand("results/scenes/{room}/truth.json", room=known_scene),
    output:
        scores="results/evaluation/scenes/{variant}/{scene}/scores.csv",
    log:
        "logs/evaluation/{variant}_{scene}.log",
    benchmark:
        "benchmarks/evaluation/{variant}_{scene}.tsv"
    group:
        scene_group
    resources:
        **needs(1000, 10),
    params:
        **command("evaluation", "score", scores="scores"),
        protocol=lambda wildcards: EXPERIMENT.scene(wildcards.scene).protocol,
        draw=noise_seed,
    shell:
        "({params.command} --scenes {input.scenes:q} --objects {input.objects:q} --truth {input.truth:q} "
        "--library {input.library:q} --cousins {input.cousins:q} --protocol '{params.protocol}' --draw {params.draw} "
        "--out {output.scores:q} && "
        "{params.check}) 2>&1 | tee {log:q}"
