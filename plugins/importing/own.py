"""Import some models of a user's folder: an archive of them and its index."""

from pathlib import Path
from tempfile import TemporaryDirectory

from roomkin.plugins.importing.discover import Given, discover
from roomkin.plugins.importing.imports import by_suffix, import_models
from roomkin.stages.config.assets import OwnOptions
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_options
from roomkin.stages.contracts.library_folder import write_part


def run(*, folder: Path, models: tuple[str, ...], out: Path, options: str = "{}") -> None:
    """Write the index and, beside it, the archive of the models; what cannot be used is left out.

    Args:
        folder: of the user.
        models: <id>=<file> each, files below `folder`, named from there or from where you are.
        out: path of the index; the archive (.zip) gets the same name.
        options: JSON of the config section `assets`.
    """
    kinds = by_suffix(read_options(OwnOptions, options).importers)
    found = {one.path.absolute(): one for one in discover(folder, list(kinds))}
    wanted: dict[str, Given] = {}
    for name, _, file in (model.partition("=") for model in models):
        places = [place.absolute() for place in (folder / file, Path(file))]
        if not (here := [found[place] for place in places if place in found]):
            mend = "each of --models is <id>=<file>, the file of a model below --folder"
            raise InputError(folder, f"holds no model '{file}'.", mend, code="E-MODELS-NONE")
        wanted[name] = here[0]
    with TemporaryDirectory(prefix="acdc-own-") as made:
        _, left_out = import_models(wanted, kinds, Path(made))
        write_part(out, Path(made), left_out)
