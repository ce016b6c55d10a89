"""What every error of the API looks like."""

from werkzeug.test import TestResponse


def problem(answer: TestResponse, status: int) -> str:
    """The sentence of a problem-details answer, checked for form."""
    assert answer.status_code == status, answer.get_data(as_text=True)
    assert answer.mimetype == "application/problem+json"
    body = answer.get_json(force=True)
    assert body["status"] == status
    assert body["title"]
    assert body["type"] == "about:blank"
    sentence = body["detail"]
    assert sentence.endswith(".")
    assert "\n" not in sentence
    for trace in ("Traceback", "Error(", ".py", "/work", "/tmp", "/home"):
        assert trace not in sentence
    return sentence
