# Rooms that are not ours: pictures of rooms of other people's models, reconstructed and scored (docs/results/open.md).
# `snakemake open_rooms` in a clone of this repository, no part of `all`: 1 GB of models, Mitsuba 3, three hours of one core.
# Reads:  the default library and its features.
# Writes: results/open_rooms/{packs,pictures,results}/, results/open_rooms/open.md, open.csv.xz, clicks.csv.
from roomkin.plugins.studies.open_rooms import digest_of, picture_names


container: CONFIG.containers.simulation


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
    resources:
        **needs(2000, 60),
    params:
        code=digest_of("blend.py", "fetch.py", "packs.py", "planner.js", "models.csv"),
    shell:
        "python -m benchmarks.open_rooms fetch results/open_rooms 2>&1 | tee {log:q}"


rule open_picture:
    """Render one picture."""
    input:
        packs="results/open_rooms/packs",
    output:
        picture=directory("results/open_rooms/pictures/{picture}"),
    log:
        "logs/open_rooms/render_{picture}.log",
    benchmark:
        "benchmarks/open_rooms/render_{picture}.tsv"
    resources:
        **needs(3000, 20),
    params:
        code=digest_of("pictures.py", "render.py", "rooms.py", "rooms.yaml", "sensor.py", "views.py"),
    shell:
        "python -m benchmarks.open_rooms render results/open_rooms --only {wildcards.picture} 2>&1 | tee {log:q}"


rule open_room:
    """Reconstruct one picture, told its masks and names (`drawn`), nothing (`unaided`), or not even depth (`alone`)."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        features=expand("results/matching/features/{store}/shard_{shard}.npy", store=next(iter(STORES)), shard=SHARDS),
        snapshots=expand("results/assets/snapshots/shard_{shard}.h5", shard=SHARDS),
        picture="results/open_rooms/pictures/{picture}",
    output:
        scenes=directory("results/open_rooms/results/{masks}/{picture}"),
    log:
        "logs/open_rooms/run_{masks}_{picture}.log",
    benchmark:
        "benchmarks/open_rooms/run_{masks}_{picture}.tsv"
    resources:
        **needs(3000, 30),
    params:
        code=[
            command_digest(CONFIG, stage, name)
            for stage, name in (("extraction", "extract"), ("matching", "match"), ("generation", "generate"))
        ],
    shell:
        "python -m benchmarks.open_rooms run results/open_rooms --library results --only {wildcards.picture} --masks {wildcards.masks} "
        "2>&1 | tee {log:q}"


rule open_rooms:
    """Score the reconstructions of all pictures."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        packs="results/open_rooms/packs",
        scenes=expand(
            "results/open_rooms/results/{masks}/{picture}",
            masks=["drawn", "unaided", "alone"],
            picture=picture_names,
        ),
    output:
        page="results/open_rooms/open.md",
        rows="results/open_rooms/open.csv.xz",
        clicks="results/open_rooms/clicks.csv",
        sureness="results/open_rooms/open_sizes.svg",
    log:
        "logs/open_rooms/score.log",
    benchmark:
        "benchmarks/open_rooms/score.tsv"
    resources:
        **needs(3000, 30),
    params:
        code=digest_of(
            "score.py",
            "by_clicks.py",
            "pairs.py",
            "sureness.py",
            "shapes.py",
            "tables.py",
            "intro.md",
            "../../plugins/scorecard/kinds.yaml",
            "../../plugins/scorecard/measures.py",
            "../../plugins/scorecard/card.py",
            "models.csv",
        ),
    shell:
        "python -m benchmarks.open_rooms score results/open_rooms --library results --out results/open_rooms 2>&1 | tee {log:q}"
