# The patch encoder `patchnet`: trained on renders of procedural models that are in no library (docs/matching.md).
# No part of `all`: its weights are shipped in stages/patchnet.
# Reads:  nothing.
# Writes: results/encoder/pairs_<i>.h5, results/encoder/{patchnet.safetensors,metrics.jsonl}.


rule encoder_pairs:
    """Photograph models twice each: as a snapshot, and as a room may show them."""
    output:
        pairs="results/encoder/pairs_{shard}.h5",
    log:
        "logs/encoder/pairs_{shard}.log",
    benchmark:
        "benchmarks/encoder/pairs_{shard}.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(2000, 120),
    params:
        command=command("encoder", "render"),
        code=code("encoder", "render"),
        options=options("encoder", "render"),
        shards=CONFIG.encoder.shards,
        seed=CONFIG.seed,
    shell:
        "{params.command} --shard {wildcards.shard} --shards {params.shards} --seed {params.seed} "
        "--options {params.options:q} --out {output.pairs:q} 2>&1 | tee {log:q}"


rule encoder:
    """Train the network on them."""
    input:
        pairs=files(rules.encoder_pairs.output.pairs, shard=range(CONFIG.encoder.shards)),
    output:
        weights="results/encoder/patchnet.safetensors",
        metrics="results/encoder/metrics.jsonl",
    log:
        "logs/encoder/train.log",
    benchmark:
        "benchmarks/encoder/train.tsv"
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(4000, 240),
    params:
        command=command("encoder", "train"),
        code=code("encoder", "train"),
        options=options("encoder", "train"),
        seed=CONFIG.seed,
        out=subpath(output.weights, parent=True),
    shell:
        "{params.command} --pairs {input.pairs:q} --options {params.options:q} --seed {params.seed} "
        "--out {params.out:q} 2>&1 | tee {log:q}"
