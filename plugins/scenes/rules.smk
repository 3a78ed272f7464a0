# Sim-to-sim rooms: what a camera sees, and apart from it the truth (paper B.1, Table 2).
# Reads:  the procedural models; for rooms of yours the whole library; what `experiment.inputs` names.
# Writes: results/scenes/<scene>/input/{rgb.png,camera.json,depth.npz,masks.png,annotations.json}
#         and results/scenes/<scene>/truth.json, by which nothing is matched or placed.
# The `scene` of later rules is a `<room>` of Table 2, the same `<room>.<protocol>.<seed>`, or a picture of the user's.


include: "helpers.smk"


container: CONFIG.containers.simulation


rule room:
    """Furnish one room with models of the library and photograph it."""
    input:
        library=room_library,
        models=ancient(expand("results/assets/library/shard_{shard}.zip", shard=room_shards)),
    output:
        rgb="results/scenes/{room}/input/rgb.png",
        camera="results/scenes/{room}/input/camera.json",
        depth="results/scenes/{room}/input/depth.npz",
        masks="results/scenes/{room}/input/masks.png",
        annotations="results/scenes/{room}/input/annotations.json",
        truth="results/scenes/{room}/truth.json",
    log:
        "logs/scenes/{room}.log",
    benchmark:
        "benchmarks/scenes/{room}.tsv"
    resources:
        **needs(2000, 10),
    params:
        **command("scenes", "render", camera="camera", annotations="annotations", truth="truth"),
        room=room_flags,
        recipe=lambda wildcards: recipe_digest(ROOM_FILES.get(wildcards.room)),
        seed=CONFIG.seed,
        out=subpath(output.truth, parent=True),
    shell:
        "({params.command} --library {input.library:q} --scene {wildcards.room} --options {params.options:q} "
        "--seed {params.seed} {params.room} --out {params.out:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


use rule room as room_by_protocol with:
    output:
        rgb="results/scenes/{room}.{protocol}.{seed}/input/rgb.png",
        camera="results/scenes/{room}.{protocol}.{seed}/input/camera.json",
        depth="results/scenes/{room}.{protocol}.{seed}/input/depth.npz",
        masks="results/scenes/{room}.{protocol}.{seed}/input/masks.png",
        annotations="results/scenes/{room}.{protocol}.{seed}/input/annotations.json",
        truth="results/scenes/{room}.{protocol}.{seed}/truth.json",
    log:
        "logs/scenes/{room}.{protocol}.{seed}.log",
    benchmark:
        "benchmarks/scenes/{room}.{protocol}.{seed}.tsv"


rule scenes:
    """The rooms of this run."""
    input:
        expand("results/scenes/{room}/input/rgb.png", room=SCORED_ROOMS),
    localrule: True


rule scenes8:
    """All eight rooms of Table 2."""
    input:
        expand("results/scenes/room_{number}/input/rgb.png", number=range(1, 9)),
    localrule: True


ADDED["all"] += [rules.scenes.input]
