"""Which model of the library an object of a room truly is: truth and extraction are matched by mask value."""

from pathlib import Path

from stages.contracts.errors import InputError
from stages.contracts.files import read_json
from stages.contracts.objects import Objects
from stages.contracts.scenes import Truth


def true_model(truth: Path | None, objects: Path | None, object: str) -> str | None:
    """Id of the true model of a named object; None without a truth, or if the truth does not know the object.

    Args:
        truth: truth.json of the room.
        objects: objects.json of extraction, of the same room.
        object: id of the object in objects.json.

    Raises:
        InputError: one file was given without the other, or they are of different rooms.
    """
    if truth is None and objects is None:
        return None
    if truth is None or objects is None:
        raise InputError("--truth, --objects", "one is given without the other.", "give both or neither")
    true, seen = read_json(Truth, truth), read_json(Objects, objects)
    if true.scene != seen.scene:
        raise InputError(truth, f"is of {true.scene}, but {objects} of {seen.scene}.")
    mask = next((item.mask for item in seen.objects if item.id == object), None)
    return next((item.asset for item in true.objects if item.mask == mask), None)
