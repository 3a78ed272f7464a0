# What a picture with depth shows, found by itself: ground, walls, things and their names (paper A.2, first half).
# Reads:  a frame of the user's without masks; the networks' weights, as far as they are here (`make weights`).
# Writes: results/scenes/<scene>/frame/, an input folder with things.json: what was found, placed or not.
from plugins.eyes.weights import ALL as EYES, FOLDER as EYES_FOLDER


container: CONFIG.containers.learning


rule see:
    """Find and name the things of one frame."""
    input:
        rgb="results/scenes/{scene}/view/rgb.png",
        camera="results/scenes/{scene}/view/camera.json",
        depth="results/scenes/{scene}/view/depth.npz",
        weights=ancient([str(EYES_FOLDER / one.name) for one in EYES if (EYES_FOLDER / one.name).is_file()]),
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
        **needs(2000, 10),
    params:
        **command("eyes", "see", uses=modules(CONFIG.eyes, "proposers"), annotations="annotations", things="things"),
        picture=subpath(input.rgb, parent=True),
        out=subpath(output.rgb, parent=True),
    shell:
        "({params.command} --picture {params.picture:q} --options {params.options:q} --out {params.out:q} && "
        "{params.check}) 2>&1 | tee {log:q}"
