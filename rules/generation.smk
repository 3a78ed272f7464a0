# Scenes made of cousins: placement, support, walls, collisions, settling (paper A.3, A.7).
# Reads:  objects, cousins, library.
# Writes: results/generation/<variant>/<scene>/{scene_<rank>.json,scene_<rank>.png,scene_<rank>.glb,comparison.png}.


rule generate:
    """Place the cousins of every rank and let physics judge."""
    input:
        cousins=rules.match.output.cousins,
        objects=rules.extract.output.objects,
        clouds=rules.extract.output.clouds,
        image=scene_image,
        library=rules.library.output.library,
    output:
        scenes=[f"results/generation/{{variant}}/{{scene}}/scene_{rank}.json" for rank in RANKS],
        previews=[f"results/generation/{{variant}}/{{scene}}/scene_{rank}.png" for rank in RANKS],
        exports=[f"results/generation/{{variant}}/{{scene}}/scene_{rank}.glb" for rank in RANKS],
        comparison=report(
            "results/generation/{variant}/{scene}/comparison.png",
            caption="../report/captions/scene.rst",
            category="Scenes",
            labels={"scene": "{scene}", "picture": "reconstruction ({variant})"},
        ),
    log:
        "logs/generation/{variant}_{scene}.log",
    benchmark:
        "benchmarks/generation/{variant}_{scene}.tsv"
    container:
        CONFIG.containers.simulation
    threads: 1
    resources:
        mem_mb=3000,
    params:
        command=command("generation", "generate"),
        code=code("generation", "generate"),
        check=check(generated="scenes"),
        options=as_options(CONFIG.generation),
        seed=CONFIG.seed,
        out=subpath(output.comparison, parent=True),
    shell:
        "({params.command} --cousins {input.cousins:q} --objects {input.objects:q} --image {input.image:q} "
        "--library {input.library:q} --variant {wildcards.variant} --options {params.options:q} "
        "--seed {params.seed} --out {params.out:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule generation:
    """Generated scenes of all rooms and variants."""
    input:
        expand(rules.generate.output.comparison, variant=VARIANTS, scene=ROOMS),
    localrule: True


rule select:
    """Name the assets of a policy experiment: the matched object's twin, its cousins and a dissimilar one."""
    input:
        cousins=lambda wildcards: target_file(wildcards, rules.match.output.cousins),
        scene=lambda wildcards: target_file(wildcards, rules.generate.output.scenes[0]),
        library=rules.library.output.library,
        features=lambda wildcards: features_of(wildcards.variant),
    output:
        assets="results/matching/{variant}/task_{task}.json",
    log:
        "logs/matching/{variant}_task_{task}.log",
    benchmark:
        "benchmarks/matching/{variant}_task_{task}.tsv"
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        mem_mb=2000,
    params:
        command=command("matching", "select"),
        code=code("matching", "select"),
        check=check(task="assets"),
        options=matching_options,
        object=lambda wildcards: EXPERIMENT.tasks[wildcards.task].object,
        cousins=EXPERIMENT.cousins,
    shell:
        "({params.command} --cousins {input.cousins:q} --scene-file {input.scene:q} --object {params.object:q} "
        "--task {wildcards.task} --library {input.library:q} --features {input.features:q} "
        "--count {params.cousins} --options {params.options:q} --out {output.assets:q} && "
        "{params.check}) 2>&1 | tee {log:q}"
