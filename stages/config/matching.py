"""Config section `matching`: digital cousins of every object (paper A.6, A.7, B.1)."""

import json
from collections.abc import Iterable
from hashlib import sha256
from typing import Any

from pydantic import Field, model_validator

from roomkin.stages.config.packages import with_sections
from roomkin.stages.contracts.section import KWARGS_BY_NAME, Section
from roomkin.stages.plugins import list_available, shorten_name

JUDGE = "geometry" if "geometry" in list_available("judges") else "distance"  # the paper's where that package is not
BLIND = {"priors"}  # judges that look at no picture


class HogConfig(Section):
    """Dense histograms of gradients at three scales, patch position and, where there is depth, surface normals."""

    image_size: int = Field(192, ge=32, description="The object's crop is resized to a square of so many pixels ...")
    grid: int = Field(16, ge=4, description="... and cut into grid x grid patches; divides image_size.")
    normals: float = Field(1.8, ge=0, description="Weight of the normals against the gradients. 0: never used.")
    position: float = Field(1.5, ge=0, description="Weight of a patch's place in the crop, with normals.")
    position_alone: float = Field(2.0, ge=0, description="Weight of a patch's place in the crop, without normals.")

    @model_validator(mode="after")
    def _check_grid(self) -> "HogConfig":
        if self.image_size % self.grid:
            raise ValueError(f"grid {self.grid} does not divide image_size {self.image_size}")
        return self

    def list_unread(self) -> set[str]:
        """Weights, which a feature store does not depend on."""
        return {"normals", "position", "position_alone"}


class Dinov2Config(Section):
    """The paper's encoder (ViT-S/14 in the official code)."""

    path: str = Field(
        "", description='Folder with config.json and model.safetensors. "": ViT-S/14 as `make weights` fetches it.'
    )
    height: int = Field(224, ge=28, description="The crop is resized to height x width (official code: 588 ...")
    width: int = Field(224, ge=28, description="... x 784), multiples of the patch size.")


class EncoderOptions(Section):
    """The patch encoder, with its options."""

    encoder: str = Field(
        "hog",
        json_schema_extra={"kind": "encoders"},
        description="Patch features. hog: needs no weights. dinov2: the paper's.",
    )
    dimensions: int | None = Field(
        None,
        ge=0,
        description="Features are stored as so many principal components of one byte each: 72 take a seventh of the "
        "disk. 0: as they are. null: 72 in a library of more than 2,000 models, else 0.",
    )
    hog: HogConfig = Field(HogConfig(), description="The encoder `hog`.")
    dinov2: Dinov2Config = Field(Dinov2Config(), description="The encoder `dinov2`.")
    kwargs: dict[str, dict[str, Any]] = KWARGS_BY_NAME

    def list_unread(self) -> set[str]:
        """The options of encoders that are not used."""
        return {"hog", "dinov2"} - {self.encoder}

    def keep_stored(self) -> dict[str, Any]:
        """The options that the rows of a feature store depend on: weights are laid on them later."""
        given = getattr(self, self.encoder, None)
        if not isinstance(given, Section):
            name = shorten_name(self.encoder)
            read: dict[str, Any] = {"kwargs": {name: self.kwargs[name]} if name in self.kwargs else {}}
        else:
            read = {self.encoder: given.model_dump(mode="json", exclude=given.list_unread())}
        return {"encoder": self.encoder, "dimensions": self.dimensions or 0} | read

    def store(self) -> str:
        """Name of the feature store: two variants share one if it holds the same for both."""
        digest = sha256(json.dumps(self.keep_stored(), sort_keys=True).encode()).hexdigest()
        return f"{shorten_name(self.encoder)}-{digest[:8]}"


class ComparisonOptions(EncoderOptions):
    """How patches are compared."""

    search: str = Field(
        "torch", json_schema_extra={"kind": "searches"}, description="Nearest patches; both give the same picks."
    )
    exclude_worst: float = Field(
        0.10, ge=0, lt=1, description="Share of the largest patch distances left out of the mean (paper: 0.10)."
    )


class CandidateOptions(Section):
    """Which models an object is compared with at all."""

    text_encoder: str = Field(
        "lexical",
        json_schema_extra={"kind": "text_encoders"},
        description="How labels are compared with categories. clip: the official code's; give its folder, clip.",
    )
    k_cat: int = Field(3, ge=1, description="Nearest categories to search.")
    count_threshold: int | None = Field(
        2,
        ge=0,
        description="Largest |d doors| + |d drawers| between an articulated object and its cousin (A.7; paper: 2). "
        "Widened, and noted, if fewer than least_candidates are left. null: off.",
    )
    least_candidates: int = Field(
        10,
        ge=1,
        description="So many candidates an object has if the library has them: else count_threshold is widened, and "
        "the next nearest categories come in (paper: 1).",
    )
    clip: str = Field("", description="Folder with the weights of the text encoder `clip`.")
    kwargs: dict[str, dict[str, Any]] = KWARGS_BY_NAME


class MatchingSection(ComparisonOptions, CandidateOptions):
    """From objects to ranked models of the library, each with its orientation."""

    shortlist: int | None = Field(
        None,
        ge=0,
        description="Models compared patch by patch: those nearest by their views as a whole and by what is known "
        "(label, size, counts, place). 0: all. null: 100 in a library of more than 2,000 models, else all.",
    )
    k_model: int = Field(10, ge=1, description="Models taken from them by voting (paper: 10).")
    k_ori: int = Field(4, ge=1, description="Orientations taken from a model's views (paper: 4).")
    k_cousins: int = Field(10, ge=1, description="Ranked cousins per object.")
    views: int = Field(
        12, ge=0, description="Yaw views by which a model is compared. 0: its representative snapshot alone (paper)."
    )
    nearest_views: int = Field(
        2, ge=1, description="The mean over so many of its nearest views is a model's distance: most stand between two."
    )
    model_selection: str = Field(
        JUDGE,
        json_schema_extra={"kind": "judges"},
        description="What ranks the models: distance (of embeddings; A.6, B.1), votes (A.6, official code), or, among "
        "the nearest, geometry (renderings in place) or vlm (a language model, B.1); priors: label, counts, box and "
        "mounting alone.",
    )
    orientation_selection: str = Field(
        JUDGE,
        json_schema_extra={"kind": "judges"},
        description="What ranks the orientations: distance (of embeddings), votes (official code), rerender (distance "
        "to views rendered again, B.1), geometry (renderings in place), vlm (a language model, B.1), or priors (box "
        "and mounting alone).",
    )
    symmetric: float = Field(
        0.5,
        ge=0,
        le=1,
        description="Share, in a distance, of the way back from the picture's patches to the object's (paper: 0).",
    )
    colour: float = Field(
        0.0, ge=0, description="Weight of the patches' colors (Lab, a difference of 30 counts as 1; paper: 0)."
    )
    label_weight: float = Field(
        2.0,
        ge=0,
        description="What the distance between label and category adds to a model's distance (paper: 0). Labels and "
        "counts are stated: they count more than what pictures differ in.",
    )
    size_weight: float = Field(
        0.2, ge=0, description="What a model's own size adds: mean |log ratio| to the object's box (paper: 0)."
    )
    place_weight: float = Field(
        0.2,
        ge=0,
        description="What it adds if the object hangs on a wall and the model does not belong there, or the other way "
        "round (paper: 0).",
    )
    count_weight: float = Field(
        0.3, ge=0, description="What every door and drawer adds that an articulated model has more or less (paper: 0)."
    )

    def weights(self) -> dict[str, str]:
        """Folders of the pretrained networks that are used, by their keys; "": the published file of DINOv2."""
        folders = {"dinov2.path": (self.encoder, self.dinov2.path), "clip": (self.text_encoder, self.clip)}
        return {key: folder for key, (used, folder) in folders.items() if used == key.partition(".")[0]}

    @property
    def compares_pictures(self) -> bool:
        """Whether any picture of the library is looked at: if not, matching needs neither features nor snapshots."""
        return not {self.model_selection, self.orientation_selection} <= BLIND


class MatchingConfig(MatchingSection):
    """The section, and those of packages for their judges: what `matching match` reads."""

    @classmethod
    def list_package_sections(cls) -> set[str]:
        """The sections of packages."""
        return set(cls.model_fields) - set(MatchingSection.model_fields)

    def list_unread(self) -> set[str]:
        """The options of encoders and judges that are not used; judges of yours may read all."""
        judges = {self.model_selection, self.orientation_selection}
        for section in [getattr(self, name) for name in self.list_package_sections() & judges]:
            judges |= section.list_judges()
        ours = all(judge == shorten_name(judge) for judge in judges)
        silent = self.list_package_sections() - judges if ours else set()
        return super().list_unread() | {"clip"} - {self.text_encoder} | silent

    def keep_deciding(self) -> "MatchingConfig":
        """The options with those of packages as far as they decide on answers."""
        names = self.list_package_sections()
        return self.model_copy(update={name: getattr(self, name).keep_deciding() for name in names})


def matching_model(packages: Iterable[str]) -> type[MatchingConfig]:
    """The options with the sections that these packages' judges read."""
    return with_sections(MatchingConfig, packages, judges=True)
