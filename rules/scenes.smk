# Sim-to-sim rooms: what a camera sees, and apart from it the truth (paper B.1, Table 2).
# Reads:  the procedural models; for rooms of yours the whole library; what `experiment.inputs` names.
# Writes: results/scenes/<scene>/input/{rgb.png,camera.json,depth.npz,masks.png,annotations.json}
#         and results/scenes/<scene>/truth.json, by which nothing is matched or placed.


rule room:
    """Furnish one room with models of the library and photograph it."""
    input:
        unpack(room_library),
    output:
        rgb="results/scenes/{scene}/input/rgb.png",
        camera="results/scenes/{scene}/input/camera.json",
        depth="results/scenes/{scene}/input/depth.npz",
        masks="results/scenes/{scene}/input/masks.png",
        annotations="results/scenes/{scene}/input/annotations.json",
        truth="results/scenes/{scene}/truth.json",
    log:
        "logs/scenes/{scene}.log",
    benchmark:
        "benchmarks/scenes/{scene}.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        **needs(2000, 10),
    params:
        command=command("scenes", "render"),
        code=code("scenes", "render"),
        check=check(camera="camera", annotations="annotations", truth="truth"),
        options=options("scenes", "render"),
        name=room_of,
        room=room_flags,
        recipes=recipes_digest,
        seed=CONFIG.seed,
        out=subpath(output.truth, parent=True),
    shell:
        "({params.command} --library {input.library:q} --scene {params.name} --options {params.options:q} "
        "--seed {params.seed} {params.room} --out {params.out:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule scenes:
    """The rooms of this run."""
    input:
        files(rules.room.output.rgb, scene=SCORED_ROOMS),
    localrule: True


rule scenes8:
    """All eight rooms of Table 2."""
    input:
        files(rules.room.output.rgb, scene=[f"room_{k}" for k in range(1, 9)]),
    localrule: True
