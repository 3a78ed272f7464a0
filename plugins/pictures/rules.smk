# Pictures for people of what the stages wrote.
# Reads:  snapshots, the files of extraction, matching and generation, the assets of targets.
# Writes: results/assets/snapshots/shard_<i>.png, results/extraction/<scene>/overview.png,
#         results/matching/<variant>/<scene>/cousins.png,
#         results/generation/<variant>/<scene>/{scene_<rank>.{png,glb},view_<rank>.glb,look.json,thumbnail.webp,comparison.png}.


container: CONFIG.containers.simulation


rule draw_snapshots:
    """Lay the snapshots of one shard out on a contact sheet."""
    input:
        images="results/assets/snapshots/shard_{shard}.h5",
        index="results/assets/snapshots/shard_{shard}.json",
    output:
        sheet="results/assets/snapshots/shard_{shard}.png",
    log:
        "logs/assets/draw_{shard}.log",
    group:
        SHARD_GROUP
    resources:
        **needs(1000, 10),
    params:
        **command("pictures", "snapshots"),
    shell:
        "{params.command} --snapshots {input.images:q} 2>&1 | tee {log:q}"


rule draw_objects:
    """Draw what was found in one scene."""
    input:
        objects="results/extraction/{scene}/objects.json",
        masks="results/extraction/{scene}/masks.png",
        image=input_file("rgb.png"),
    output:
        overview="results/extraction/{scene}/overview.png",
    log:
        "logs/extraction/draw_{scene}.log",
    group:
        scene_group
    container:
        CONFIG.containers.learning
    resources:
        **needs(1000, 10),
    params:
        **command("pictures", "objects"),
    shell:
        "{params.command} --objects {input.objects:q} --image {input.image:q} --out {output.overview:q} "
        "2>&1 | tee {log:q}"


rule draw_cousins:
    """Draw the objects of one scene beside their cousins."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        cousins="results/matching/{variant}/{scene}/cousins.json",
        objects="results/extraction/{scene}/objects.json",
        masks="results/extraction/{scene}/masks.png",
        depth="results/extraction/{scene}/depth.npz",
        image=input_file("rgb.png"),
        snapshots=expand("results/assets/snapshots/shard_{shard}.h5", shard=scene_shards),
        indices=expand("results/assets/snapshots/shard_{shard}.json", shard=scene_shards),
    output:
        picture="results/matching/{variant}/{scene}/cousins.png",
    log:
        "logs/matching/draw_{variant}_{scene}.log",
    group:
        scene_group
    container:
        CONFIG.containers.learning
    resources:
        **needs(1000, 10),
    params:
        **command("pictures", "cousins", uses=list_drawers(CONFIG.packages, "matching")),
        in_place=list_drawers(CONFIG.packages, "matching"),
    shell:
        "{params.command} --cousins {input.cousins:q} --objects {input.objects:q} --image {input.image:q} "
        "--snapshots {input.snapshots:q} --library {input.library:q} --in-place {params.in_place} "
        "--out {output.picture:q} 2>&1 | tee {log:q}"


rule draw_scenes:
    """Draw the generated scenes of one room beside its picture, in its light and colors, and export them as GLB."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        scenes=expand("results/generation/{variant}/{scene}/scene_{rank}.json", rank=RANKS, allow_missing=True),
        objects="results/extraction/{scene}/objects.json",
        masks="results/extraction/{scene}/masks.png",
        depth="results/extraction/{scene}/depth.npz",
        image=input_file("rgb.png"),
    output:
        previews=expand("results/generation/{variant}/{scene}/scene_{rank}.png", rank=RANKS, allow_missing=True),
        exports=expand("results/generation/{variant}/{scene}/scene_{rank}.glb", rank=RANKS, allow_missing=True),
        look="results/generation/{variant}/{scene}/look.json",
        thumbnail="results/generation/{variant}/{scene}/thumbnail.webp",
        views=expand("results/generation/{variant}/{scene}/view_{rank}.glb", rank=RANKS, allow_missing=True),
        comparison="results/generation/{variant}/{scene}/comparison.png",
    log:
        "logs/generation/draw_{variant}_{scene}.log",
    benchmark:
        "benchmarks/generation/draw_{variant}_{scene}.tsv"
    group:
        scene_group
    resources:
        **needs(2000, 10),
    params:
        **command("pictures", "scenes"),
        out=subpath(output.comparison, parent=True),
    shell:
        "{params.command} --scenes {input.scenes:q} --objects {input.objects:q} --image {input.image:q} "
        "--library {input.library:q} --out {params.out:q} 2>&1 | tee {log:q}"


ADDED["extraction"] += expand("results/extraction/{scene}/overview.png", scene=ROOMS)
ADDED["matching"] += expand("results/matching/{variant}/{scene}/cousins.png", variant=VARIANTS, scene=ROOMS)
ADDED["generation"] += expand("results/generation/{variant}/{scene}/comparison.png", variant=VARIANTS, scene=ROOMS)
ADDED["figure6"] += expand("results/generation/{variant}/{scene}/comparison.png", scene=REPORT_ROOMS, variant=VARIANTS)
