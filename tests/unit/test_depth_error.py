"""How far depth errs: as it was made, measured at floor and walls, and read from objects.json by all."""

from pathlib import Path

import numpy as np
import pytest

from roomkin.stages.config.inputs import DepthNoiseConfig, ExtractionConfig
from roomkin.stages.contracts import Annotations, InputError, Objects
from roomkin.stages.contracts.files import parse_json
from roomkin.stages.contracts.objects import USUAL_ERROR, DepthError
from roomkin.stages.contracts.scenes import Annotation
from roomkin.stages.extraction.depth_error import PlanarPatch, measure_error
from roomkin.stages.extraction.noise import AnnotatedImage, noisy_depth
from roomkin.stages.extraction.reconstruct import reconstruct
from roomkin.stages.extraction.sources.folder import observe
from roomkin.stages.geometry.boxes import UprightBox
from tests.unit.synthetic_room import FLOOR, HEIGHT, INTRINSICS, OBJECT, WALL, WIDTH, trace, write_room

BOX = UprightBox([2.5, 0.0, 0.3], [0.5, 0.6, 0.6], 0.0)
NOISE = DepthNoiseConfig(range_constant=0.004, range_quadratic=0.002, scale=0)


@pytest.fixture(autouse=True)
def _even(monkeypatch: pytest.MonkeyPatch) -> None:
    """No further error at the picture's border."""
    monkeypatch.setattr("roomkin.stages.extraction.noise.PERIPHERY", 0.0)


def extracted(image: AnnotatedImage) -> Objects:
    return reconstruct("room", image, ExtractionConfig(), np.random.default_rng(0)).objects


def test_exact_depth_errs_as_the_noise_that_it_is_put_through(tmp_path: Path) -> None:
    folder, rng = write_room(tmp_path / "room", [BOX], ["box"]), np.random.default_rng(0)
    options = ExtractionConfig(noise=NOISE)
    assert extracted(observe(folder, options, rng)).depth_error == (0.004, 0.002)
    clean = options.model_copy(update={"depth_noise": "none"})
    assert extracted(observe(folder, clean, rng)).depth_error == (0, 0)


@pytest.mark.parametrize("named", [True, False])
def test_what_a_camera_measured_errs_as_floor_and_walls_are_uneven(named: bool) -> None:
    depth, masks = trace([BOX])
    told = Annotations(
        objects=[Annotation(mask=OBJECT, label="box")], floor=FLOOR if named else None, walls=[WALL] if named else []
    )
    rgb = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    noisy = noisy_depth(depth, NOISE, np.random.default_rng(0))
    found = extracted(AnnotatedImage(rgb, noisy, masks, INTRINSICS, told)).depth_error
    assert found.predict(3.0) == pytest.approx(0.022, rel=0.25)
    assert extracted(AnnotatedImage(rgb, depth, masks, INTRINSICS, told)).depth_error.predict(3.0) < 4e-3


def test_planes_seen_at_a_grazing_angle_or_hardly_at_all_tell_nothing() -> None:
    rng, eye, up = np.random.default_rng(0), np.array([0, 0, 1.5]), np.array([0, 0, 1.0])
    far, few = rng.uniform([20, -1, -0.1], [30, 1, 0.1], (4000, 3)), rng.uniform([1, -1, -0.1], [3, 1, 0.1], (99, 3))
    assert measure_error([PlanarPatch(far, up, 0.0), PlanarPatch(few, up, 0.0)], eye) is None
    heap = rng.uniform([1, -1, -0.9], [3, 1, 0.9], (4000, 3))
    assert measure_error([PlanarPatch(heap, up, 0.0)], eye) is None


def test_who_does_not_say_it_has_the_usual_error() -> None:
    text = '{"version": 1, "scene": "s", "width": 48, "height": 36, '
    text += '"intrinsics": [[50, 0, 23.5], [0, 50, 17.5], [0, 0, 1]], '
    text += '"floor_from_camera": [[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 1.5], [0, 0, 0, 1]], "walls": [], '
    assert parse_json(Objects, text + '"objects": []}', Path("objects.json")).depth_error == USUAL_ERROR
    with pytest.raises(InputError, match="depth_error"):
        parse_json(Objects, text + '"depth_error": [0.01, -1], "objects": []}', Path("objects.json"))
    assert DepthError(0.01, 0.002).predict(np.array([1.0, 10.0])) == pytest.approx([0.012, 0.21])
