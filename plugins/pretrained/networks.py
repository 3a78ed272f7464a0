"""The pretrained networks, through `transformers`: boxes by labels, masks by boxes.

Each function loads its network and frees it, so that only one is in memory at a time. Pictures are prepared
here as the networks' own preprocessors do it, which need torchvision.
"""

import gc
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from transformers import AutoTokenizer, GroundingDinoForObjectDetection, Sam2Model

from roomkin.plugins.pretrained.weights import load_pretrained
from roomkin.stages.config.perception import OutlineSection
from roomkin.stages.contracts import InputError

Picture = NDArray[np.uint8]
IMAGENET = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
DETECTOR_SIDES = 800, 1333  # pixels: the shorter side is made so long, the longer one at most that


class Detection(NamedTuple):
    """A box (x0, y0, x1, y1) in pixels."""

    label: str
    score: float
    box: tuple[float, float, float, float]


@contextmanager
def free_memory_after(device: str) -> Iterator[None]:
    """Inference; memory of what was loaded inside is freed after it."""
    with torch.inference_mode():
        yield
    gc.collect()
    if device != "cpu":
        torch.cuda.empty_cache()


def prepare(rgb: Picture, width: int, height: int) -> torch.Tensor:
    """The picture (1, 3, height, width) as a network sees it."""
    sized = cv2.resize(rgb, (width, height), interpolation=cv2.INTER_LINEAR).astype(np.float32) / 255
    mean, deviation = (np.array(values, np.float32) for values in IMAGENET)
    return torch.from_numpy((sized - mean) / deviation).permute(2, 0, 1)[None].contiguous()


def detect(rgb: Picture, labels: Sequence[str], options: OutlineSection, device: str = "cpu") -> list[Detection]:
    """Boxes of things with these labels, best first; each has the label with the highest score.

    Raises:
        InputError: the weights are missing or broken.
    """
    with free_memory_after(device):
        height, width = rgb.shape[:2]
        model = load_pretrained(GroundingDinoForObjectDetection, options.detector, "perception.detector").to(device)
        tokenizer = _tokenizer(options.detector)
        scale = min(DETECTOR_SIDES[0] / min(width, height), DETECTOR_SIDES[1] / max(width, height))
        pixels = prepare(rgb, round(width * scale), round(height * scale)).to(device)
        seen = torch.ones(pixels.shape[0], *pixels.shape[2:], dtype=torch.long, device=device)
        found: list[Detection] = []
        for ids, spans in _texts(tokenizer, labels, model.config.max_text_len):
            tokens = torch.tensor([ids], device=device)
            given = {"pixel_values": pixels, "pixel_mask": seen, "input_ids": tokens}
            result = model(**given, attention_mask=torch.ones_like(tokens), token_type_ids=torch.zeros_like(tokens))
            scores = result.logits[0].sigmoid().cpu().numpy()
            x, y, w, h = result.pred_boxes[0].cpu().numpy().T
            boxes = np.stack([x - w / 2, y - h / 2, x + w / 2, y + h / 2], axis=1) * [width, height, width, height]
            boxes = np.clip(boxes, 0, [width, height, width, height])
            by_label = np.stack([scores[:, start:end].max(axis=1) for start, end in spans.values()], axis=1)
            for query in np.flatnonzero(by_label.max(axis=1) > options.box_threshold):
                best = int(by_label[query].argmax())
                box = tuple(float(value) for value in boxes[query])
                if box[2] - box[0] >= 2 and box[3] - box[1] >= 2:
                    found.append(Detection(list(spans)[best], float(by_label[query, best]), box))  # type: ignore[arg-type]
    return sorted(found, key=lambda detection: -detection.score)


def _tokenizer(folder: str) -> Any:
    try:
        return AutoTokenizer.from_pretrained(folder, local_files_only=True)
    except (OSError, ValueError, TypeError, KeyError):
        what, fix = f"the tokenizer in '{folder}' does not load.", "put tokenizer.json beside model.safetensors"
        raise InputError("perception.detector", what, fix, code="E-TOKENIZER-MISSING") from None


def _texts(
    tokenizer: Any, labels: Sequence[str], longest: int
) -> Iterator[tuple[list[int], dict[str, tuple[int, int]]]]:
    """Texts `label. label. ...` as token ids, each with the places of every label's tokens; as many as are needed."""
    stop = tokenizer(".", add_special_tokens=False)["input_ids"]
    first, last = tokenizer.cls_token_id, tokenizer.sep_token_id
    ids, spans = [first], dict[str, tuple[int, int]]()
    for label in dict.fromkeys(label.strip().lower().rstrip(".") for label in labels):
        words = tokenizer(label, add_special_tokens=False)["input_ids"][: longest - 3]
        if not words:
            continue
        if spans and len(ids) + len(words) + len(stop) + 1 > longest:
            yield [*ids, last], spans
            ids, spans = [first], {}
        spans[label] = (len(ids), len(ids) + len(words))
        ids += words + stop
    if spans:
        yield [*ids, last], spans


def segment(
    rgb: Picture, detections: Sequence[Detection], options: OutlineSection, device: str = "cpu"
) -> list[NDArray[np.bool_]]:
    """The mask (H, W) of what each box holds.

    Raises:
        InputError: the weights are missing or broken.
    """
    with free_memory_after(device):
        height, width = rgb.shape[:2]
        model = load_pretrained(Sam2Model, options.segmenter, "perception.segmenter").to(device)
        side = model.config.prompt_encoder_config.image_size
        boxes = np.array([item.box for item in detections]) * np.array([side / width, side / height] * 2)
        embedded = model.get_image_embeddings(prepare(rgb, side, side).to(device))
        masks = []
        for box in boxes:  # one at a time: memory does not grow with their number
            given = torch.tensor(box, dtype=torch.float32, device=device).reshape(1, 1, 4)
            logits = model(image_embeddings=embedded, input_boxes=given, multimask_output=False).pred_masks[0, 0, 0]
            sized = cv2.resize(logits.float().cpu().numpy(), (width, height), interpolation=cv2.INTER_LINEAR)
            masks.append(np.asarray(sized > 0))
        return masks
