# Scenes made of cousins: placement, support, walls, collisions, settling (paper A.3, A.7).
# Reads:  objects, cousins, library, corrections.json beside the picture where there is one.
# Writes: results/generation/<variant>/<scene>/scene_<rank>.json, and for people scene_<rank>.{png,glb}, comparison.png,
#         look.json, view.glb (the first scene, small, for the report) and thumbnail.webp (for the overview).


container: CONFIG.containers.simulation


rule generate:
    """Place the cousins of every rank and let physics judge."""
    input:
        library="results/assets/library/library.json",
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=SHARDS)),
        cousins="results/matching/{variant}/{scene}/cousins.json",
        objects="results/extraction/{scene}/objects.json",
        clouds="results/extraction/{scene}/clouds.npz",
        masks="results/extraction/{scene}/masks.png",
        corrections=ancient(corrections_file("generation")),  # `corrected` says whether it counts
    output:
        scenes=expand("results/generation/{variant}/{scene}/scene_{rank}.json", rank=RANKS, allow_missing=True),
    log:
        "logs/generation/{variant}_{scene}.log",
    benchmark:
        "benchmarks/generation/{variant}_{scene}.tsv"
    group:
        scene_group
    resources:
        **needs(2000, 20),
    params:
        **verb("generation", "generate", generated="scenes"),
        corrections=corrections_flags,
        corrected=corrections("generation"),
        out=lambda wildcards, output: str(Path(output.scenes[0]).parent),
    shell:
        "({params.command} --cousins {input.cousins:q} --objects {input.objects:q} "
        "--library {input.library:q} --variant {wildcards.variant} --options {params.options:q} "
        "{params.corrections} --out {params.out:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule draw_scenes:
    """Draw the generated scenes of one room beside its picture, in its light and colours, and export them as GLB."""
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
        view="results/generation/{variant}/{scene}/view.glb",
        comparison=report(
            "results/generation/{variant}/{scene}/comparison.png",
            caption="../report/captions/scene.rst",
            category="Scenes",
            labels={"scene": "{scene}", "picture": "reconstruction ({variant})"},
        ),
    log:
        "logs/generation/draw_{variant}_{scene}.log",
    benchmark:
        "benchmarks/generation/draw_{variant}_{scene}.tsv"
    group:
        scene_group
    resources:
        **needs(2000, 10),
    params:
        **verb("generation", "draw", uses=list_drawers(CONFIG.packages, "generation")),
        look=list_drawers(CONFIG.packages, "generation"),
        out=subpath(output.comparison, parent=True),
    shell:
        "{params.command} --scenes {input.scenes:q} --objects {input.objects:q} --image {input.image:q} "
        "--library {input.library:q} --look {params.look} --out {params.out:q} 2>&1 | tee {log:q}"


rule generation:
    """Generated scenes of all rooms and variants."""
    input:
        expand("results/generation/{variant}/{scene}/scene_{rank}.json", rank=RANKS, variant=VARIANTS, scene=ROOMS),
        expand("results/generation/{variant}/{scene}/comparison.png", variant=VARIANTS, scene=ROOMS),
    localrule: True
