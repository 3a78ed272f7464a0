# The asset library and its snapshots (paper A.1).
# Reads:  nothing, or the user's folders named in `assets.folders`.
# Writes: results/assets/library/library.json and one folder per asset beside it,
#         results/assets/snapshots/shard_<i>.{h5,json}, and for people shard_<i>.png.


rule library:
    """Make the procedural models and import the user's folders."""
    input:
        own=asset_files(),
    output:
        library="results/assets/library/library.json",
    log:
        "logs/assets/library.log",
    benchmark:
        "benchmarks/assets/library.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        mem_mb=2000,
    params:
        command=command("assets", "library"),
        code=code("assets", "library", *modules(CONFIG.assets, "importers")),
        check=check(library="library"),
        options=options("assets", "library"),
        seed=CONFIG.seed,
    shell:
        "({params.command} --options {params.options:q} --seed {params.seed} --out {output.library:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule snapshots:
    """Render the yaw views of one shard of the library."""
    input:
        library=rules.library.output.library,
    output:
        images="results/assets/snapshots/shard_{shard}.h5",
        index="results/assets/snapshots/shard_{shard}.json",
    log:
        "logs/assets/snapshots_{shard}.log",
    benchmark:
        "benchmarks/assets/snapshots_{shard}.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        mem_mb=2000,
    params:
        command=command("assets", "snapshots"),
        code=code("assets", "snapshots"),
        check=check(snapshots="images"),
        options=options("assets", "snapshots"),
        shards=len(SHARDS),
    shell:
        "({params.command} --library {input.library:q} --shard {wildcards.shard} --shards {params.shards} "
        "--options {params.options:q} --out {output.images:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule draw_snapshots:
    """Lay the snapshots of all shards out on contact sheets."""
    input:
        images=expand(rules.snapshots.output.images, shard=SHARDS),
        indices=expand(rules.snapshots.output.index, shard=SHARDS),
    output:
        sheets=expand("results/assets/snapshots/shard_{shard}.png", shard=SHARDS),
    log:
        "logs/assets/draw.log",
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        mem_mb=1000,
    params:
        command=command("assets", "draw"),
        code=code("assets", "draw"),
    shell:
        "{params.command} --snapshots {input.images:q} 2>&1 | tee {log:q}"
