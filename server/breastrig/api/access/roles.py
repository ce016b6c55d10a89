"""The least role for each call: GET is to look, all else to plan, but for those that are named here."""

from breastrig.api.access.person import Role

OPEN = frozenset({"shared", "share_page", "sign_in", "page", "operations"})  # blueprints that ask nobody who it is
LEAST = {  # by endpoint
    # they change nothing, though they are no GET
    "of_scans.read_landmark_file": Role.LOOK,
    "of_scans.write_landmark_file": Role.LOOK,
    "patterns.draw_pattern": Role.LOOK,
    "patterns.measure_lengths": Role.LOOK,
    "fits.move_landmarks": Role.LOOK,
    "transfers.transfer_drawing": Role.LOOK,
    "transfers.propose_marks": Role.LOOK,
    "persons.stay": Role.LOOK,
    # they are about people, not about patients
    "persons.give_to_group": Role.ADMINISTER,
    "audit.list_lines": Role.ADMINISTER,
    "audit.show_page": Role.ADMINISTER,
    "audit.check_lines": Role.ADMINISTER,
    "audit.show_log": Role.ADMINISTER,
}
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})
WORDS = {Role.PLAN: "may look only", Role.ADMINISTER: "are no administrator"}


def least_role(endpoint: str, method: str) -> Role | None:
    """The role that a call needs; None for one that anybody may make."""
    if endpoint.partition(".")[0] in OPEN:
        return None
    return LEAST.get(endpoint, Role.LOOK if method in SAFE_METHODS else Role.PLAN)
