"""How a patient may be scanned."""

AUTO = "auto"  # it is to be found
STANDING = "standing"
STANCES = (AUTO, STANDING, "supine")
