"""The verdict on the page: whether right fits are called good, and wrong ones never."""

from breastrig_studies.page.section import Section
from breastrig_studies.tables.table import Table


def verdicts_section(table: Table) -> Section:
    """Of whole scans that are fitted rightly, and of all that are not."""
    place = {column.name: index for index, column in enumerate(table.columns)}

    def counted(truth: str, extent: str | None, kinds: tuple[str, ...]) -> tuple[float, int]:
        """Of these fits: how many are called good, and how many there are."""
        good, total = 0.0, 0
        for row in table.rows:
            kind, scan, true, n, share, *_ = row.cells
            if true == truth and extent in (None, scan) and kind in kinds:
                assert isinstance(n, int)
                assert isinstance(share, float)
                good, total = good + n * share / 100.0, total + n
        return good, total

    kinds = tuple(dict.fromkeys(str(row.cells[place["fit"]]) for row in table.rows))
    right, rights = counted("right", "whole", ("landmarks given", "none given"))
    wrong, wrongs = counted("wrong", None, kinds)
    answers = []
    if rights:
        answers.append(f"Of {rights} right fits of whole scans {right:.0f} are called good.")
    if wrongs:
        answers.append(f"Of {wrongs} wrong fits {wrongs - wrong:.0f} are to be checked or unusable.")
    return Section(
        "verdicts",
        "Does the verdict tell right fits from wrong ones?",
        "Each scan is fitted with all landmarks, with none, with the proposals accepted as they are, and from a start "
        "that is turned head down.",
        tuple(answers),
        (),
        ("verdicts",),
    )
