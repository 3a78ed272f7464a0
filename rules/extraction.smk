# From an image to objects in space: masks, depth, floor and walls, clouds, mounting (paper A.2, A.7).
# Reads:  a scene's input folder, corrections.json in it where there is one.
# Writes: results/extraction/<scene>/{objects.json,masks.png,depth.npz,clouds.npz}, and for people overview.png.


rule extract:
    """Find the objects of one scene."""
    input:
        unpack(scene_inputs),
        own=own_options,
        corrections=corrections("extraction"),
    output:
        objects="results/extraction/{scene}/objects.json",
        masks="results/extraction/{scene}/masks.png",
        depth="results/extraction/{scene}/depth.npz",
        clouds="results/extraction/{scene}/clouds.npz",
    log:
        "logs/extraction/{scene}.log",
    benchmark:
        "benchmarks/extraction/{scene}.tsv"
    group:
        of_scene
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(2000, 10),
    params:
        command=command("extraction", "extract"),
        code=code("extraction", "extract", *modules(CONFIG.extraction, "source")),
        check=check(objects="objects"),
        options=options("extraction", "extract"),
        name=room_of,
        own=lambda wildcards, input: shlex.join(["--own", *input.own]) if input.own else "",
        corrections=corrections_flag,
        corrected=corrected("extraction"),
        corrector=corrector_code,
        seed=seed_of,
        folder=subpath(input.rgb, parent=True),
    shell:
        "({params.command} --input {params.folder:q} --scene {params.name} --options {params.options:q} "
        "{params.own} {params.corrections} --seed {params.seed} --out {output.objects:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule draw_objects:
    """Draw what was found in one scene."""
    input:
        objects=rules.extract.output.objects,
        masks=rules.extract.output.masks,
        image=scene_image,
    output:
        overview=report(
            "results/extraction/{scene}/overview.png",
            caption="../report/captions/scene.rst",
            category="Scenes",
            labels={"scene": "{scene}", "picture": "extraction"},
        ),
    log:
        "logs/extraction/draw_{scene}.log",
    group:
        of_scene
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(1000, 10),
    params:
        command=command("extraction", "draw"),
        code=code("extraction", "draw"),
    shell:
        "{params.command} --objects {input.objects:q} --image {input.image:q} --out {output.overview:q} "
        "2>&1 | tee {log:q}"


rule extraction:
    """Objects of all scenes."""
    input:
        files(rules.extract.output.objects, scene=ROOMS),
        files(rules.draw_objects.output.overview, scene=ROOMS),
    localrule: True
