# The procedural models, a shard at a time (paper A.1).
# Reads:  nothing.
# Writes: results/assets/library/shard_<n>.{json,zip}.


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
        "shard"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(1000, lambda wildcards: 10 + models_in(wildcards.shard) / 20),
    params:
        command=command("furniture", "library"),
        code=code("furniture", "library"),
        check=check(library_part="part"),
        options=options("furniture", "library"),
        shards=PROCEDURAL,
        seed=CONFIG.seed,
    shell:
        "({params.command} --shard {wildcards.shard} --shards {params.shards} --options {params.options:q} "
        "--seed {params.seed} --out {output.part:q} && "
        "{params.check}) 2>&1 | tee {log:q}"
