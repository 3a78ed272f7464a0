"""What a test expects to be refused, by its code."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from roomkin.stages.contracts import InputError


@contextmanager
def refused(code: str, *words: str) -> Iterator[pytest.ExceptionInfo[InputError]]:
    """The block raises an `InputError` of this code, which says these words."""
    with pytest.raises(InputError) as caught:
        yield caught
    said = str(caught.value)
    assert caught.value.code == code, said
    assert all(word in said for word in words), said
