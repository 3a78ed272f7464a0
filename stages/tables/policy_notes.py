"""What tables of policies say below: what is pooled, and what policies are given that a real robot would not have."""

from roomkin.stages.config.tables import PolicyTables
from roomkin.stages.plugins import shorten_name
from roomkin.stages.tables.markup import read_notes
from roomkin.stages.tables.methods import kinds_of


def policy_notes(options: PolicyTables) -> list[str]:
    """The notes of a run, as far as its options are known."""
    kinds, sensing = kinds_of(options), options.sensing
    pooled = [kinds.get(name, name) for name, about in options.policies.items() if (about.best or 0) > 1]
    simulator = shorten_name(sensing.simulator) if sensing else ""
    return read_notes("policies", pooled=pooled, sensing=sensing, starts=options.starts, simulator=simulator)
