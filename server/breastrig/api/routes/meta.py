"""The service's description, and the examples."""

from apiflask import APIBlueprint
from flask import Response

from breastrig.api.answers import CHECK_AGAIN, PDF, bytes_answer, file_of
from breastrig.api.app_context import app_context, config, service
from breastrig.api.language import current_language, in_language
from breastrig.api.routes.groups import caller_answer, group_for_new
from breastrig.api.routes.scans.scans import scan_answer
from breastrig.api.wire import common as wire
from breastrig.api.wire import meta as wire_meta
from breastrig.api.wire.persons import GroupQuery
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.version import __version__
from breastrig.drawings.pattern_parameters import pattern_forms
from breastrig.drawings.patterns import offered_patterns
from breastrig.files.result import ModelSummary
from breastrig.fitting.recipe import preset_names
from breastrig.scan.file_type import ENDINGS

meta = APIBlueprint("meta", __name__, tag={"name": "meta", "description": "Version, limits, examples."})


@meta.get("/api/meta")
@meta.input(wire_meta.MetaQuery, location="query")
@meta.output(wire_meta.Meta)
@meta.doc(operation_id="getMeta")
def about(query_data: wire_meta.MetaQuery) -> wire_meta.Meta:
    """Version, limits of use, limits of size, the model"""
    context = app_context()
    models = service.models
    rig = context.model_of(models.facts_of(query_data.model)).rig
    uploads = config.uploads
    return wire_meta.Meta(
        name="BreastRig",
        version=__version__,
        notice=LIMITS_OF_USE,
        limits=wire_meta.Limits(
            upload_bytes=uploads.file_bytes,
            zip_bytes=uploads.zip_bytes,
            triangles=uploads.triangles,
            keep_days=config.keep_days,
        ),
        scan_files=wire_meta.ScanFiles(endings=list(ENDINGS)),
        units=list(wire.UNITS),
        model=ModelSummary(
            name=rig.name,
            sha256=rig.sha256,
            vertices=len(rig.template),
            bones=len(rig.bones),
            blendshapes=len(rig.shapes),
        ),
        models=list(models.names),
        landmarks=[wire_meta.LandmarkInfo.of(landmark) for landmark in rig.landmarks],
        presets=list(preset_names()),
        drawings=[
            *(wire_meta.DrawingInfo.of(drawing) for drawing in rig.drawings),
            *(wire_meta.DrawingInfo(name=name, label=label) for name, label in offered_patterns(rig)),
        ],
        patterns=pattern_forms(rig),
        person=caller_answer(),
        archives=list(config.archives),
    )


@meta.get("/api/scan_protocol.pdf")
@meta.doc(operation_id="getScanProtocol", responses={200: file_of(PDF, "One A4 page")})
def show_protocol() -> Response:
    """A page to print for taking scans with marks"""
    return in_language(bytes_answer(service.reports.protocol(current_language()), PDF, CHECK_AGAIN))


@meta.get("/api/examples")
@meta.output(wire_meta.Examples)
@meta.doc(operation_id="listExamples")
def list_examples() -> wire_meta.Examples:
    """The example patient's scans"""
    return wire_meta.Examples(examples=[wire_meta.ExampleEntry.of(one) for one in service.uploads.examples()])


@meta.post("/api/examples/<name>")
@meta.input(GroupQuery, location="query")
@meta.output(wire_meta.ExampleScan, status_code=201, description="The example was read and stored as a scan")
@meta.doc(operation_id="openExample")
def open_example(name: str, query_data: GroupQuery) -> tuple[wire_meta.ExampleScan, int, dict[str, str]]:
    """Open an example as if it had been uploaded"""
    row, points_mm = service.uploads.add_example(name, group_for_new(query_data.group))
    scan = scan_answer(row)
    landmarks = wire.LandmarkFile(landmarks=points_mm)
    answer = wire_meta.ExampleScan(**scan.model_dump(), example_landmarks=landmarks)
    return answer, 201, {"Location": scan.links.self}
