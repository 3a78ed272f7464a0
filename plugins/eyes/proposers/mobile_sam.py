"""Proposer `mobile_sam`: outlines at clicks, where the picture shows neither ground nor what a click has outlined."""

import cv2
import numpy as np

from plugins.eyes.proposal import Mask, Proposal, RoomView

MOST = 120  # clicks; chosen for time
AT_ONCE = 12  # clicks between two looks at what is left; chosen
MIN_REACH = 2.5  # pixels of an outline, from a click to what needs none; chosen
AROUND = 3  # pixels around a click that need no further one
SCORE, STABILITY = 0.7, 0.75  # least ones of an outline that is proposed; chosen
SURE = 0.8  # least of both of an outline that covers, so that nothing inside is clicked; chosen


def propose(view: RoomView) -> list[Proposal]:
    """Three outlines a click, as far as they are good; the smallest good one covers, so that parts are clicked too."""
    rest = view.shrink(~view.surfaces.floor & ~view.border)
    found: list[Proposal] = []
    for _ in range(MOST // AT_ONCE):
        clicks = choose_clicks(rest, AT_ONCE)
        if not clicks:
            break
        scale = max(view.depth.shape) / max(rest.shape)
        outlines = view.embedded.outline_points((np.array(clicks) + 0.5) * scale - 0.5)
        for (x, y), *guesses in zip(clicks, *outlines, strict=True):
            rest[max(0, y - AROUND) : y + AROUND + 1, max(0, x - AROUND) : x + AROUND + 1] = False
            cover: Mask | None = None
            for logits, score, stability in zip(*guesses, strict=True):
                if score < SCORE or stability < STABILITY:
                    continue
                found.append(Proposal(logits, float(score * stability), "mobile_sam"))
                mask = found[-1].mask
                if min(score, stability) >= SURE and (cover is None or mask.sum() < cover.sum()):
                    cover = mask
            if cover is not None:
                rest &= ~cover
    return found


def choose_clicks(rest: Mask, count: int) -> list[tuple[int, int]]:
    """Up to `count` pixels (x, y) in the middle of what is left (h, w), the widest places first, apart."""
    left, clicks = np.pad(rest, 1).astype(np.uint8), []
    for _ in range(count):
        reach = cv2.distanceTransform(left, cv2.DIST_L2, 3)
        y, x = np.unravel_index(int(reach.argmax()), reach.shape)
        if reach[y, x] < MIN_REACH:
            break
        clicks.append((int(x) - 1, int(y) - 1))
        cv2.circle(left, (int(x), int(y)), max(2 * AROUND, round(float(reach[y, x]))), 0, -1)
    return clicks
