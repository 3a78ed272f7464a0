# One picture of the user's, found by pretrained networks (paper 2.1, A.2, A.7). No part of `all`.
# Reads:  the picture that `--config image=...` or `experiment.inputs` names, weights.
# Writes: results/photo/<scene>/{rgb.png,camera.json,depth.npz,masks.png,annotations.json},
#         weights/<network>/, weights.lock.json.


rule fetch:
    """Download the weights that are not there."""
    output:
        record="results/photo/weights.json",
    log:
        "logs/photo/fetch.log",
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        **needs(1000, 60),
    params:
        command=command("inputs", "fetch"),
        code=code("inputs", "fetch"),
        options=options("inputs", "fetch"),
    shell:
        "{params.command} --options {params.options:q} --out {output.record:q} 2>&1 | tee {log:q}"


rule estimate:
    """Find what the picture shows, where and how far."""
    input:
        image=lambda wildcards: EXPERIMENT.inputs[wildcards.scene].image,
        weights=weight_files(),
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
    container:
        CONFIG.containers.learning
    threads: 2
    resources:
        **needs(8000, 60, gpu=True),
    params:
        command=command("inputs", "estimate"),
        code=code("inputs", "estimate"),
        check=check(camera="camera", annotations="annotations"),
        options=picture_options,
        device=CONFIG.device,
        out=subpath(output.rgb, parent=True),
    shell:
        "({params.command} --image {input.image:q} --options {params.options:q} --device {params.device} "
        "--out {params.out:q} && "
        "{params.check}) 2>&1 | tee {log:q}"
