# The asset library and its snapshots (paper A.1).
# Reads:  nothing, or the user's folders named in `assets.folders`.
# Whoever needs a model reads the index and all archives, by `ancient`: that one changed is seen in the index.
# Writes: results/assets/library/shard_<i>.{json,zip} and library.json, the index of them all; for a picture of the
#         user's shard_part_<categories>.json,
#         results/assets/snapshots/shard_<i>.{h5,json}, and for people shard_<i>.png.


container: CONFIG.containers.simulation


rule library:
    """Join the procedural models and the user's own."""
    input:
        procedural=expand("results/assets/library/shard_{shard}.json", shard=PROCEDURAL_SHARDS),
        own=expand("results/assets/library/shard_{shard}.json", shard=OWN_SHARDS),
    output:
        library="results/assets/library/library.json",
    log:
        "logs/assets/library.log",
    localrule: True
    resources:
        **needs(1000, 10),
    params:
        **command("assets", "join", library="library"),
    shell:
        "({params.command} --library {input.procedural:q} --own {input.own:q} --out {output.library:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule part:
    """Index the models of some categories, for a picture of the user's."""
    input:
        library="results/assets/library/library.json",
    output:
        part="results/assets/library/shard_{shard}.json",
    log:
        "logs/assets/{shard}.log",
    wildcard_constraints:
        shard=r"part_[0-9a-f]+",
    localrule: True
    resources:
        **needs(1000, 10),
    params:
        **command("assets", "part", library="part"),
    shell:
        "({params.command} --library {input.library:q} --shard {wildcards.shard} --out {output.part:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule snapshots:
    """Render the yaw views of one shard of the library."""
    input:
        part="results/assets/library/shard_{shard}.json",
        models=ancient(
            lambda wildcards: expand(
                "results/assets/library/shard_{shard}.zip",
                shard=SHARDS if wildcards.shard.startswith("part_") else wildcards.shard,
            )
        ),
    output:
        images="results/assets/snapshots/shard_{shard}.h5",
        index="results/assets/snapshots/shard_{shard}.json",
    log:
        "logs/assets/snapshots_{shard}.log",
    benchmark:
        "benchmarks/assets/snapshots_{shard}.tsv"
    group:
        SHARD_GROUP
    resources:
        **needs(
            lambda wildcards: 1500 + models_in(wildcards),
            lambda wildcards: 10 + views_in(wildcards) / 3000,
        ),
    params:
        **command("assets", "snapshots", snapshots="images"),
    shell:
        "({params.command} --library {input.part:q} --options {params.options:q} --out {output.images:q} && "
        "{params.check}) 2>&1 | tee {log:q}"
