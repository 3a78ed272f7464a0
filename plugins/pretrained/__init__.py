"""Networks and searches that want a download: DINOv2 and CLIP, as in the paper, and faiss (docs/matching.md)."""
