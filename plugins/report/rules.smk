# Pages for people: one about a run and one about its times, one per picture, one over all pictures.
# Reads:  what the stages wrote, benchmark files.
# Writes: results/report/{index,times}.html, results/report/scenes/<scene>.html, results/report/overview/<variant>.html
#         (where a run of many scenes failed <variant>.failed.html), results/report/three.min.js.
from types import SimpleNamespace


include: "helpers.smk"


rule viewer:
    """The script by which pages turn a scene."""
    output:
        script="results/report/three.min.js",
    log:
        "logs/tables/viewer.log",
    localrule: True
    container:
        CONFIG.containers.report
    threads: 1
    resources:
        **needs(1000, 10),
    params:
        command=command("report", "viewer"),
        code=code("report", "viewer"),
    shell:
        "{params.command} --out {output.script:q} 2>&1 | tee {log:q}"


rule report_page:
    """One page that shows this run: what these inputs hold, and nothing else that lies in results/."""
    input:
        viewer=rules.viewer.output.script,
        library=rules.library.output.library,
        snapshots=files([*rules.snapshots.output], shard=SHARDS),
        sheets=files(rules.draw_snapshots.output.sheet, shard=SHARDS),
        images=[scene_image(SimpleNamespace(scene=room)) for room in SHOWN],
        objects=files(rules.extract.output.objects, scene=SHOWN),
        overviews=files(rules.draw_objects.output.overview, scene=SHOWN),
        cousins=files(rules.match.output.cousins, variant=VARIANTS, scene=SHOWN),
        scenes=files(rules.generate.output.scenes, variant=VARIANTS, scene=SHOWN),
        previews=files(
            [*rules.draw_scenes.output.previews, rules.draw_scenes.output.view], variant=VARIANTS, scene=SHOWN
        ),
        assets=[target_assets(name) for name in TARGETS],
        films=DEMO_FILMS,
        scene_films=SCENE_FILMS,
        rollout_films=ROLLOUT_FILMS,
        in_scene=in_scenes(rules.demonstrate_in_scene.output.in_scene),
        attempts=trained(rules.demonstrate.output.attempts),
        metrics=policies(rules.train.output.metrics, first=True),
        tables=rules.tables.input,
        pages=lambda wildcards: own_pages(SHOWN),
    output:
        page=in_report("results/report/index.html", "report", "../../report/captions"),
        times="results/report/times.html",
        config="results/report/config.yaml",
    log:
        "logs/tables/report.log",
    localrule: True
    container:
        CONFIG.containers.report
    threads: 1
    resources:
        **needs(2000, 30),
    params:
        command=command("report", "report"),
        paper=paper("table3"),
        code=code("report", "report"),
        options=options("report", "report"),
        images=lambda wildcards, input: [f"{room}={image}" for room, image in zip(SHOWN, input.images)],
        files=lambda wildcards, input: [file for file in input if file != input.viewer],
        benchmarks=BENCHMARKS,
        seed=CONFIG.seed,
        config=lambda wildcards: CONFIG.model_dump_json(),
        more=len(MORE),
    shell:
        "{params.command} --files {params.files:q} --viewer {input.viewer:q} --images {params.images:q} "
        "--benchmarks {params.benchmarks:q} --seed {params.seed} --config {params.config:q} --options {params.options:q} "
        '--published "$ACDC_PAPER" --more {params.more} --out {output.page:q} 2>&1 | tee {log:q}'


rule scene_page:
    """One page about one picture: what was found, cousins, scenes, every object's story, files to save."""
    input:
        unpack(scene_inputs),
        viewer=rules.viewer.output.script,
        snapshots=files([*rules.snapshots.output], shard=SHARDS),
        found=[*rules.extract.output, rules.draw_objects.output.overview],
        cousins=files(rules.match.output.cousins, variant=VARIANTS),
        scenes=files(rules.generate.output.scenes, variant=VARIANTS),
        drawn=files(
            [*rules.draw_scenes.output.previews, *rules.draw_scenes.output.exports, rules.draw_scenes.output.view],
            variant=VARIANTS,
        ),
    output:
        page=in_report("results/report/scenes/{scene}.html", "report", "../../report/captions"),
    log:
        "logs/tables/scene_page_{scene}.log",
    group:
        f"scene_{VARIANTS[-1]}"
    container:
        CONFIG.containers.report
    threads: 1
    resources:
        **needs(1000, 10),
    params:
        command=command("report", "picture"),
        code=code("report", "picture"),
        options=options("report", "picture"),
    shell:
        "{params.command} --files {input.snapshots:q} {input.found:q} {input.cousins:q} {input.scenes:q} {input.drawn:q} "
        "--image {input.rgb:q} --camera {input.camera:q} --scene {wildcards.scene} --viewer {input.viewer:q} "
        "--options {params.options:q} --out {output.page:q} 2>&1 | tee {log:q}"


rule pages:
    """A page of its own for every picture of the run."""
    input:
        files([rules.match.output.cousins, *rules.generate.output.scenes], variant=VARIANTS, scene=ROOMS),
        files(rules.scene_page.output.page, scene=ROOMS),
    localrule: True


rule photo:
    """The picture that `--config image=...` names, as scenes of cousins, and the page about them."""
    input:
        comparisons=of_picture(rules.draw_scenes.output.comparison),
        page=of_picture(rules.scene_page.output.page),
    localrule: True


include: "overview.smk"


onerror:
    tell_of_failures()


EVERYTHING += [rules.report_page.output, *([rules.overview.input] if MORE else [])]
