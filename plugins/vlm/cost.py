"""Verb `cost`: what the calls of a ledger have cost, by model."""

from pathlib import Path

from plugins.vlm.ledger import Entry, Ledger


def run(*, ledger: Path = Path("ledger")) -> None:
    """Print a line per model.

    Args:
        ledger: folder of the ledger (vlm.ledger).
    """
    by_model: dict[str, list[Entry]] = {}
    for entry in Ledger(ledger).entries():
        by_model.setdefault(entry.model, []).append(entry)
    if not by_model:
        print(f"{ledger}: no calls")
    for model, entries in sorted(by_model.items()):
        answered = sum(entry.outcome == "answered" for entry in entries)
        requests = sum(entry.requests for entry in entries)
        sent, received = (sum(entry.tokens[side] for entry in entries) for side in (0, 1))
        paid = sum(entry.cost for entry in entries)
        guessed = any(one.estimated for entry in entries for one in entry.exchanges)
        print(
            f"{model}: {len(entries)} questions, {answered} answered, {requests} requests, "
            f"{sent} + {received} tokens{' (partly estimated)' if guessed else ''}, {paid:.4f}"
        )
