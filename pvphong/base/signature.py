"""What `inspect`, and with it help in notebooks, says of a class whose `__new__` looks at what was given."""

from __future__ import annotations

import inspect


class InitSignature:
    """A class attribute `__signature__`: that of `__init__` without self, where `inspect` would take `__new__`'s."""

    def __get__(self, _instance: object, kind: type) -> inspect.Signature:
        whole = inspect.signature(getattr(kind, "__init__"))  # noqa: B009 a class's own, as mypy would not have it
        return whole.replace(parameters=list(whole.parameters.values())[1:])
