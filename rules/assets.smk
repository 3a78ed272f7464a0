# The asset library and its snapshots (paper A.1).
# Reads:  nothing, or the user's folders named in `assets.folders`.
# Writes: results/assets/library/shard_<i>.{json,zip} and library.json, the index of them all,
#         results/assets/snapshots/shard_<i>.{h5,json}, and for people shard_<i>.png.

# What a job reads that needs a model: that one changed is seen in the index, not by the age of the archives.
LIBRARY = {
    "library": "results/assets/library/library.json",
    "models": ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
}


rule library:
    """Join the procedural models and the user's own."""
    input:
        procedural=expand("results/assets/library/shard_{shard}.json", shard=range(PROCEDURAL)),
        own=expand("results/assets/library/shard_{shard}.json", shard=OWN),
    output:
        library=LIBRARY["library"],
    log:
        "logs/assets/library.log",
    localrule: True
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(1000, 10),
    params:
        command=command("assets", "join"),
        code=code("assets", "join"),
        check=check(library="library"),
    shell:
        "({params.command} --library {input.procedural:q} --own {input.own:q} --out {output.library:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule snapshots:
    """Render the yaw views of one shard of the library."""
    input:
        part="results/assets/library/shard_{shard}.json",
        models=ancient("results/assets/library/shard_{shard}.zip"),
    output:
        images="results/assets/snapshots/shard_{shard}.h5",
        index="results/assets/snapshots/shard_{shard}.json",
    log:
        "logs/assets/snapshots_{shard}.log",
    benchmark:
        "benchmarks/assets/snapshots_{shard}.tsv"
    group:
        "shard"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(
            lambda wildcards: 1500 + models_in(wildcards.shard),
            lambda wildcards: 10 + views_in(wildcards.shard) / 3000,
        ),
    params:
        command=command("assets", "snapshots"),
        code=code("assets", "snapshots"),
        check=check(snapshots="images"),
        options=options("assets", "snapshots"),
    shell:
        "({params.command} --library {input.part:q} --options {params.options:q} --out {output.images:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule draw_snapshots:
    """Lay the snapshots of one shard out on a contact sheet."""
    input:
        images=rules.snapshots.output.images,
        index=rules.snapshots.output.index,
    output:
        sheet="results/assets/snapshots/shard_{shard}.png",
    log:
        "logs/assets/draw_{shard}.log",
    group:
        "shard"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(1000, 10),
    params:
        command=command("assets", "draw"),
        code=code("assets", "draw"),
    shell:
        "{params.command} --snapshots {input.images:q} 2>&1 | tee {log:q}"
