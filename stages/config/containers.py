"""Config section `containers`: the images that rules can run in."""

import re
from functools import cache
from hashlib import sha256
from pathlib import Path

from pydantic import Field, field_validator

from roomkin.stages.contracts.section import Section

ROOT = Path(__file__).resolve().parents[2]
LOCAL = "localhost/"  # of images that podman or docker built here


class ContainersConfig(Section):
    """One name for the images of all environment families."""

    image: str = Field(
        LOCAL + "acdc-{family}:{tag}",
        description="Image of a rule. {family}: simulation, learning or report; {tag}: digest of the "
        "Containerfile and of what it copies, so that an old image is not taken for a new one. "
        "For yours in a registry: docker://REGISTRY/acdc-{family}:{tag}.",
    )

    @field_validator("image")
    @classmethod
    def _of_families(cls, image: str) -> str:
        if "{family}" not in image:
            raise ValueError("names no {family}: simulation, learning and report have an image each")
        return image

    @property
    def template(self) -> str:
        """The image as podman and docker name it, with {family} to be filled in."""
        return self.image.replace("{tag}", tag()).removeprefix("docker://")

    def _apptainer(self, family: str) -> str:
        """The value of the directive `container:` of a family's rules: local images are files in images/."""
        image = self.image.replace("{tag}", tag()).replace("{family}", family)
        if not image.startswith(LOCAL):
            return image
        return f"images/{image.removeprefix(LOCAL).replace(':', '-').replace('/', '-')}.sif"

    @property
    def simulation(self) -> str:
        """Of rules that render or simulate."""
        return self._apptainer("simulation")

    @property
    def learning(self) -> str:
        """Of rules that train or match."""
        return self._apptainer("learning")

    @property
    def report(self) -> str:
        """Of rules that only make tables and pages."""
        return self._apptainer("report")


@cache
def tag() -> str:
    """Digest of the Containerfile and of what it copies; "none" where the package is installed without them."""
    recipe = ROOT / "containers/Containerfile"
    text = recipe.read_text() if recipe.is_file() else ""
    files = [recipe, *(ROOT / name for name in re.findall(r"^COPY (\S+)", text, re.MULTILINE))]
    if not all(path.is_file() for path in files):
        return "none"
    digest = sha256()
    for path in files:
        digest.update(f"{path.relative_to(ROOT)} {sha256(path.read_bytes()).hexdigest()}\n".encode())
    return digest.hexdigest()[:12]


if __name__ == "__main__":
    print(ContainersConfig().template)
