# Models of the user, a shard of a few of them at a time.
# Reads:  the folders of `assets.folders`.
# Writes: results/assets/library/shard_own_<digest>.{json,zip}.


container: CONFIG.containers.simulation


rule own:
    """Import one shard of the models in a folder of the user's."""
    input:
        files=ancient(lambda wildcards: OWN_SHARDS[wildcards.shard].files),  # their digest counts
    output:
        part="results/assets/library/shard_{shard}.json",
        models="results/assets/library/shard_{shard}.zip",
    log:
        "logs/assets/{shard}.log",
    benchmark:
        "benchmarks/assets/{shard}.tsv"
    wildcard_constraints:
        shard=r"own_\w+",
    group:
        SHARD_GROUP
    resources:
        **needs(4000, lambda wildcards: 10 + models_in(wildcards)),
    params:
        **command("importing", "own", uses=modules(CONFIG.assets, "importers"), library_part="part"),
        folder=lambda wildcards, input: OWN_SHARDS[wildcards.shard].place(input.files[0]),
        models=lambda wildcards, input: OWN_SHARDS[wildcards.shard].list_files(
            OWN_SHARDS[wildcards.shard].place(input.files[0])
        ),
        digest=lambda wildcards: OWN_SHARDS[wildcards.shard].digest(),
    shell:
        "({params.command} --folder {params.folder:q} --models {params.models:q} --options {params.options:q} "
        "--out {output.part:q} && "
        "{params.check}) 2>&1 | tee {log:q}"
