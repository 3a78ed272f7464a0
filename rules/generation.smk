# Scenes made of cousins: placement, support, walls, collisions, settling (paper A.3, A.7).
# Reads:  objects, cousins, library, corrections.json beside the picture where there is one.
# Writes: results/generation/<variant>/<scene>/scene_<rank>.json, and for people scene_<rank>.{png,glb}, comparison.png,
#         look.json, view.glb (the first scene, small, for the report) and thumbnail.webp (for the overview).


rule generate:
    """Place the cousins of every rank and let physics judge."""
    input:
        **LIBRARY,
        cousins=rules.match.output.cousins,
        objects=rules.extract.output.objects,
        clouds=rules.extract.output.clouds,
        masks=rules.extract.output.masks,
        corrections=corrections("generation"),
    output:
        scenes=[f"results/generation/{{variant}}/{{scene}}/scene_{rank}.json" for rank in RANKS],
    log:
        "logs/generation/{variant}_{scene}.log",
    benchmark:
        "benchmarks/generation/{variant}_{scene}.tsv"
    group:
        of_scene
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(2000, 20),
    params:
        command=command("generation", "generate"),
        code=code("generation", "generate"),
        check=check(generated="scenes"),
        options=options("generation", "generate"),
        corrections=corrections_flag,
        corrected=corrected("generation"),
        out=lambda wildcards, output: str(Path(output.scenes[0]).parent),
    shell:
        "({params.command} --cousins {input.cousins:q} --objects {input.objects:q} "
        "--library {input.library:q} --variant {wildcards.variant} --options {params.options:q} "
        "{params.corrections} --out {params.out:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule draw_scenes:
    """Draw the generated scenes of one room beside its picture, in its light and colours, and export them as GLB."""
    input:
        **LIBRARY,
        scenes=rules.generate.output.scenes,
        objects=rules.extract.output.objects,
        masks=rules.extract.output.masks,
        depth=rules.extract.output.depth,
        image=scene_image,
    output:
        previews=[f"results/generation/{{variant}}/{{scene}}/scene_{rank}.png" for rank in RANKS],
        exports=[f"results/generation/{{variant}}/{{scene}}/scene_{rank}.glb" for rank in RANKS],
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
        of_scene
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(2000, 10),
    params:
        command=command("generation", "draw"),
        code=code("generation", "draw", *drawn_by(CONFIG.packages, "generation")),
        look=drawn_by(CONFIG.packages, "generation"),
        out=subpath(output.comparison, parent=True),
    shell:
        "{params.command} --scenes {input.scenes:q} --objects {input.objects:q} --image {input.image:q} "
        "--library {input.library:q} --look {params.look} --out {params.out:q} 2>&1 | tee {log:q}"


rule generation:
    """Generated scenes of all rooms and variants."""
    input:
        files(rules.generate.output.scenes, variant=VARIANTS, scene=ROOMS),
        files(rules.draw_scenes.output.comparison, variant=VARIANTS, scene=ROOMS),
    localrule: True
