# Helpers: what furnishes a room. Functions of a job's wildcards. No rules.
from roomkin.plugins.scenes.recipe import recipe_digest, room_files, series

ROOM_FILES = room_files(EXPERIMENT.room_files, CONFIG.implementations)


def room_shards(wildcards):
    """The models that furnish a room: of ours the procedural ones, the same whatever else is in the library."""
    return PROCEDURAL_SHARDS if PROCEDURAL_SHARDS and ROOM_FILES.get(wildcards.room) in series() else SHARDS


def room_library(wildcards):
    """Their index."""
    parts = expand("results/assets/library/shard_{shard}.json", shard=room_shards(wildcards))
    return parts if room_shards(wildcards) is PROCEDURAL_SHARDS else "results/assets/library/library.json"


def room_flags(wildcards):
    """The file of a room of the user's, and the seeds by which its perturbation has it drawn and painted."""
    path, protocol = ROOM_FILES.get(wildcards.room), EXPERIMENT.protocols.get(wildcards.get("protocol"))
    flags = {
        "--room": path if path is not None and path not in series() else None,
        "--layout-seed": wildcards.seed if protocol and protocol.layout == "drawn" else None,
        "--finish-seed": wildcards.seed if protocol and protocol.finish == "other" else None,
    }
    return " ".join(f"{flag} {shlex.quote(str(value))}" for flag, value in flags.items() if value is not None)
