# From an image to objects in space: masks, depth, floor and walls, clouds, mounting (paper A.2, A.7).
# Reads:  a scene's input folder, corrections.json of it where there is one.
# Writes: results/extraction/<scene>/{objects.json,masks.png,depth.npz,clouds.npz}, and for people overview.png.


container: CONFIG.containers.learning


rule extract:
    """Find the objects of one scene."""
    input:
        rgb=input_file("rgb.png"),
        camera=input_file("camera.json"),
        depth=input_file("depth.npz"),
        masks=input_file("masks.png"),
        annotations=input_file("annotations.json"),
        own=picture_config,
        corrections=corrections_file("extraction", "results/extraction/{scene}/objects.json"),
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
        scene_group
    resources:
        **needs(2000, 10),
    params:
        **command("extraction", "extract", uses=modules(CONFIG.extraction, "source"), objects="objects"),
        name=lambda wildcards: EXPERIMENT.scene(wildcards.scene).room,
        own=lambda wildcards, input: shlex.join(["--own", *input.own]) if input.own else "",
        corrections=lambda wildcards, input: (
            shlex.join(["--corrections", *input.corrections]) if input.corrections else ""
        ),
        corrected=corrections("extraction"),
        seed=noise_seed,
        folder=subpath(input.rgb, parent=True),
    shell:
        "({params.command} --input {params.folder:q} --scene {params.name} --options {params.options:q} "
        "{params.own} {params.corrections} --seed {params.seed} --out {output.objects:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule extraction:
    """Objects of all scenes."""
    input:
        expand("results/extraction/{scene}/objects.json", scene=ROOMS),
        added("extraction"),
    localrule: True
