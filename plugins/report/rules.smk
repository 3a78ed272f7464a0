# Pages for people: one about a run and one about its times, one per picture, one over all pictures.
# Reads:  what the stages wrote, benchmark files.
# Writes: results/report/{index,times}.html, results/report/scenes/<scene>.html, results/report/overview/<variant>.html
#         (where a run of many scenes failed <variant>.failed.html), results/report/three.min.js.


container: CONFIG.containers.report


include: "helpers.smk"


rule viewer:
    """The script by which pages turn a scene."""
    output:
        script="results/report/three.min.js",
    log:
        "logs/tables/viewer.log",
    localrule: True
    resources:
        **needs(1000, 10),
    params:
        **command("report", "viewer"),
    shell:
        "{params.command} --out {output.script:q} 2>&1 | tee {log:q}"


rule report_page:
    """One page that shows this run: what these inputs hold, and nothing else that lies in results/."""
    input:
        viewer="results/report/three.min.js",
        library="results/assets/library/library.json",
        snapshots=expand(
            ["results/assets/snapshots/shard_{shard}.h5", "results/assets/snapshots/shard_{shard}.json"],
            shard=SHARDS,
        ),
        sheets=expand("results/assets/snapshots/shard_{shard}.png", shard=SHARDS),
        images=[f"{EXPERIMENT.input_folder(room)}/rgb.png" for room in REPORT_ROOMS],
        objects=expand("results/extraction/{scene}/objects.json", scene=REPORT_ROOMS),
        overviews=expand("results/extraction/{scene}/overview.png", scene=REPORT_ROOMS),
        cousins=expand("results/matching/{variant}/{scene}/cousins.json", variant=VARIANTS, scene=REPORT_ROOMS),
        scenes=expand(
            "results/generation/{variant}/{scene}/scene_{rank}.json", rank=RANKS, variant=VARIANTS, scene=REPORT_ROOMS
        ),
        previews=expand(
            "results/generation/{variant}/{scene}/scene_{rank}.png", rank=RANKS, variant=VARIANTS, scene=REPORT_ROOMS
        ),
        views=expand(
            "results/generation/{variant}/{scene}/view_{rank}.glb", rank=RANKS, variant=VARIANTS, scene=REPORT_ROOMS
        ),
        assets=expand("results/experiment/{variant}/{target}/assets.json", variant=POLICY_VARIANT, target=TARGETS),
        films=DEMO_FILMS,
        scene_films=SCENE_FILMS,
        rollout_films=ROLLOUT_FILMS,
        in_scene=expand("results/demonstrations/{target}/in_scene/in_scene.json", target=SCENE_TARGETS),
        attempts=expand("results/demonstrations/{target}/{role}/attempts.jsonl", zip, **DEMONSTRATED),
        metrics=policies("results/training/{target}/{policy}/{training_set}/{run}/seed_{seed}/metrics.jsonl", count=1),
        tables=[*TRAININGS, *rules.table2.output, *rules.table3.output],
        companion=added("table2"),
        pages=lambda wildcards: own_pages(REPORT_ROOMS),
    output:
        page="results/report/index.html",
        times="results/report/times.html",
        config="results/report/config.yaml",
    log:
        "logs/tables/report.log",
    localrule: True
    resources:
        **needs(2000, 30),
    params:
        **command("report", "report"),
        paper=paper("table3"),
        images=lambda wildcards, input: [f"{room}={image}" for room, image in zip(REPORT_ROOMS, input.images)],
        files=lambda wildcards, input: [file for file in input if file != input.viewer],
        benchmarks=[ROOT + path for path in BENCHMARKS],
        benchmarks_root=f"{ROOT}benchmarks",
        seed=CONFIG.seed,
        config=lambda wildcards: CONFIG.model_dump_json(),
        more=len(FURTHER_ROOMS),
    shell:
        "{params.command} --files {params.files:q} --viewer {input.viewer:q} --images {params.images:q} "
        "--benchmarks {params.benchmarks:q} --benchmarks-root {params.benchmarks_root:q} --seed {params.seed} --config {params.config:q} --options {params.options:q} "
        '--published "$ACDC_PAPER" --more {params.more} --out {output.page:q} 2>&1 | tee {log:q}'


rule scene_page:
    """One page about one picture: what was found, cousins, scenes, every object's story, files to save."""
    input:
        rgb=input_file("rgb.png"),
        camera=input_file("camera.json"),
        depth=input_file("depth.npz"),
        masks=input_file("masks.png"),
        annotations=input_file("annotations.json"),
        viewer="results/report/three.min.js",
        snapshots=expand(
            ["results/assets/snapshots/shard_{shard}.h5", "results/assets/snapshots/shard_{shard}.json"],
            shard=scene_shards,
        ),
        found=expand(
            "results/extraction/{scene}/{file}",
            file=["objects.json", "masks.png", "depth.npz", "clouds.npz", "overview.png"],
            allow_missing=True,
        ),
        cousins=expand("results/matching/{variant}/{scene}/cousins.json", variant=VARIANTS, allow_missing=True),
        scenes=expand(
            "results/generation/{variant}/{scene}/scene_{rank}.json", rank=RANKS, variant=VARIANTS, allow_missing=True
        ),
        previews=expand(
            "results/generation/{variant}/{scene}/scene_{rank}.png", rank=RANKS, variant=VARIANTS, allow_missing=True
        ),
        exports=expand(
            "results/generation/{variant}/{scene}/scene_{rank}.glb", rank=RANKS, variant=VARIANTS, allow_missing=True
        ),
        views=expand(
            "results/generation/{variant}/{scene}/view_{rank}.glb", rank=RANKS, variant=VARIANTS, allow_missing=True
        ),
    output:
        page="results/report/scenes/{scene}.html",
    log:
        "logs/tables/scene_page_{scene}.log",
    group:
        lambda wildcards: scene_group({"scene": wildcards.scene, "variant": VARIANTS[-1]})
    resources:
        **needs(1000, 10),
    params:
        **command("report", "picture"),
    shell:
        "{params.command} --files {input.snapshots:q} {input.found:q} {input.cousins:q} {input.scenes:q} {input.previews:q} {input.exports:q} {input.views:q} "
        "--image {input.rgb:q} --camera {input.camera:q} --scene {wildcards.scene} --viewer {input.viewer:q} "
        "--options {params.options:q} --out {output.page:q} 2>&1 | tee {log:q}"


rule pages:
    """A page of its own for every picture of the run."""
    input:
        expand("results/matching/{variant}/{scene}/cousins.json", variant=VARIANTS, scene=ROOMS),
        expand("results/generation/{variant}/{scene}/scene_{rank}.json", rank=RANKS, variant=VARIANTS, scene=ROOMS),
        expand("results/report/scenes/{scene}.html", scene=ROOMS),
    localrule: True


include: "overview.smk"


onsuccess:
    tell_of_pages()


onerror:
    tell_of_failures(log)


ADDED["photo"] += expand("results/report/scenes/{scene}.html", scene=ROOMS)
ADDED["all"] += [rules.report_page.output, *([rules.overview.input] if FURTHER_ROOMS else [])]
