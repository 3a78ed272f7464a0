"""What a test expects to be refused, by its code."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from stages.contracts import InputError


@contextmanager
def refused(code: str) -> Iterator[pytest.ExceptionInfo[InputError]]:
    """The block raises an `InputError` of this code."""
    with pytest.raises(InputError) as caught:
        yield caught
    assert caught.value.code == code, str(caught.value)
