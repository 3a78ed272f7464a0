"""Proposers of outlines: `propose` of each module here, or of yours (docs/extending.md)."""

from collections.abc import Callable

from plugins.eyes.proposal import Proposal, RoomView

Proposer = Callable[[RoomView], list[Proposal]]
