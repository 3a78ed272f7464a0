"""Import some models of a user's folder: an archive of them and its index."""

from pathlib import Path
from tempfile import TemporaryDirectory

from stages.assets.discover import discover
from stages.assets.imports import by_suffix, import_models
from stages.config.assets import OwnOptions
from stages.contracts.errors import InputError
from stages.contracts.files import read_options
from stages.contracts.library_folder import write_part


def run(*, folder: Path, models: tuple[str, ...], out: Path, options: str = "{}") -> None:
    """Write the index and, beside it, the archive of the models; what cannot be used is left out.

    Args:
        folder: of the user.
        models: <id>=<file> each, files below `folder`.
        out: path of the index; the archive (.zip) gets the same name.
        options: JSON of the config section `assets`.
    """
    kinds = by_suffix(read_options(OwnOptions, options).importers)
    names = {Path(file): name for name, _, file in (model.partition("=") for model in models)}
    wanted = {names[one.path]: one for one in discover(folder, list(kinds)) if one.path in names}
    if gone := set(names.values()) - set(wanted):
        raise InputError(
            folder, f"holds no model of '{min(gone)}'.", "each of --models is <id>=<file>", code="E-MODELS-NONE"
        )
    with TemporaryDirectory(prefix="acdc-own-") as made:
        _, left_out = import_models(wanted, kinds, Path(made))
        write_part(out, Path(made), left_out)
