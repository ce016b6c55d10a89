"""The table of measures as a DICOM measurement report, TID 1500.

Codes are SNOMED CT's and DICOM's where they have one (volume, distance, breasts, units); the measures by name are of
our own scheme, which the object declares.  Only numbers that the printed report shows as well are in it.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence

from highdicom.coding_schemes import CodingSchemeIdentificationItem
from highdicom.sr import (
    AlgorithmIdentification,
    CodedConcept,
    DeviceObserverIdentifyingAttributes,
    FindingSite,
    Measurement,
    MeasurementProperties,
    MeasurementReport,
    MeasurementsAndQualitativeEvaluations,
    ObservationContext,
    ObserverContext,
    QualitativeEvaluation,
    TrackingIdentifier,
)
from pydicom.sr.codedict import codes
from pydicom.sr.coding import Code

from breastrig.core.version import __version__
from breastrig.report.table import GRADES, Cell

OWN = "99BREASTRIG"  # the scheme's designator: 99 is for private ones
SCHEME = CodingSchemeIdentificationItem(
    designator=OWN, name="BreastRig measures", version=__version__, responsible_organization="BreastRig"
)
UNITS = {"mm": codes.UCUM.Millimeter, "ml": codes.UCUM.CubicCentimeter, "1": codes.UCUM.NoUnits}
SITES = {"left": codes.SCT.LeftBreast, "right": codes.SCT.RightBreast, "both": codes.SCT.BothBreasts}
BAND = "90 % interval"
Row = Mapping[str, Cell]


def measurement_report(rows: Sequence[Row], quality: str, seed: str, uid: Callable[..., str]) -> MeasurementReport:
    """The content of an object whose UID is `seed`, from rows of `flat_rows`; `uid` makes UIDs of words."""
    device = DeviceObserverIdentifyingAttributes(
        uid("device", __version__), "BreastRig", manufacturer_name="BreastRig", serial_number=__version__
    )
    groups = [
        MeasurementsAndQualitativeEvaluations(
            TrackingIdentifier(uid("group", seed, place), f"{place} breast{'s' * (place == 'both')}"),
            finding_type=codes.SCT.Breast,
            finding_sites=[FindingSite(site)],
            algorithm_id=AlgorithmIdentification("BreastRig", __version__),
            measurements=[_measurement(row, cell) for row, cell in _cells(rows, place) if row["unit"] != "grade"],
            qualitative_evaluations=[
                *(_grade(row, cell) for row, cell in _cells(rows, place) if row["unit"] == "grade"),
                *([_own("quality", "Quality of the fit", quality)] if quality and place == "both" else []),
            ],
        )
        for place, site in SITES.items()
    ]
    return MeasurementReport(
        ObservationContext(observer_device_context=ObserverContext(codes.DCM.Device, device)),
        codes.SCT.ImagingProcedure,
        groups,
        codes.DCM.ImagingMeasurementReport,
    )


def _cells(rows: Sequence[Row], place: str) -> Iterator[tuple[Row, str]]:
    """Each (row, cell) with a number that is known well enough to be printed."""
    for row in rows:
        for cell in ("value", "difference") if place == "both" else (place,):
            left_out = f"{row['vague']}; {row['not_known']}".split("; ")
            if row[cell] is not None and cell not in left_out:
                yield row, cell


def _measurement(row: Row, cell: str) -> Measurement:
    value, low, high = (row[f"{cell}{end}"] for end in ("", "_low", "_high"))
    name = f"{row['label']}{', left less right' * (cell == 'difference')}"
    is_volume = row["unit"] == "ml" and cell != "difference"
    kind, unit = str(row["kind"]), UNITS[str(row["unit"])]
    return Measurement(
        codes.SCT.Volume if is_volume else _concept(f"{row['measure']}{'_difference' * (cell == 'difference')}", name),
        float(str(value)),
        unit,
        method=_concept(f"{kind.replace(' ', '_')}_90", f"{kind}; uncertainty: {BAND}"),
        properties=None
        if low is None or high is None
        else _band(float(str(value)), float(str(low)), float(str(high)), unit),
    )


def _band(value: float, low: float, high: float, unit: Code) -> MeasurementProperties:
    made = MeasurementProperties(
        upper_measurement_uncertainty=round(high - value, 4), lower_measurement_uncertainty=round(value - low, 4)
    )
    for each in made:  # highdicom says "no units" of both
        each.MeasuredValueSequence[0].MeasurementUnitsCodeSequence = [CodedConcept.from_code(unit)]
    return made


def _grade(row: Row, cell: str) -> QualitativeEvaluation:
    return _own(str(row["measure"]), str(row["label"]), GRADES[round(float(str(row[cell])))])


def _own(name: str, label: str, value: str) -> QualitativeEvaluation:
    return QualitativeEvaluation(_concept(name, label), _concept(f"{name}_{value}", value))


def _concept(value: str, meaning: str) -> CodedConcept:
    return CodedConcept(value, OWN, meaning)
