"""How a patient may be scanned."""

AUTO = "auto"  # it is to be found
STANCES = (AUTO, "standing", "supine")
