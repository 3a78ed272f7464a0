# Digital cousins: nearest categories, models and orientations by patch voting (paper A.6, A.7, B.1).
# Reads:  the library's snapshots; a scene's objects and picture.
# Writes: results/matching/features/<store>/shard_<i>.{npy,json,npz} once per library and encoder with its settings,
#         results/matching/<variant>/<scene>/cousins.json, and for people cousins.png,
#         results/matching/<variant>/<scene>/distances/<object>.json for the objects of the policy experiment.


rule features:
    """Encode the patches of one shard of snapshots."""
    input:
        images=rules.snapshots.output.images,
        index=rules.snapshots.output.index,
    output:
        features="results/matching/features/{store}/shard_{shard}.npy",
        index="results/matching/features/{store}/shard_{shard}.json",
        companion="results/matching/features/{store}/shard_{shard}.npz",
    log:
        "logs/matching/features_{store}_{shard}.log",
    benchmark:
        "benchmarks/matching/features_{store}_{shard}.tsv"
    group:
        "shard"
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(
            lambda wildcards: 1000 + 4 * models_in(wildcards.shard),
            lambda wildcards: 10 + views_in(wildcards.shard) / 200,
        ),
    params:
        command=command("matching", "features"),
        code=lambda wildcards: code("matching", "features", *modules(STORES[wildcards.store], "encoder")),
        check=check(features="features"),
        options=options("matching", "features"),
    shell:
        "({params.command} --snapshots {input.images:q} --options {params.options:q} "
        "--out {output.features:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule match:
    """Rank the cousins of every object of one scene."""
    input:
        **LIBRARY,
        objects=rules.extract.output.objects,
        masks=rules.extract.output.masks,
        depth=rules.extract.output.depth,
        image=scene_image,
        features=lambda wildcards: pictures_of(wildcards.variant, features_of(wildcards.variant)),
        beside_features=lambda wildcards: pictures_of(wildcards.variant, beside_features(wildcards.variant)),
        snapshots=lambda wildcards: snapshots_of(wildcards.variant, "images"),
        indices=lambda wildcards: snapshots_of(wildcards.variant, "index"),
        without=left_out,
    output:
        cousins="results/matching/{variant}/{scene}/cousins.json",
    log:
        "logs/matching/{variant}_{scene}.log",
    benchmark:
        "benchmarks/matching/{variant}_{scene}.tsv"
    group:
        of_scene
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(2000 + 0.1 * LIBRARY_SIZE, 30),
    params:
        command=command("matching", "match"),
        code=matching_code("match", "encoder", "text_encoder", "search", "model_selection", "orientation_selection"),
        check=check(cousins="cousins"),
        options=options("matching", "match"),
    shell:
        "({params.command} --objects {input.objects:q} --image {input.image:q} --library {input.library:q} "
        "--features {input.features:q} --snapshots {input.snapshots:q} --without {input.without:q} "
        "--options {params.options:q} --out {output.cousins:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule distances:
    """How far the library's models look from the cousins of one object, and from its true model in a room."""
    input:
        cousins=rules.match.output.cousins,
        truth=known_truth,
        objects=rules.extract.output.objects,
        library=rules.library.output.library,
        features=lambda wildcards: features_of(wildcards.variant),
        beside_features=lambda wildcards: beside_features(wildcards.variant),
    output:
        distances="results/matching/{variant}/{scene}/distances/{object}.json",
    log:
        "logs/matching/distances_{variant}_{scene}_{object}.log",
    benchmark:
        "benchmarks/matching/distances_{variant}_{scene}_{object}.tsv"
    group:
        of_scene
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(2000 + 0.2 * LIBRARY_SIZE, 10),
    params:
        command=command("matching", "distances"),
        code=matching_code("distances", "encoder", "search"),
        check=check(distances="distances"),
        options=options("matching", "distances"),
        truth=truth_flags,
    shell:
        "({params.command} --cousins {input.cousins:q} --object {wildcards.object:q} --library {input.library:q} "
        "--features {input.features:q} {params.truth} --options {params.options:q} --out {output.distances:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule draw_cousins:
    """Draw the objects of one scene beside their cousins."""
    input:
        **LIBRARY,
        cousins=rules.match.output.cousins,
        objects=rules.extract.output.objects,
        masks=rules.extract.output.masks,
        depth=rules.extract.output.depth,
        image=scene_image,
        snapshots=files(rules.snapshots.output.images, shard=SHARDS),
        indices=files(rules.snapshots.output.index, shard=SHARDS),
    output:
        picture=report(
            "results/matching/{variant}/{scene}/cousins.png",
            caption="../report/captions/scene.rst",
            category="Scenes",
            labels={"scene": "{scene}", "picture": "cousins ({variant})"},
        ),
    log:
        "logs/matching/draw_{variant}_{scene}.log",
    group:
        of_scene
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(1000, 10),
    params:
        command=command("matching", "draw"),
        code=code("matching", "draw", *drawn_by(CONFIG.packages, "matching")),
        in_place=drawn_by(CONFIG.packages, "matching"),
    shell:
        "{params.command} --cousins {input.cousins:q} --objects {input.objects:q} --image {input.image:q} "
        "--snapshots {input.snapshots:q} --library {input.library:q} --in-place {params.in_place} "
        "--out {output.picture:q} 2>&1 | tee {log:q}"


rule matching:
    """Cousins of all scenes, in all variants."""
    input:
        files(rules.match.output.cousins, variant=VARIANTS, scene=ROOMS),
        files(rules.draw_cousins.output.picture, variant=VARIANTS, scene=ROOMS),
    localrule: True
