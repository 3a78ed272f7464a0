# What a picture shows: ground, walls, camera, outlines, names, boxes (paper 2.1, A.2 first half).
# Reads:  pictures with depth, or those alone that `--config image=...` or `experiment.inputs` names; the networks' weights, as far as
#         they are here (`make weights`).
# Writes: results/scenes/<scene>/frame/, or results/photo/<scene>/ of a picture without depth, there with project.json, which the
#         page opens; things.json in both: what was found, placed or not. What a person draws and corrects stands in hand/<scene>/.
from roomkin.stages.config.weights import ALL as PUBLISHED_WEIGHTS, FOLDER as WEIGHTS_FOLDER

WEIGHTS = [file for file in (WEIGHTS_FOLDER / one.name for one in PUBLISHED_WEIGHTS) if file.is_file()]
PROPOSERS = modules(CONFIG.perception, "proposers"), modules(CONFIG.perception.for_measured(), "proposers")


container: CONFIG.containers.learning


rule see:
    """Find and name the things of one frame."""
    input:
        rgb="results/scenes/{scene}/view/rgb.png",
        camera="results/scenes/{scene}/view/camera.json",
        depth="results/scenes/{scene}/view/depth.npz",
        weights=ancient([*WEIGHTS, *NETWORK_WEIGHTS]),
    output:
        rgb="results/scenes/{scene}/frame/rgb.png",
        camera="results/scenes/{scene}/frame/camera.json",
        depth="results/scenes/{scene}/frame/depth.npz",
        masks="results/scenes/{scene}/frame/masks.png",
        annotations="results/scenes/{scene}/frame/annotations.json",
        things="results/scenes/{scene}/frame/things.json",
        config="results/scenes/{scene}/frame/config.yaml",
    log:
        "logs/scenes/see_{scene}.log",
    benchmark:
        "benchmarks/scenes/see_{scene}.tsv"
    wildcard_constraints:
        scene="|".join(EXPERIMENT.views) or "-",
    group:
        scene_group
    resources:
        **needs(lambda wildcards: 8000 if wildcards.scene in MEASURED else 2000, 30, gpu=bool(MEASURED)),
    params:
        **command(
            "perception",
            "see",
            uses=lambda wildcards: PROPOSERS[wildcards.scene in MEASURED],
            options=lambda wildcards: describe_picture(CONFIG, "see", wildcards.scene),
            annotations="annotations",
            things="things",
        ),
        picture=subpath(input.rgb, parent=True),
        device=CONFIG.device,
        out=subpath(output.rgb, parent=True),
    shell:
        "({params.command} --picture {params.picture:q} --options {params.options:q} "
        "--device {params.device} --out {params.out:q} && {params.check}) 2>&1 | tee {log:q}"


rule draw:
    """Find what a picture without depth shows and where, by lines; or take what was drawn into it."""
    input:
        image=lambda wildcards: EXPERIMENT.inputs[wildcards.scene].image,
        drawing=lambda wildcards: drawing_of(EXPERIMENT, wildcards.scene) or [],
        weights=ancient(WEIGHTS),
    output:
        rgb="results/photo/{scene}/rgb.png",
        camera="results/photo/{scene}/camera.json",
        depth="results/photo/{scene}/depth.npz",
        masks="results/photo/{scene}/masks.png",
        annotations="results/photo/{scene}/annotations.json",
        things="results/photo/{scene}/things.json",
    log:
        "logs/photo/{scene}.log",
    benchmark:
        "benchmarks/photo/{scene}.tsv"
    wildcard_constraints:
        scene="|".join([*EXPERIMENT.drawn, *EXPERIMENT.photographs]) or "-",
    resources:
        **needs(2000, 10),
    params:
        **command(
            "perception",
            "draw",
            uses=PROPOSERS[0],
            options=lambda wildcards: describe_picture(CONFIG, "draw", wildcards.scene),
            camera="camera",
            annotations="annotations",
            things="things",
        ),
        drawing=lambda wildcards, input: f"--drawing {shlex.quote(input.drawing)}" if input.drawing else "",
        device=CONFIG.device,
        out=subpath(output.rgb, parent=True),
    shell:
        "({params.command} --image {input.image:q} --options {params.options:q} {params.drawing} "
        "--device {params.device} --out {params.out:q} && {params.check}) 2>&1 | tee {log:q}"
