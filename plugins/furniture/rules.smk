# The procedural models, a shard at a time (paper A.1).
# Reads:  nothing.
# Writes: results/assets/library/shard_<n>.{json,zip}.


container: CONFIG.containers.simulation


rule procedural:
    """Make one shard of the procedural models."""
    output:
        part="results/assets/library/shard_{shard}.json",
        models="results/assets/library/shard_{shard}.zip",
    log:
        "logs/assets/procedural_{shard}.log",
    benchmark:
        "benchmarks/assets/procedural_{shard}.tsv"
    wildcard_constraints:
        shard=r"\d+",
    group:
        SHARD_GROUP
    resources:
        **needs(1000, lambda wildcards: 10 + models_in(wildcards) / 20),
    params:
        **command("furniture", "library", library_part="part"),
        shards=len(PROCEDURAL_SHARDS),
        seed=CONFIG.seed,
    shell:
        "({params.command} --shard {wildcards.shard} --shards {params.shards} --options {params.options:q} "
        "--seed {params.seed} --out {output.part:q} && "
        "{params.check}) 2>&1 | tee {log:q}"
