# Pictures without depth, drawn by lines, outlines and usual sizes (paper 2.1).
# Reads:  what `--config image=...` or `experiment.inputs` names; the networks' weights (`make weights`).
# Writes: results/photo/<scene>/, an input folder with project.json, which the page opens.
import shlex

from plugins.eyes.weights import ALL as SEEING, FOLDER as SEEING_FOLDER
from plugins.single_view.flags import draw_options

# Those pictures without depth that no other networks look at.
DRAWN = EXPERIMENT.drawn if CONFIG.packages["inputs"] else []
DRAWN += [] if not CONFIG.packages["inputs"] or CONFIG.photo.asks_networks() else EXPERIMENT.photographs


container: CONFIG.containers.learning


rule draw:
    """Find what the picture shows and where, and draw it as a person would."""
    input:
        image=lambda wildcards: EXPERIMENT.inputs[wildcards.scene].image,
        drawing=lambda wildcards: EXPERIMENT.inputs[wildcards.scene].drawing or [],
        weights=ancient([str(SEEING_FOLDER / one.name) for one in SEEING if (SEEING_FOLDER / one.name).is_file()]),
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
        scene="|".join(DRAWN) or "-",
    resources:
        **needs(2000, 10),
    params:
        **command(
            "single_view",
            "draw",
            options=lambda wildcards: draw_options(CONFIG, wildcards.scene),
            camera="camera",
            annotations="annotations",
        ),
        drawing=lambda wildcards, input: f"--drawing {shlex.quote(input.drawing)}" if input.drawing else "",
        out=subpath(output.rgb, parent=True),
    shell:
        "({params.command} --image {input.image:q} --options {params.options:q} {params.drawing} "
        "--out {params.out:q} && "
        "{params.check}) 2>&1 | tee {log:q}"
