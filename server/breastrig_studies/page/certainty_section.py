"""The certainty of the fits on the page: how much the 90 % radii hold, and what is said of right picks."""

from collections.abc import Sequence

from breastrig_studies.page.section import Section, capital
from breastrig_studies.studies.result_cache import Record
from breastrig_studies.tables.accuracy import FAMILIES, of
from breastrig_studies.tables.certainty import KINDS, covered


def certainty_section(records: Sequence[Record]) -> Section:
    answers = []
    for family in FAMILIES:
        found = [record for record in of(records, "certainty") if record.case.family == family and not record.failed]
        if not found:
            continue
        parts = []
        for kind, words in KINDS.items():
            shares = [covered(found, kind, part) for part in ("landmarks", "skin")]
            if all(total for _, total in shares):
                marks, skin = (100 * good / total for good, total in shares)
                parts.append(f"{words}: {marks:.0f} % of landmarks, {skin:.0f} % of the skin")
        trials = [trial for record in found for trial in record.answer.values()]
        picks, dropped, asked = (sum(trial[key] for trial in trials) for key in ("picks", "dropped", "unusual"))
        answers.append(
            f"{capital(family)}, within the radius: {'; '.join(parts)}. Of {picks} right picks {dropped} were rejected "
            f"and {asked} asked about."
        )
    return Section(
        "certainty",
        "Does the program know how far off it is, and does it believe right picks?",
        "Each landmark and each vertex has a radius that should hold its true place nine times of ten. True places of "
        "vertices are those of a fit to the whole true surface. The figure: what radii of 50, 80, 90 and 95 % hold; on "
        "the line “as said” they hold what they say, above it they are too wide, below it too narrow.",
        tuple(answers),
        ("reliability",),
        ("reliability", "certainty", "believed"),
    )
