"""Text encoder `clip`: CLIP's text tower through `transformers` (the official code uses ViT-B/32)."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from transformers import CLIPTextModelWithProjection, CLIPTokenizer

from roomkin.plugins.pretrained.weights import load_pretrained
from roomkin.stages.config.matching import CandidateOptions
from roomkin.stages.contracts import InputError


class TextEncoder:
    """Distances between texts; each text is encoded once."""

    def __init__(self, settings: CandidateOptions) -> None:
        folder = settings.clip
        self.model = load_pretrained(CLIPTextModelWithProjection, folder, "matching.clip")
        fix = "put vocab.json and merges.txt beside model.safetensors"
        if not any(Path(folder, name).is_file() for name in ("vocab.json", "tokenizer.json")):
            raise InputError("matching.clip", f"'{folder}' has no tokenizer.", fix, code="E-TOKENIZER-MISSING")
        try:
            self.tokenizer = CLIPTokenizer.from_pretrained(folder, local_files_only=True)
        except (OSError, ValueError, TypeError):
            what = f"the tokenizer in '{folder}' does not load."
            raise InputError("matching.clip", what, fix, code="E-TOKENIZER-BROKEN") from None
        self.known: dict[str, NDArray[np.float64]] = {}

    def distance(self, label: str, categories: Sequence[str]) -> NDArray[np.float64]:
        """L2 distance (C,) in [0, 2] between the unit embeddings of the label and each category."""
        vectors = self._embed([text.replace("_", " ") for text in [label, *categories]])
        return np.linalg.norm(vectors[1:] - vectors[0], axis=1)

    def _embed(self, texts: list[str]) -> NDArray[np.float64]:
        new = sorted(set(texts) - set(self.known))
        if new:
            limit = self.model.config.max_position_embeddings
            tokens = self.tokenizer(new, padding=True, truncation=True, max_length=limit, return_tensors="pt")
            with torch.inference_mode():
                vectors = self.model(**tokens).text_embeds.double().numpy()
            self.known |= dict(zip(new, vectors / np.linalg.norm(vectors, axis=1, keepdims=True), strict=True))
        return np.stack([self.known[text] for text in texts])
