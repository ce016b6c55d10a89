"""Every route has a kind in the audit log, or is said not to be audited, with the reason."""

import re

from breastrig.api.access.audited import BEFORE, IDS, KINDS, MAKES, NAMED_IN_BODY, NOT_AUDITED, SENDS, kind_of
from breastrig.api.app import _bare_app

RULES = [
    (rule, method) for rule in _bare_app().url_map.iter_rules() for method in (rule.methods or set()) - {"OPTIONS"}
]


def test_the_exceptions_are_routes_and_what_is_not_audited_is_of_no_patient() -> None:
    endpoints = {rule.endpoint for rule, _ in RULES}
    assert {*KINDS, *MAKES, *NAMED_IN_BODY, *SENDS} <= endpoints
    assert set(NOT_AUDITED) <= endpoints | {endpoint.partition(".")[0] for endpoint in endpoints}
    assert all(reason.endswith(".") and len(reason.split()) > 4 for reason in NOT_AUDITED.values())
    silent = {
        rule.endpoint for rule, method in RULES if kind_of(rule.endpoint, method) is None and rule.arguments & {*IDS}
    }
    assert silent == {"scans.show_thumbnail", "shared.close_shared", "share_page.page"}


def test_what_changes_something_is_written_before_it_is_done() -> None:
    """By method: what is asked with GET changes nothing, and of the others those only that answer with something."""
    computing = {
        "of_scans.read_landmark_file", "of_scans.write_landmark_file", "fits.move_landmarks", "patterns.draw_pattern",
        "patterns.measure_lengths", "transfers.transfer_drawing", "transfers.propose_marks", "shared.open_share",
    }  # fmt: skip
    for rule, method in RULES:
        kind = kind_of(rule.endpoint, method)
        if method in ("POST", "PUT", "PATCH", "DELETE"):
            before = kind in BEFORE or rule.endpoint in SENDS
            assert before != (rule.endpoint in computing or kind is None), rule.endpoint
            assert (kind == "delete") == (rule.endpoint in ("patients.remove_patient", "scans.remove_scan"))
        else:
            assert kind not in BEFORE, rule.endpoint


def test_files_to_take_away_are_exports() -> None:
    named = {rule.endpoint: rule.rule for rule in _bare_app().url_map.iter_rules()}
    away = {name for name, rule in named.items() if re.search(r"\.(pdf|zip|csv|stl|vtu|ply)$", rule)}
    assert {name for name in away if kind_of(name, "GET") != "export"} == {"meta.show_protocol"}
