# Digital cousins: nearest categories, models and orientations by patch voting (paper A.6, A.7, B.1).
# Reads:  the library's snapshots; a scene's objects and picture.
# Writes: results/matching/features/<store>/shard_<i>.{npy,json,npz} once per library and encoder with its settings,
#         results/matching/<variant>/<scene>/shards.json of a picture of the user's alone,
#         results/matching/<variant>/<scene>/cousins.json, and for people cousins.png,
#         results/matching/<variant>/<scene>/distances/<object>.json for the objects of the policy experiment.


container: CONFIG.containers.learning


rule features:
    """Encode the patches of one shard of snapshots."""
    input:
        images="results/assets/snapshots/shard_{shard}.h5",
        index="results/assets/snapshots/shard_{shard}.json",
    output:
        features="results/matching/features/{store}/shard_{shard}.npy",
        index="results/matching/features/{store}/shard_{shard}.json",
        companion="results/matching/features/{store}/shard_{shard}.npz",
    log:
        "logs/matching/features_{store}_{shard}.log",
    benchmark:
        "benchmarks/matching/features_{store}_{shard}.tsv"
    group:
        SHARD_GROUP
    resources:
        **needs(
            lambda wildcards: 1000 + 4 * models_in(wildcards),
            lambda wildcards: 10 + views_in(wildcards) / 200,
        ),
    params:
        **command("matching", "features", uses=store_modules, features="features"),
    shell:
        "({params.command} --snapshots {input.images:q} --options {params.options:q} "
        "--out {output.features:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


checkpoint shards:
    """Name the shards that a picture's objects are compared with: what is drawn, and what of the library lacks."""
    input:
        library="results/assets/library/library.json",
        objects="results/extraction/{scene}/objects.json",
    output:
        shards="results/matching/{variant}/{scene}/shards.json",
    log:
        "logs/matching/shards_{variant}_{scene}.log",
    localrule: True
    resources:
        **needs(2000, 10),
    params:
        **command("matching", "shards", uses=matching_modules("text_encoder"), shards="shards"),
        snapshots=lambda wildcards, input: str(Path(input.library).parents[1] / "snapshots"),
    shell:
        "({params.command} --objects {input.objects:q} --library {input.library:q} --snapshots {params.snapshots:q} "
        "--options {params.options:q} --out {output.shards:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule match:
    """Rank the cousins of every object of one scene."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        objects="results/extraction/{scene}/objects.json",
        masks="results/extraction/{scene}/masks.png",
        depth="results/extraction/{scene}/depth.npz",
        image=input_file("rgb.png"),
        features=expand(
            "results/matching/features/{store}/shard_{shard}.npy", store=store_of_variant, shard=compared_shards
        ),
        beside_features=expand(
            [
                "results/matching/features/{store}/shard_{shard}.json",
                "results/matching/features/{store}/shard_{shard}.npz",
            ],
            store=store_of_variant,
            shard=compared_shards,
        ),
        snapshots=expand("results/assets/snapshots/shard_{shard}.h5", shard=compared_shards),
        indices=expand("results/assets/snapshots/shard_{shard}.json", shard=compared_shards),
        without=lambda wildcards: (
            "results/evaluation/left_out/{scene}.json" if EXPERIMENT.scene(wildcards.scene).options.unknown else []
        ),
    output:
        cousins="results/matching/{variant}/{scene}/cousins.json",
    log:
        "logs/matching/{variant}_{scene}.log",
    benchmark:
        "benchmarks/matching/{variant}_{scene}.tsv"
    group:
        scene_group
    resources:
        **needs(2000 + 0.1 * LIBRARY_SIZE, 30),
    params:
        **command(
            "matching",
            "match",
            uses=matching_modules("encoder", "text_encoder", "search", "model_selection", "orientation_selection"),
            cousins="cousins",
        ),
    shell:
        "({params.command} --objects {input.objects:q} --image {input.image:q} --library {input.library:q} "
        "--features {input.features:q} --snapshots {input.snapshots:q} --without {input.without:q} "
        "--options {params.options:q} --out {output.cousins:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule distances:
    """How far the library's models look from the cousins of one object, and from its true model in a room."""
    input:
        cousins="results/matching/{variant}/{scene}/cousins.json",
        truth=expand("results/scenes/{room}/truth.json", room=known_scene),
        objects="results/extraction/{scene}/objects.json",
        library="results/assets/library/library.json",
        features=expand("results/matching/features/{store}/shard_{shard}.npy", store=store_of_variant, shard=SHARDS),
        beside_features=expand(
            [
                "results/matching/features/{store}/shard_{shard}.json",
                "results/matching/features/{store}/shard_{shard}.npz",
            ],
            store=store_of_variant,
            shard=SHARDS,
        ),
    output:
        distances="results/matching/{variant}/{scene}/distances/{object}.json",
    log:
        "logs/matching/distances_{variant}_{scene}_{object}.log",
    benchmark:
        "benchmarks/matching/distances_{variant}_{scene}_{object}.tsv"
    group:
        scene_group
    resources:
        **needs(2000 + 0.2 * LIBRARY_SIZE, 10),
    params:
        **command("matching", "distances", uses=matching_modules("encoder", "search"), distances="distances"),
        truth=truth_flags,
    shell:
        "({params.command} --cousins {input.cousins:q} --object {wildcards.object:q} --library {input.library:q} "
        "--features {input.features:q} {params.truth} --options {params.options:q} --out {output.distances:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule matching:
    """Cousins of all scenes, in all variants."""
    input:
        expand("results/matching/{variant}/{scene}/cousins.json", variant=VARIANTS, scene=ROOMS),
        added("matching"),
    localrule: True
