# Helpers: which files a job reads, and which a report shows. Nothing here makes a file.


@cache
def features_of(variant, kind="features"):
    """The feature store that a variant uses, shard by shard; `kind`: features, or the index or companion beside them."""
    return files(getattr(rules.features.output, kind), store=matching_of(variant).store(), shard=SHARDS)


def beside_features(variant):
    """Index and companion of every shard of the feature store that a variant uses."""
    return [*features_of(variant, "index"), *features_of(variant, "companion")]


@cache
def snapshots_of(variant, kind):
    """The snapshots that a variant looks at, shard by shard, or their indices."""
    return pictures_of(variant, files(getattr(rules.snapshots.output, kind), shard=SHARDS))


def pictures_of(variant, files):
    """Files that matching looks at pictures in: none for a variant that compares no pictures."""
    return files if matching_of(variant).compares_pictures else []


def recipes_digest(wildcards):
    """Digest of what a room is made by: its own recipe and, for ours, those before it."""
    path, ours = CONFIG.room_files().get(room_of(wildcards)), series()
    used = ours[: ours.index(path) + 1] if path in ours else [path] if path else []
    return sha256(b"\0".join(file.read_bytes() for file in used)).hexdigest()[:12]


FILMS = {"film": "film.png", "films": "films.zip"}  # what our own verbs that film write


def filmed(stage, verb, folder, **labels):
    """Films of episodes as outputs of our own verb; a command in its place need not make any."""
    if verb in CONFIG.stages.get(stage, {}):
        return {}
    caption, category = "../report/captions/demos.rst", {"collect": "Demonstrations", "rollout": "Rollouts"}[verb]
    return {
        "film": report(f"{folder}/{FILMS['film']}", caption=caption, category=category, labels=labels),
        "films": f"{folder}/{FILMS['films']}",
    }


def scene_inputs(wildcards):
    """The files of a scene's input folder: rendered for rooms, the user's own for `experiment.inputs`."""
    own = EXPERIMENT.inputs.get(wildcards.scene)
    folder = own.place(wildcards.scene) if own else f"results/scenes/{pictured(wildcards)}/input"
    return {
        "rgb": f"{folder}/rgb.png",
        "camera": f"{folder}/camera.json",
        "depth": f"{folder}/depth.npz",
        "masks": f"{folder}/masks.png",
        "annotations": f"{folder}/annotations.json",
    }


def own_options(wildcards):
    """The config.yaml beside a picture of the user's: what it says of extraction suits that picture."""
    own = EXPERIMENT.inputs.get(wildcards.scene)
    path = Path(own.place(wildcards.scene), "config.yaml") if own and not own.alone else None
    return [str(path)] if path and (not own.folder or path.is_file()) else []


def scene_image(wildcards):
    """The scene's picture."""
    return scene_inputs(wildcards)["rgb"]


def in_report(path, kind, captions="../report/captions"):
    """A file that Snakemake's own report shows as well; `captions`: from the file of rules that asks."""
    caption = f"{captions}/{kind}.rst"
    return report(path, caption=caption, category=kind.capitalize(), labels={"name": Path(path).stem})


def matching_code(verb, *keys):
    """The code of a verb of matching with the implementations that some keys name."""
    return lambda wildcards: code("matching", verb, *modules(matching_of(wildcards.variant), *keys))


def open_code(*files):
    """Digest of files of the benchmark."""
    return lambda wildcards: files_digest(f"benchmarks/open_rooms/{name}" for name in files)


def open_pictures():
    """The names of all pictures."""
    from benchmarks.open_rooms import packs, rooms

    return [name for half in packs.HALVES for name in rooms.names(half)]
