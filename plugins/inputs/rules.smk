# Pictures of the user's: frames with depth as they are, others found by pretrained networks (paper 2.1, A.2, A.7).
# Reads:  what `--config image=...` or `experiment.inputs` names, weights.
# Writes: results/scenes/<scene>/view/ without masks, results/photo/<scene>/ and results/scenes/<scene>/frame/{rgb.png,camera.json,depth.npz,masks.png,annotations.json},
#         weights/<network>/, weights.lock.json.
from plugins.inputs.flags import frame_flags, picture_options, weight_files


container: CONFIG.containers.learning


rule fetch:
    """Download the weights that are not there."""
    output:
        record="results/photo/weights.json",
    log:
        "logs/photo/fetch.log",
    resources:
        **needs(1000, 60),
    params:
        **command("inputs", "fetch"),
    shell:
        "{params.command} --options {params.options:q} --out {output.record:q} 2>&1 | tee {log:q}"


rule estimate:
    """Find what the picture shows, where and how far."""
    input:
        image=lambda wildcards: EXPERIMENT.inputs[wildcards.scene].image,
        weights=weight_files(CONFIG),
    output:
        rgb="results/photo/{scene}/rgb.png",
        camera="results/photo/{scene}/camera.json",
        depth="results/photo/{scene}/depth.npz",
        masks="results/photo/{scene}/masks.png",
        annotations="results/photo/{scene}/annotations.json",
    log:
        "logs/photo/{scene}.log",
    benchmark:
        "benchmarks/photo/{scene}.tsv"
    wildcard_constraints:
        scene="|".join(EXPERIMENT.photographs if CONFIG.photo.asks_networks() else []) or "-",  # a folder that was made before is an input folder as any other
    threads: 2
    resources:
        **needs(8000, 60, gpu=True),
    params:
        **command(
            "inputs",
            "estimate",
            options=lambda wildcards: picture_options(CONFIG, wildcards.scene),
            camera="camera",
            annotations="annotations",
        ),
        device=CONFIG.device,
        out=subpath(output.rgb, parent=True),
    shell:
        "({params.command} --image {input.image:q} --options {params.options:q} --device {params.device} "
        "--out {params.out:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule view:
    """Read one frame with depth of the user's, whose things are yet to be found."""
    input:
        unpack(lambda wildcards: EXPERIMENT.inputs[wildcards.scene].files()),
    output:
        rgb="results/scenes/{scene}/view/rgb.png",
        camera="results/scenes/{scene}/view/camera.json",
        depth="results/scenes/{scene}/view/depth.npz",
    log:
        "logs/scenes/view_{scene}.log",
    wildcard_constraints:
        scene="|".join(EXPERIMENT.views) or "-",
    group:
        scene_group
    resources:
        **needs(2000, 10),
    params:
        **command("inputs", "from-rgbd", camera="camera"),
        frame=lambda wildcards, input: frame_flags(EXPERIMENT.inputs[wildcards.scene], input),
        out=subpath(output.rgb, parent=True),
    shell:
        "({params.command} {params.frame} --out {params.out:q} && {params.check}) 2>&1 | tee {log:q}"


rule frame:
    """Make an input folder of one frame with depth and masks of the user's."""
    input:
        unpack(lambda wildcards: EXPERIMENT.inputs[wildcards.scene].files()),
    output:
        rgb="results/scenes/{scene}/frame/rgb.png",
        camera="results/scenes/{scene}/frame/camera.json",
        depth="results/scenes/{scene}/frame/depth.npz",
        masks="results/scenes/{scene}/frame/masks.png",
        annotations="results/scenes/{scene}/frame/annotations.json",
        config="results/scenes/{scene}/frame/config.yaml",
    log:
        "logs/scenes/frame_{scene}.log",
    benchmark:
        "benchmarks/scenes/frame_{scene}.tsv"
    wildcard_constraints:
        scene="|".join(EXPERIMENT.frames) or "-",
    group:
        scene_group
    resources:
        **needs(2000, 10),
    params:
        **command("inputs", "from-rgbd", camera="camera", annotations="annotations"),
        frame=lambda wildcards, input: frame_flags(EXPERIMENT.inputs[wildcards.scene], input),
        out=subpath(output.rgb, parent=True),
    shell:
        "({params.command} {params.frame} --out {params.out:q} && {params.check}) 2>&1 | tee {log:q}"
