"""The package as the core knows it."""

from pydantic import Field

from plugins.eyes.config import EyesSection
from plugins.eyes.weights import ALL, is_there
from stages.config.packages import Package


def check_weights() -> tuple[str, bool, str]:
    """The published weights: name, whether all are there, what."""
    lacking = [weights.name for weights in ALL if not is_there(weights)]
    if lacking:
        return "eyes", False, f"no {', '.join(lacking)}: python -m plugins.eyes fetch (110 MB)"
    return "eyes", True, "weights: MobileSAM, SSD MobileNet v2"


PACKAGE = Package(
    commands={"see": EyesSection, "fetch": None},
    section="eyes",
    sections={"eyes": (EyesSection, Field(EyesSection(), description="What finds the things of a picture (A.2)."))},
    check=check_weights,
)
