"""Everything that BreastRig raises on purpose.

    BreastRigError
    ├── BadInput                 the caller can mend it: wrong file, unit, name, value
    │   ├── NeedsYes             what is most likely a mistake, unless a person says that it is not
    │   ├── BadScan              a scan that cannot be read or fitted
    │   │   └── NeedsAnswer      a fact that the file does not hold, and a person knows
    │   ├── BadLandmarks         a landmark file or pick that cannot be used
    │   ├── BadDrawing           a drawing that cannot be used
    │   ├── BadModel             a rig that breaks the contract of the model
    │   ├── BadSettings          a preset or setting that cannot be used
    │   ├── NotFound             no such scan, fit, ...
    │   ├── Conflict             the thing is not in a state that allows this
    │   ├── TooLarge             over a stated limit
    │   └── TooMany              too much at once; it works later
    ├── FitFailed                the input was fine, the registration was not
    ├── NotSent                  an archive did not store all that was sent to it
    └── NotRemoved               a scan was deleted, and files of it are left

Each message is one sentence for a person: what is wrong, then what to do.  Only `api` and `cli` turn
an error into a status or exit code.
"""

from collections.abc import Sequence
from typing import Any

SHOWN = 100  # characters of a wrong word that are repeated
LISTED = 12  # wrong words
CHOICES = 4  # answers in a sentence


class BreastRigError(Exception):
    """Base of all; `str(error)` is the sentence to show."""


class BadInput(BreastRigError):
    """A fault of the input, which the caller can correct."""


class BadScan(BadInput):
    """A scan that cannot be read or fitted."""


class NeedsAnswer(BadScan):
    """A fact that the file does not hold, or holds twice; `question` has the possible answers.

    question   {"field": name of the option that answers, "choices": [{"value", "text", ...}]}, ready for JSON
    """

    def __init__(self, problem: str, question: dict[str, Any]) -> None:
        super().__init__(f"{problem}; {_say_which(question, str(question['field']))}")
        self.problem = problem
        self.question = question

    def on_command_line(self) -> str:
        """The sentence with the option's name as it is typed; many answers, each on a line."""
        option = "--" + str(self.question["field"]).replace("_", "-")
        if len(self.question["choices"]) <= CHOICES:
            return f"{self.problem}; {_say_which(self.question, option)}"
        return "\n  ".join([f"{self.problem}; say which it is:", *_each(self.question, option)])

    def __reduce__(self) -> tuple[type["NeedsAnswer"], tuple[str, dict[str, Any]]]:
        return NeedsAnswer, (self.problem, self.question)


def _say_which(question: dict[str, Any], option: str) -> str:
    choices = _each(question, option)
    more = [f"one of {len(choices) - CHOICES} more, which breastrig fit lists"] if len(choices) > CHOICES else []
    return f"say which it is: {' or '.join([*choices[:CHOICES], *more])}."


def _each(question: dict[str, Any], option: str) -> list[str]:
    return [f"{option} {each['value']} ({each['text']})" for each in question["choices"]]


class NeedsYes(BadInput):
    """Most likely a mistake; `field` is the option with which a person confirms that it is intended."""

    def __init__(self, problem: str, field: str) -> None:
        super().__init__(f"{problem}; if it is right all the same, say {field}.")
        self.problem, self.field = problem, field

    def on_command_line(self) -> str:
        """The sentence with the option's name as it is typed."""
        return f"{self.problem}; if it is right all the same, add --{self.field.replace('_', '-')}."

    def __reduce__(self) -> tuple[type["NeedsYes"], tuple[str, str]]:
        return NeedsYes, (self.problem, self.field)


class BadLandmarks(BadInput):
    """Landmarks that cannot be used."""


class BadDrawing(BadInput):
    """A drawing that cannot be used."""


class BadModel(BadInput):
    """A rig that breaks the contract of the model."""


class BadSettings(BadInput):
    """A preset or setting that cannot be used."""


class NotFound(BadInput):
    """The object does not exist."""


class Conflict(BadInput):
    """The object's state does not allow this action."""


class TooLarge(BadInput):
    """Input over a stated limit."""


class TooMany(BadInput):
    """Too many at once; `retry_after_s` is the time to wait."""

    def __init__(self, sentence: str, retry_after_s: int) -> None:
        super().__init__(sentence)
        self.retry_after_s = retry_after_s

    def __reduce__(self) -> tuple[type["TooMany"], tuple[str, int]]:
        """Pickles `retry_after_s` too: errors travel between processes."""
        return TooMany, (str(self), self.retry_after_s)


class FitFailed(BreastRigError):
    """The registration ended without a usable result; the message names the reason."""


class NotSent(BreastRigError):
    """An archive did not store all objects; the message says which, and why."""


class NotRemoved(BreastRigError):
    """A scan was deleted, but files of this many folders, its own and those of its fits, could not be removed."""

    def __init__(self, places: int) -> None:
        super().__init__(
            f"The scan is deleted and can be seen no more, but {places} of the folders with its files could not be "
            "removed; the service goes on trying, and its log says what is in the way."
        )
        self.places = places

    def __reduce__(self) -> tuple[type["NotRemoved"], tuple[int]]:
        return NotRemoved, (self.places,)


def unknown_names(what: str, names: Sequence[str], known: tuple[str, ...]) -> str:
    """One sentence that lists all wrong words, and the right ones."""
    if len(names) == 1:
        return unknown_name(what, names[0], known)
    listed = [f'"{name if len(name) <= SHOWN else name[: SHOWN - 3] + "..."}"' for name in names[:LISTED]]
    more = [f"{len(names) - LISTED} more"] if len(names) > LISTED else []
    return f"Not a {what}: {', '.join((*listed, *more))}; known are: {', '.join(known)}."


def unknown_name(what: str, name: str, known: tuple[str, ...]) -> str:
    """One sentence that names the wrong word and the right ones."""
    name = name if len(name) <= SHOWN else name[: SHOWN - 3] + "..."
    return f'"{name}" is not a {what}; known are: {", ".join(known)}.'
