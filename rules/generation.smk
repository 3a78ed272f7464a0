# Scenes made of cousins: placement, support, walls, collisions, settling (paper A.3, A.7).
# Reads:  objects, cousins, library, corrections.json beside the picture where there is one; with `finish: picture` that.
# Writes: results/generation/<variant>/<scene>/scene_<rank>.json, and for people scene_<rank>.{png,glb}, comparison.png,
#         look.json, view_<rank>.glb (small, for pages) and thumbnail.webp (for the overview).


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
        image=lambda wildcards: (
            input_file("rgb.png")(wildcards) if CONFIG.generation_of(wildcards.variant).finish == "picture" else []
        ),
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
        **command("generation", "generate", generated="scenes"),
        corrections=corrections_flags,
        corrected=corrections("generation"),
        image=lambda wildcards, input: shlex.join(["--image", str(input.image)]) if input.image else "",
        out=lambda wildcards, output: str(Path(output.scenes[0]).parent),
    shell:
        "({params.command} --cousins {input.cousins:q} --objects {input.objects:q} "
        "--library {input.library:q} --variant {wildcards.variant} --options {params.options:q} "
        "{params.corrections} {params.image} --out {params.out:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule generation:
    """Generated scenes of all rooms and variants."""
    input:
        expand("results/generation/{variant}/{scene}/scene_{rank}.json", rank=RANKS, variant=VARIANTS, scene=ROOMS),
        added("generation"),
    localrule: True
