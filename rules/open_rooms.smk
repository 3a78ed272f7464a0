# Rooms that are not ours: pictures of rooms of other people's models, reconstructed and scored (docs/results/open.md).
# `snakemake open_rooms` in a clone of this repository, no part of `all`: 0.7 GB of models, Mitsuba 3, an hour on two cores.
# Reads:  the default library and its features.
# Writes: results/open_rooms/{packs,pictures,results}/, results/open_rooms/open.md, open.csv.


rule open_models:
    """Fetch models of other projects."""
    output:
        packs=directory("results/open_rooms/packs"),
    log:
        "logs/open_rooms/fetch.log",
    benchmark:
        "benchmarks/open_rooms/fetch.tsv"
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(2000, 60),
    params:
        code=open_code("packs.py", "models.csv"),
    shell:
        "python -m benchmarks.open_rooms fetch results/open_rooms 2>&1 | tee {log:q}"


rule open_picture:
    """Render one picture."""
    input:
        packs=rules.open_models.output.packs,
    output:
        picture=directory("results/open_rooms/pictures/{picture}"),
    log:
        "logs/open_rooms/render_{picture}.log",
    benchmark:
        "benchmarks/open_rooms/render_{picture}.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(3000, 20),
    params:
        code=open_code("pictures.py", "render.py", "rooms.py", "rooms.yaml", "sensor.py", "views.py"),
    shell:
        "python -m benchmarks.open_rooms render results/open_rooms --only {wildcards.picture} 2>&1 | tee {log:q}"


rule open_room:
    """Reconstruct one picture."""
    input:
        **LIBRARY,
        features=files(rules.features.output.features, store=next(iter(STORES), "none"), shard=SHARDS),
        snapshots=files(rules.snapshots.output.images, shard=SHARDS),
        picture=rules.open_picture.output.picture,
    output:
        scenes=directory("results/open_rooms/results/{masks}/{picture}"),
    log:
        "logs/open_rooms/run_{masks}_{picture}.log",
    benchmark:
        "benchmarks/open_rooms/run_{masks}_{picture}.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(3000, 30),
    params:
        code=lambda wildcards: code("extraction", "extract")
        + code("matching", "match")
        + code("generation", "generate"),
    shell:
        "python -m benchmarks.open_rooms run results/open_rooms --library results --only {wildcards.picture} --masks {wildcards.masks} "
        "2>&1 | tee {log:q}"


rule open_rooms:
    """Score the reconstructions of all pictures."""
    input:
        **LIBRARY,
        packs=rules.open_models.output.packs,
        scenes=lambda wildcards: expand(
            rules.open_room.output.scenes, masks=["drawn", "exact"], picture=open_pictures()
        ),
    output:
        page="results/open_rooms/open.md",
        rows="results/open_rooms/open.csv",
    log:
        "logs/open_rooms/score.log",
    benchmark:
        "benchmarks/open_rooms/score.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(3000, 30),
    params:
        code=open_code("score.py", "tables.py", "intro.md", "kinds.yaml", "models.csv"),
    shell:
        "python -m benchmarks.open_rooms score results/open_rooms --library results --out results/open_rooms 2>&1 | tee {log:q}"
