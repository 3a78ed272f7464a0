# Scenes made of cousins: placement, support, walls, collisions, settling (paper A.3, A.7).
# Reads:  objects, cousins, library, corrections.json of the picture if there is one; the user's pictures.
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
        corrections=corrections_file("generation", "results/generation/{variant}/{scene}/scene_1.json"),
        seen=lambda wildcards: [
            ancient(input_file(name)(wildcards))
            for name in ("masks.png", "rgb.png", "camera.json")
            if corrections("generation")(wildcards)
        ],
        image=lambda wildcards: (
            input_file("rgb.png")(wildcards) if CONFIG.wears_picture(wildcards.variant, wildcards.scene) else []
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
        corrections=lambda wildcards, input: (
            shlex.join(["--corrections", *input.corrections, "--input", str(Path(input.seen[0]).parent)])
            if input.seen
            else ""
        ),
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


rule photo:
    """The picture that `--config image=...` names, as scenes of cousins, and the page about them."""
    input:
        rules.generation.input,
        added("photo"),
    localrule: True
