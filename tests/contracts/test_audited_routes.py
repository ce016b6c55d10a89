"""Every route is in the table of the audit log, or is said not to be audited, with the reason."""

import re

from breastrig.api.access.audited import AUDITED, BEFORE, MAKES, NAMED_IN_BODY, NOT_AUDITED, SENDS
from breastrig.api.app import _bare_app


def test_every_route_is_audited_or_said_not_to_be() -> None:
    endpoints = {rule.endpoint for rule in _bare_app().url_map.iter_rules()}
    assert not set(AUDITED) & set(NOT_AUDITED)
    assert set(AUDITED) | set(NOT_AUDITED) == endpoints
    assert {*MAKES, *NAMED_IN_BODY} <= set(AUDITED)
    assert all(reason.endswith(".") and len(reason.split()) > 4 for reason in NOT_AUDITED.values())


def test_what_changes_something_is_written_before_it_is_done() -> None:
    """By method: what is asked with GET changes nothing, and of the others those only that answer with something."""
    computing = {
        "of_scans.read_landmark_file", "of_scans.write_landmark_file", "fits.move_landmarks", "patterns.draw_pattern",
        "patterns.measure_lengths", "transfers.transfer_drawing", "transfers.propose_marks", "shared.open_share",
    }  # fmt: skip
    for rule in _bare_app().url_map.iter_rules():
        if (rule.methods or set()) & {"POST", "PUT", "PATCH", "DELETE"}:
            before = AUDITED.get(rule.endpoint) in BEFORE or rule.endpoint in SENDS
            assert before != (rule.endpoint in computing or rule.endpoint in NOT_AUDITED), rule.endpoint
        else:
            assert AUDITED.get(rule.endpoint) not in BEFORE, rule.endpoint


def test_files_to_take_away_are_exports() -> None:
    named = {rule.endpoint: rule.rule for rule in _bare_app().url_map.iter_rules()}
    away = {name for name, rule in named.items() if re.search(r"\.(pdf|zip|csv|stl|vtu|ply)$", rule)}
    assert {name for name in away if AUDITED.get(name) != "export"} == {"meta.show_protocol"}
