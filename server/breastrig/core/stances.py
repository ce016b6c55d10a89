"""How a patient may be scanned."""

from typing import Literal, get_args

Stance = Literal["standing", "supine", "prone"]  # prone: of a breast MRI, on the front, breasts hanging, arms overhead

AUTO = "auto"  # it is to be found
STANDING = "standing"
STANCES = (AUTO, *get_args(Stance))
