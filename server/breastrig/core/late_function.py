"""A function that is named here and imported where it is called.

Who only hands a function on to another process is spared what its module imports: the numerics take longer to import
than all else that a server needs.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any


@dataclass(frozen=True)
class LateFunction:
    """The function `name` of the module `module`; travels between processes as these two words."""

    module: str
    name: str

    @property
    def function(self) -> Callable[..., Any]:
        """Imported now."""
        found: Callable[..., Any] = getattr(import_module(self.module), self.name)
        return found

    def __call__(self, *given: Any) -> Any:
        return self.function(*given)
