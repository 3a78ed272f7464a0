"""Verb `diff`: where two models answered the same questions otherwise."""

from pathlib import Path

from plugins.vlm.ledger import Entry, Ledger
from stages.contracts.errors import InputError


def run(*, models: tuple[str, str], ledger: Path = Path("ledger"), other: Path | None = None) -> None:
    """Print the questions on which two models differ, and how often they agree.

    Args:
        models: the two, as they are named in the ledger.
        ledger: folder of the ledger (vlm.ledger).
        other: folder of the second model's, if it is another.
    """
    first, second = _by_question(ledger, models[0]), _by_question(other or ledger, models[1])
    shared = [question for question in first if question in second]
    if not shared:
        what = f"{models[0]} and {models[1]} were asked nothing in common."
        raise InputError(ledger, what, "see `cost` for models", code="E-VLM-MODELS")
    pairs = [(first[question], second[question]) for question in shared]
    differ = [(one, two) for one, two in pairs if answer_text(one) != answer_text(two)]
    for one, two in sorted(differ, key=lambda pair: pair[0].about):
        print(f"{one.about}: {answer_text(one)} | {answer_text(two)}")
    print(f"{len(shared) - len(differ)} of {len(shared)} answers agree; {models[0]} | {models[1]}")


def _by_question(folder: Path, model: str) -> dict[str, Entry]:
    """A model's entries by what was asked; the last by key, should its options differ."""
    return {entry.question: entry for entry in Ledger(folder).entries() if entry.model == model}


def answer_text(entry: Entry) -> str:
    """An answer in a few words: reasons left out, choices by what they stand for."""
    if entry.answer is None:
        return f"({entry.problem or 'no answer'})"
    values = {name: entry.names.get(str(value), value) for name, value in entry.answer.items() if name != "reason"}
    return ", ".join(str(value) for value in values.values())
