"""The commands and what each of them is for, in one line; nothing else is needed to list them."""

COMMANDS = {
    "fit": "fit the model to one scan",
    "transfer": "show a drawing of one scan on another",
    "compare": "superimpose two drawings of one scan",
    "report": "measures and pictures of one or two fits",
    "export": "drawing and closed surface for other programs",
    "landmarks": "propose the landmarks on one scan",
    "ink": "find lines that were drawn on the skin of one scan",
    "batch": "fit the model to many scans",
    "evaluate": "measure the fit on a folder of patients",
    "model": "describe, check or build the model",
    "serve": "serve the page and the HTTP API",
    "worker": "carry out fits for a Dask scheduler",
    "config": "show the settings of the service",
    "purge": "delete stored scans and all that was made of them",
}
