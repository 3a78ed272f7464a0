# Pictures of the user's, read: frames with depth, with masks or without; photographs whose depth a network measures (paper A.2, A.7).
# Reads:  what `--config image=...` or `experiment.inputs` names; weights/<network>/.
# Writes: results/scenes/<scene>/view/ of what things are yet to be found in, results/scenes/<scene>/frame/ of one with masks;
#         weights/<network>/, weights.lock.json.
NETWORK_WEIGHTS = [Path(folder, "model.safetensors") for folder in CONFIG.perception.networks().values()]
NETWORK_WEIGHTS = [file for file in NETWORK_WEIGHTS if file.is_file()] if EXPERIMENT.measured else []
MEASURED = set(EXPERIMENT.measured)


container: CONFIG.containers.learning


rule fetch:
    """Download the weights of `perception.by: networks` that are not there."""
    output:
        record="results/photo/weights.json",
    log:
        "logs/photo/fetch.log",
    resources:
        **needs(1000, 60),
    params:
        **command("perception", "fetch"),
        folders=json.dumps(CONFIG.perception.networks()),
    shell:
        "{params.command} --networks --options {params.folders:q} --out {output.record:q} 2>&1 | tee {log:q}"


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
        scene="|".join(name for name in EXPERIMENT.views if name not in MEASURED) or "-",
    group:
        scene_group
    resources:
        **needs(2000, 10),
    params:
        **command("perception", "from-rgbd", camera="camera"),
        frame=lambda wildcards, input: EXPERIMENT.inputs[wildcards.scene].flags(input),
        out=subpath(output.rgb, parent=True),
    shell:
        "({params.command} {params.frame} --out {params.out:q} && {params.check}) 2>&1 | tee {log:q}"


rule measure:
    """Measure the depth of a picture that has none, by a network."""
    input:
        image=lambda wildcards: EXPERIMENT.inputs[wildcards.scene].image,
        weights=ancient(NETWORK_WEIGHTS),
    output:
        rgb="results/scenes/{scene}/view/rgb.png",
        camera="results/scenes/{scene}/view/camera.json",
        depth="results/scenes/{scene}/view/depth.npz",
    log:
        "logs/scenes/measure_{scene}.log",
    wildcard_constraints:
        scene="|".join(EXPERIMENT.measured) or "-",
    group:
        scene_group
    resources:
        **needs(8000, 30, gpu=True),
    params:
        **command(
            "perception",
            "measure",
            options=lambda wildcards: describe_picture(CONFIG, "measure", wildcards.scene),
            camera="camera",
        ),
        device=CONFIG.device,
        out=subpath(output.rgb, parent=True),
    shell:
        "({params.command} --image {input.image:q} --options {params.options:q} --device {params.device} "
        "--out {params.out:q} && {params.check}) 2>&1 | tee {log:q}"


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
        **command("perception", "from-rgbd", camera="camera", annotations="annotations"),
        frame=lambda wildcards, input: EXPERIMENT.inputs[wildcards.scene].flags(input),
        out=subpath(output.rgb, parent=True),
    shell:
        "({params.command} {params.frame} --out {params.out:q} && {params.check}) 2>&1 | tee {log:q}"
