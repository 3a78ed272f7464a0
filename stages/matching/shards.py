"""Command `shards`: name the shards of the library that the objects of one picture may be compared with."""

import math
from collections.abc import Iterable, Sequence
from pathlib import Path

from roomkin.stages.config.matching import CandidateOptions
from roomkin.stages.contracts import Library, Objects, read_json, read_options, write_json
from roomkin.stages.contracts.errors import count
from roomkin.stages.contracts.library import LibraryEntry, SnapshotShard
from roomkin.stages.contracts.library_folder import SceneShards, holds, name_part
from roomkin.stages.matching.candidates import find_candidates
from roomkin.stages.matching.text_encoders import make_text_encoder

# Of a part, chosen: to start two jobs for it takes 4 s, a model .3 s; file names have 255 letters.
MODELS, CATEGORIES = 150, 40


def run(
    *,
    objects: Path,
    library: Path,
    out: Path,
    snapshots: Path = Path("results/assets/snapshots"),
    options: str = "{}",
) -> None:
    """Write shards.json: what is drawn already, as far as it holds candidates, and parts of the library to be drawn.

    Args:
        objects: objects.json of extraction.
        library: library.json of the assets stage.
        out: shards.json to write.
        snapshots: folder of the shards that are drawn; it may not exist yet.
        options: JSON of the config section `matching`, of candidates.
    """
    settings = read_options(CandidateOptions, options)
    whole, text = read_json(Library, library), make_text_encoder(settings)
    found = [item for item in read_json(Objects, objects).objects if item.status == "ok"]
    reached = {entry.category for item in found for entry in find_candidates(item, whole, text, settings).assets}
    wanted = [entry for entry in whole.assets if entry.category in reached] or whole.assets
    drawn = {
        path.stem.removeprefix("shard_"): set(read_json(SnapshotShard, path).assets)
        for path in sorted(snapshots.glob("shard_*.json"))
    }
    shards = choose_shards(wanted, drawn)
    write_json(out, SceneShards(shards=shards))
    held = {shard: {entry.id for entry in whole.assets if holds(shard, entry)} for shard in shards}
    lacking = sum(len(models) for shard, models in held.items() if drawn.get(shard) != models)  # a shard is drawn whole
    compared = f"{count(len(found), 'object')} to compare with {len(wanted)} of {count(len(whole.assets), 'model')}"
    print(f"{compared}; {lacking or 'none'} of the library must be drawn first")


def choose_shards(wanted: Sequence[LibraryEntry], drawn: Iterable[str]) -> list[str]:
    """Shards that hold the wanted models: of those drawn what holds any, then parts of the other models' categories."""
    chosen, left = [], list(wanted)
    for shard in drawn:
        rest = [entry for entry in left if not holds(shard, entry)]
        if len(rest) < len(left):
            chosen.append(shard)
        left = rest
    categories = sorted({entry.category for entry in left})
    parts = math.ceil(max(len(left) / MODELS, len(categories) / CATEGORIES))
    return chosen + [name_part(categories[number::parts]) for number in range(parts)]
