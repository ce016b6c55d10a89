"""BreastRig: one rigged torso model fitted to 3D scans.  Research use only, not a medical device.

    import breastrig

    scan = breastrig.read_scan("scan.ply")
    fit = breastrig.fit(scan, "landmarks.json")
    fit.vertices, fit.distances, fit.drawing.lines       # in the scan's unit and frame
    fit.save("out")                                      # what `breastrig fit -o out` writes

The names below come from `breastrig.use` and `breastrig.core.errors`, and are loaded when they are first used:
neither `import breastrig` nor `breastrig --version` waits for NumPy.
"""

from breastrig.core.version import __version__

TYPE_CHECKING = False  # type checkers take it as true; importing `typing` would double the time of the import

if TYPE_CHECKING:
    from breastrig.core.errors import (
        BadDrawing,
        BadInput,
        BadLandmarks,
        BadModel,
        BadScan,
        BadSettings,
        BreastRigError,
        FitFailed,
        NotSent,
        TooLarge,
    )
    from breastrig.rig.named_parameters import BonePose, Parameters
    from breastrig.use.archive.dicom import send_dicom, write_dicom
    from breastrig.use.cases.case import Case, CaseFit, CaseScan
    from breastrig.use.draw import draw, project
    from breastrig.use.example import Example, example
    from breastrig.use.fit import FitRun, Iterate, fit, iterates
    from breastrig.use.guides.write_template import write_template
    from breastrig.use.ink import Ink, InkLine, find_ink
    from breastrig.use.landmarks import Proposal, Proposals, propose_landmarks
    from breastrig.use.lines.line_checks import LandmarkCheck, LineChecks
    from breastrig.use.marks.propose_marks import ProposedMark, ProposedMarks, propose_marks
    from breastrig.use.measure import Measure, Number, measure
    from breastrig.use.predict import predict
    from breastrig.use.report import write_report
    from breastrig.use.scan import Scan, read_scan
    from breastrig.use.transfer import transfer
    from breastrig.use.values.drawing import Drawing, Lesion, Line
    from breastrig.use.values.fit_result import Fit
    from breastrig.use.values.frame import Frame
    from breastrig.use.values.model import Rig, load_model
    from breastrig.use.values.posterior import Posterior
    from breastrig.use.volume import Volume, volume_mesh

__all__ = [
    "BadDrawing",
    "BadInput",
    "BadLandmarks",
    "BadModel",
    "BadScan",
    "BadSettings",
    "BonePose",
    "BreastRigError",
    "Case",
    "CaseFit",
    "CaseScan",
    "Drawing",
    "Example",
    "Fit",
    "FitFailed",
    "FitRun",
    "Frame",
    "Ink",
    "InkLine",
    "Iterate",
    "LandmarkCheck",
    "Lesion",
    "Line",
    "LineChecks",
    "Measure",
    "NotSent",
    "Number",
    "Parameters",
    "Posterior",
    "Proposal",
    "Proposals",
    "ProposedMark",
    "ProposedMarks",
    "Rig",
    "Scan",
    "TooLarge",
    "Volume",
    "__version__",
    "draw",
    "example",
    "find_ink",
    "fit",
    "iterates",
    "load_model",
    "measure",
    "predict",
    "project",
    "propose_landmarks",
    "propose_marks",
    "read_scan",
    "send_dicom",
    "transfer",
    "volume_mesh",
    "write_dicom",
    "write_report",
    "write_template",
]

_MODULES = {
    "core.errors": (
        "BadDrawing BadInput BadLandmarks BadModel BadScan BadSettings BreastRigError FitFailed NotSent TooLarge"
    ),
    "use.archive.dicom": "send_dicom write_dicom",
    "use.cases.case": "Case CaseFit CaseScan",
    "use.draw": "draw project",
    "use.values.drawing": "Drawing Lesion Line",
    "use.example": "Example example",
    "use.values.fit_result": "Fit",
    "use.values.frame": "Frame",
    "use.ink": "Ink InkLine find_ink",
    "use.landmarks": "Proposal Proposals propose_landmarks",
    "use.lines.line_checks": "LandmarkCheck LineChecks",
    "use.marks.propose_marks": "ProposedMark ProposedMarks propose_marks",
    "use.measure": "Measure Number measure",
    "use.values.model": "Rig load_model",
    "rig.named_parameters": "BonePose Parameters",
    "use.values.posterior": "Posterior",
    "use.predict": "predict",
    "use.report": "write_report",
    "use.fit": "FitRun Iterate fit iterates",
    "use.scan": "Scan read_scan",
    "use.guides.write_template": "write_template",
    "use.transfer": "transfer",
    "use.volume": "Volume volume_mesh",
}
_PLACES = {name: module for module, names in _MODULES.items() for name in names.split()}


if not TYPE_CHECKING:  # they know the names from above, and then report any other

    def __getattr__(name: str) -> object:
        """Loads the module that has the name, when it is first asked for."""
        if name not in _PLACES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from importlib import import_module

        found: object = getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)
        globals()[name] = found
        return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
