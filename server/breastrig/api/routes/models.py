"""The model's files.  They are the same for everyone and hold nobody's data."""

from apiflask import APIBlueprint
from flask import Response

from breastrig.api.answers import BINARY, CHECK_AGAIN, FOR_EVER, GLB, JSON, file_of, public_answer
from breastrig.api.app_context import app_context
from breastrig.api.served_model import ServedModel
from breastrig.api.wire import common as wire
from breastrig.core.errors import NotFound, unknown_name

models = APIBlueprint(
    "models", __name__, url_prefix="/api/models", tag={"name": "model", "description": "The rigged model itself."}
)


@models.get("/torso.glb")
@models.doc(operation_id="getModel", responses={200: file_of(GLB, "The skinned model")})
def show_model() -> Response:
    """The rigged model: skin, bones, 55 named blendshapes"""
    return public_answer(app_context().model.glb, GLB, CHECK_AGAIN)


@models.get("/torso.json")
@models.output(wire.ModelSide)
@models.doc(operation_id="getModelSide")
def show_side() -> Response:
    """The model's side file: limits, landmarks, drawings"""
    return public_answer(app_context().model.side_json, JSON, CHECK_AGAIN)


@models.get("/<sha256>/torso.glb")
@models.doc(operation_id="getModelVersion", responses={200: file_of(GLB, "Never changes")})
def show_version(sha256: str) -> Response:
    """The model that a fit was made with: its `started` event and its result.json name the hash"""
    return public_answer(_model_with(sha256).glb, GLB, FOR_EVER)


@models.get("/<sha256>/torso.json")
@models.output(wire.ModelSide, description="Never changes")
@models.doc(operation_id="getModelVersionSide")
def show_version_side(sha256: str) -> Response:
    """The side file of that model"""
    return public_answer(_model_with(sha256).side_json, JSON, FOR_EVER)


@models.get("/<sha256>/torso.bin")
@models.doc(operation_id="getModelBuffer", responses={200: file_of(BINARY, "Never changes")})
def show_buffer(sha256: str) -> Response:
    """The buffer that every iteration's glTF points at"""
    return public_answer(_model_with(sha256).buffer, BINARY, FOR_EVER)


@models.get("/<sha256>/drawings/<name>.bin")
@models.doc(operation_id="getDrawingBuffer", responses={200: file_of(BINARY, "Never changes")})
def show_drawing_buffer(sha256: str, name: str) -> Response:
    """The buffer of one drawing's lines"""
    model = _model_with(sha256)
    if name not in model.drawing_buffers:
        raise NotFound(unknown_name("drawing", name, model.rig.drawing_names))
    return public_answer(model.drawing_buffers[name], BINARY, FOR_EVER)


def _model_with(sha256: str) -> ServedModel:
    model = app_context().model_with(sha256)
    if model.rig.sha256 != sha256:
        raise NotFound("This version of the model is not here; /api/meta names the one that is.")
    return model
