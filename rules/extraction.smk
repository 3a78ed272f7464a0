# From an image to objects in space: masks, depth, floor and walls, clouds, mounting (paper A.2, A.7).
# Reads:  a scene's input folder.
# Writes: results/extraction/<scene>/{objects.json,masks.png,depth.npz,clouds.npz,overview.png}.


rule extract:
    """Find the objects of one scene."""
    input:
        unpack(scene_inputs),
    output:
        objects="results/extraction/{scene}/objects.json",
        masks="results/extraction/{scene}/masks.png",
        depth="results/extraction/{scene}/depth.npz",
        clouds="results/extraction/{scene}/clouds.npz",
        overview=report(
            "results/extraction/{scene}/overview.png",
            caption="../report/captions/scene.rst",
            category="Scenes",
            labels={"scene": "{scene}", "picture": "extraction"},
        ),
    log:
        "logs/extraction/{scene}.log",
    benchmark:
        "benchmarks/extraction/{scene}.tsv"
    container:
        CONFIG.containers.learning
    threads: 1
    resources:
        mem_mb=2000,
    params:
        command=command("extraction", "extract"),
        code=code("extraction", "extract"),
        check=check(objects="objects"),
        options=as_options(CONFIG.extraction),
        seed=CONFIG.seed,
        folder=subpath(input.rgb, parent=True),
    shell:
        "({params.command} --input {params.folder:q} --scene {wildcards.scene} --options {params.options:q} "
        "--seed {params.seed} --out {output.objects:q} && "
        "{params.check}) 2>&1 | tee {log:q}"


rule extraction:
    """Objects of all scenes."""
    input:
        expand(rules.extract.output.objects, scene=ROOMS),
    localrule: True
