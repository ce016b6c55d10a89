import json
import logging
import sys

from breastrig.core.log_lines import FIELDS, JsonLines


def test_a_line_is_one_json_object_whatever_it_says() -> None:
    try:
        raise ZeroDivisionError("an error\nof two lines")
    except ZeroDivisionError:
        caught = sys.exc_info()
    record = logging.LogRecord("breastrig.service", logging.ERROR, __file__, 1, 'fit %s "broke"\n', ("abc",), caught)
    text = JsonLines().format(record)
    line = json.loads(text)
    assert "\n" not in text
    assert (line["level"], line["logger"], line["message"]) == ("error", "breastrig.service", 'fit abc "broke"\n')
    assert line["time"].endswith("Z")
    assert "ZeroDivisionError" in line["traceback"]


def test_a_line_may_say_more_in_members_of_its_own() -> None:
    record = logging.makeLogRecord({"msg": "GET / 200", FIELDS: {"method": "GET", "status": 200}})
    line = json.loads(JsonLines().format(record))
    assert (line["message"], line["method"], line["status"]) == ("GET / 200", "GET", 200)
