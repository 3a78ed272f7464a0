# Helpers: scenes that are rooms met otherwise, `<room>.<protocol>.<seed>` (experiment.protocols). Nothing here makes a file.
from types import SimpleNamespace


def room_of(wildcards):
    """The room that a scene shows."""
    return EXPERIMENT.meeting(wildcards.scene).room


def pictured(wildcards):
    """The scene whose picture a scene is seen in: only some protocols take their own."""
    met = EXPERIMENT.meeting(wildcards.scene)
    return wildcards.scene if met.protocol.pictured else met.room


def room_library(wildcards):
    """What furnishes a room: ours with procedural models, the same whatever else is in the library; yours with all."""
    ours = CONFIG.room_files().get(room_of(wildcards)) in series()
    if not (ours and PROCEDURAL):
        return LIBRARY
    parts, models = (
        expand("results/assets/library/shard_{shard}.{kind}", shard=range(PROCEDURAL), kind=kind)
        for kind in ("json", "zip")
    )
    return {"library": parts, "models": ancient(models)}


def seed_of(wildcards):
    """The seed of the depth noise."""
    seed = EXPERIMENT.meeting(wildcards.scene).seed
    return CONFIG.seed if seed is None else seed


def truth_of(wildcards):
    """The truth of a scene. `evaluation` reads it, and the policy experiment, whose twin is the object's true model."""
    return f"results/scenes/{pictured(wildcards)}/truth.json"


def known_truth(wildcards):
    """The truth of a scene, or of the room of a target; none if it is one of the user's."""
    scene = EXPERIMENT.targets[wildcards.target].room if "target" in wildcards.keys() else wildcards.scene
    return [] if scene in EXPERIMENT.inputs else truth_of(SimpleNamespace(scene=scene))


def truth_flags(wildcards, input):
    """The flags that name the truth of a scene and the objects that are seen in it."""
    return shlex.join(["--truth", str(input.truth), "--objects", str(input.objects)]) if input.truth else ""


def left_out(wildcards):
    """The file that names the models which matching may not use."""
    unknown = EXPERIMENT.meeting(wildcards.scene).protocol.unknown
    return [f"results/evaluation/left_out/{wildcards.scene}.json"] if unknown else []


def met(pattern):
    """The files of `pattern` for all scenes of all protocols."""
    every = [file for scene, variants in MET.items() for file in files(pattern, scene=scene, variant=variants)]
    return list(dict.fromkeys(every))


def room_flags(wildcards):
    """The file of a room of the user's, and the seeds by which the protocol has it drawn."""
    room, _, seed, protocol = EXPERIMENT.meeting(wildcards.scene)
    path = CONFIG.room_files().get(room)
    flags = {
        "--room": path if path is not None and path not in series() else None,
        "--layout-seed": seed if protocol.layout == "drawn" else None,
        "--finish-seed": seed if protocol.finish == "other" else None,
    }
    return " ".join(f"{flag} {shlex.quote(str(value))}" for flag, value in flags.items() if value is not None)
