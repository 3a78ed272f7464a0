"""corrections.json of an input folder, as its page reads and writes it."""

from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roomkin.plugins.annotator.shown import ShownThing, UnmatchedLine
from roomkin.stages.contracts.hand import (
    CORRECTIONS,
    MEASURED,
    Correction,
    Corrections,
    Unmatched,
    digest_of_picture,
    find_hand_file,
    read_corrections,
)
from roomkin.stages.contracts.matched import digest_masks, match_corrections, show_masks


class Said:
    """What a person said of the picture of a folder; `path`: where that is kept."""

    def __init__(self, folder: Path) -> None:
        self._digest = digest_of_picture(folder)
        self.path = find_hand_file(folder, CORRECTIONS, lambda: self._digest)
        self._unmatched: dict[str, Unmatched] = {}  # by keys: all that the page may have seen

    def read(self, masks: NDArray[np.uint16]) -> tuple[dict[int, Correction], list[UnmatchedLine]]:
        """The corrections by the values of masks (H, W); those of what is not found there now.

        Raises:
            InputError: what was saved is broken.
        """
        saved = read_corrections([self.path] if self.path.is_file() else [])
        matched = match_corrections(saved, masks, self._digest)
        keys = [sha256(one.model_dump_json().encode()).hexdigest()[:12] for one in matched.unmatched]
        self._unmatched |= zip(keys, matched.unmatched, strict=True)
        return matched.corrections, [UnmatchedLine(key=key, text=matched.lines[k]) for k, key in enumerate(keys)]

    def state(
        self,
        corrections: Sequence[Correction],
        unmatched: Sequence[UnmatchedLine],
        masks: NDArray[np.uint16],
        labels: Mapping[int, str],
    ) -> Corrections:
        """What is to be written: with the picture, and what the masks (H, W), called by `labels`, show."""
        named = {mask for item in corrections for mask in item.named_masks}
        return Corrections(
            digest=self._digest,
            size=(masks.shape[1], masks.shape[0]),
            masks=digest_masks(masks),
            shown=show_masks(named, masks, labels),
            objects=list(corrections),
            unmatched=[self._unmatched[one.key] for one in unmatched],
        )


def find_changes(before: Correction, now: ShownThing) -> dict[str, Any]:
    """What a person says otherwise of a thing than was found."""
    given = now.model_dump(exclude={"id", "mask", "gone"}, exclude_defaults=True)
    changes = {name: value for name, value in given.items() if getattr(now, name) != getattr(before, name)}
    return changes | ({"mounting": MEASURED} if before.mounting is not None and now.mounting is None else {})
