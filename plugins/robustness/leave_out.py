"""`leave_out`: the true models of a room and their whole families, left out of matching (perturbation `unknown`)."""

from pathlib import Path

from roomkin.stages.contracts import LeftOut, Truth, read_json, write_json
from roomkin.stages.contracts.library_folder import AssetFolders


def run(*, truth: Path, library: Path, out: Path) -> None:
    """Name every model of the true models' families: templates with their variations.

    A relative that stayed in the library would be nearly the model itself. This is all that matching learns of the
    truth.

    Args:
        truth: truth.json of the room.
        library: library.json, its archives beside it.
        out: JSON file of the ids.
    """
    true = {item.asset for item in read_json(Truth, truth).objects}
    models = AssetFolders(library)
    family = {asset: models.asset(asset).family for asset in models}
    gone = {family.get(asset, asset) for asset in true}
    write_json(out, LeftOut(assets=sorted(asset for asset, of in family.items() if of in gone)))
