"""What the two networks see, with their published weights, in drawn pictures and in a real frame."""

import os
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from roomkin.stages.perception.segmentation.decoder import WIDTH, TokenAttention
from roomkin.stages.perception.segmentation.mobile_sam import Embedded, MobileSam, Outlines
from roomkin.stages.perception.segmentation.ssd import NAMES, Ssd, overlap
from tests.refusals import refused

FRAME = Path(os.environ.get("ACDC_TEST_DATA", Path(__file__).resolve().parents[4] / "shared/data")) / "rooms" / "living"
MIDDLE = (300, 150)  # x, y of the sign
HEIGHT, WIDE = 360, 480


def octagon(radius: float) -> NDArray[np.int32]:
    """Corners (8, 2) around the middle."""
    angles = np.pi / 8 + np.arange(8) * np.pi / 4
    return np.rint(MIDDLE + radius * np.stack([np.cos(angles), np.sin(angles)], 1)).astype(np.int32)


def draw_sign() -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """A stop sign on its pole, between sky and grass: the picture, and where its octagon is."""
    rgb = np.full((HEIGHT, WIDE, 3), (150, 190, 230), np.uint8)
    rgb[240:] = 90, 120, 80
    cv2.rectangle(rgb, (295, 200), (305, HEIGHT - 1), (120, 120, 120), -1)
    cv2.fillPoly(rgb, [octagon(75)], (245, 245, 245))
    cv2.fillPoly(rgb, [octagon(69)], (190, 20, 30))
    cv2.putText(rgb, "STOP", (243, 168), cv2.FONT_HERSHEY_SIMPLEX, 1.6, (250, 250, 250), 6)
    return rgb, cv2.fillPoly(np.zeros((HEIGHT, WIDE), np.uint8), [octagon(75)], 1) > 0


def best_overlap(picture: Embedded, outlines: Outlines, truth: NDArray[np.bool_]) -> float:
    """IoU of the guess with the best score for the first prompt, at the size of the picture."""
    found = picture.upsample(outlines.logits[0, outlines.scores[0].argmax()])
    return float((found & truth).sum() / (found | truth).sum())


@pytest.fixture(scope="module")
def sam(published: None) -> MobileSam:
    """The network."""
    return MobileSam()


@pytest.fixture(scope="module")
def sign(sam: MobileSam) -> Embedded:
    """The drawn sign, seen."""
    return sam.embed(draw_sign()[0])


def test_a_box_outlines_the_sign(sign: Embedded) -> None:
    """And the numbers that come with it are what they say."""
    truth = draw_sign()[1]
    x, y, width, height = cv2.boundingRect(truth.astype(np.uint8))
    found = sign.outline_boxes([[x, y, x + width, y + height]])
    assert found.logits.shape == (1, 3, 192, 256) and found.scores.shape == found.stability.shape == (1, 3)
    assert best_overlap(sign, found, truth) > 0.95
    assert found.scores.max() > 0.9 and found.stability.max() > 0.9
    assert sign.features.shape == (256, 64, 64)


def test_a_click_in_an_upright_picture_outlines_a_disc(sam: MobileSam) -> None:
    """Sides that no stride divides: what is drawn at the border of the padding comes back where it was."""
    rgb, truth = np.full((427, 321, 3), 90, np.uint8), np.zeros((427, 321), np.uint8)
    cv2.circle(rgb, (250, 350), 60, (220, 180, 40), -1)
    cv2.circle(truth, (250, 350), 60, 1, -1)
    picture = sam.embed(rgb)
    found = picture.outline_points([[250, 350]])
    assert found.logits.shape == (1, 3, 256, 193)
    assert best_overlap(picture, found, truth > 0) > 0.95


def test_prompts_do_not_depend_on_each_other(sign: Embedded) -> None:
    """In whatever batches; none give none."""
    points = [[20, 20], MIDDLE, [300, 300], [40, 300], [305, 90]]
    together, alone = sign.outline_points(points), [sign.outline_points([point]) for point in points]
    np.testing.assert_allclose(together.scores, np.concatenate([one.scores for one in alone]), atol=1e-4)
    assert ((together.logits > 0) == (np.concatenate([one.logits for one in alone]) > 0)).mean() > 0.9999
    assert sign.outline_points([]).logits.shape == (0, 3, 192, 256)


def test_short_ways_of_attention_are_exact() -> None:
    """Between tokens and places as between any two: the projections are merely done in another order."""
    torch.manual_seed(0)
    attention = TokenAttention(WIDTH // 2)
    tokens, values, places = torch.randn(2, 7, WIDTH), torch.randn(2, 7, WIDTH), torch.randn(2, 50, WIDTH)
    short = attention.to_picture(tokens, places, places + 1), attention.from_picture(places, tokens, values)
    plain = attention(tokens, places, places + 1), attention(places, tokens, values)
    for one, other in zip(short, plain, strict=True):
        torch.testing.assert_close(one, other, atol=1e-5, rtol=1e-4)


def test_other_weights_are_refused(tmp_path: Path) -> None:
    """Nothing is filled up with random numbers."""
    torch.save({"image_encoder.neck.0.weight": torch.zeros(256, 320, 1, 1)}, tmp_path / "other.pt")
    with refused("E-WEIGHTS-OTHER", "other.pt"):
        MobileSam(tmp_path / "other.pt")


def test_the_sign_is_found_by_name(published: None) -> None:
    """At its place, by its colors in their order."""
    rgb, truth = draw_sign()
    (found,) = Ssd().detect(rgb)
    x, y, width, height = cv2.boundingRect(truth.astype(np.uint8))
    assert found.name == "stop sign" == NAMES[13] and found.score > 0.9 and found.scores["stop sign"] == found.score
    assert overlap(found.box, (x, y, x + width, y + height)) > 0.9
    assert len([name for name in NAMES.values() if name]) == 80 and NAMES[90] == "toothbrush"


@pytest.mark.skipif(not FRAME.is_dir(), reason="no real frame: ACDC_TEST_DATA names the folder")
def test_a_real_room(sam: MobileSam) -> None:
    """Its sofa by name and, from that box, by outline; its armchair is either of two words."""
    rgb = cv2.imread(str(FRAME / "color.png"))[..., ::-1].copy()
    masks = cv2.imread(str(FRAME / "masks.png"), cv2.IMREAD_UNCHANGED)
    sofa, armchair = Ssd().detect(rgb)[:2]
    assert sofa.name == "couch" and sofa.score > 0.9
    assert {"couch", "chair"} <= armchair.scores.keys()
    picture = sam.embed(rgb)
    assert best_overlap(picture, picture.outline_boxes([sofa.box]), masks == 2) > 0.7
    assert best_overlap(picture, picture.outline_boxes([armchair.box]), masks == 1) > 0.7
