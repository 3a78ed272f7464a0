"""The provenance of a file: digests of code, options and inputs."""

from pydantic import Field

from roomkin.stages.contracts.files import Contract
from roomkin.stages.contracts.types import Seed, Text


class Provenance(Contract):
    """The same of all four give the same bytes. Digests are the first 12 hex digits of SHA-256.

    Files that were made together with an input go by it: masks beside objects.json, features of patches beside those
    of whole views.
    """

    seed: Seed | None = Field(None, description="of the random numbers behind it, its own or its inputs'; null: none")
    options: Text = Field(description="digest of the command's options")
    inputs: Text = Field(description="digest of the files that the command was given")
    code: Text = Field(description="digest of the command's code and of all that it imports")
