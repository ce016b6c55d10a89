"""People: whose session goes on, and which group owns a patient."""

from apiflask import APIBlueprint
from flask import Response

from breastrig.api.access.session import keep_session
from breastrig.api.app_context import config, storage
from breastrig.api.errors import refuse
from breastrig.api.routes.patients import TAG, patient_answer
from breastrig.api.wire import patients as wire_patients
from breastrig.api.wire import persons as wire
from breastrig.core.errors import BadSettings, unknown_name
from breastrig.storage.documents.patients import give_patient

persons = APIBlueprint("persons", __name__, url_prefix="/api", tag=TAG)

NO_USERS = "This service has no users; start it with --users to give patients to groups."


@persons.put("/session")
@persons.output({}, status_code=204)
@persons.doc(operation_id="keepSession")
def stay() -> Response:
    """Say that somebody is at the page

    The session of a person ends when this was not said for a while; no other call keeps it.
    """
    response = Response(status=204)
    people = config.people
    if people is not None and people.proxy_header is None:
        keep_session(response, config, storage)
    return response


@persons.put("/patients/<patient_id>/group")
@persons.input(wire.GivenGroup)
@persons.output(wire_patients.Patient)
@persons.doc(operation_id="putPatientGroup", responses={409: "The service has no users"})
def give_to_group(patient_id: str, json_data: wire.GivenGroup) -> wire_patients.Patient:
    """Give a patient to a group of people

    Its members alone see the patient from then on, and administrators, who alone may say so.
    """
    people = config.people
    if people is None:
        raise refuse(409, NO_USERS)
    if json_data.group is not None and json_data.group not in people.groups:
        raise BadSettings(unknown_name("group", json_data.group, tuple(people.groups)))
    give_patient(storage, patient_id, json_data.group)
    return patient_answer(patient_id)
