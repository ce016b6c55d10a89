import json
import logging
import sys

from breastrig.core.log_lines import JsonLines


def test_a_line_is_one_json_object_whatever_it_says() -> None:
    try:
        raise ZeroDivisionError("an error\nof two lines")
    except ZeroDivisionError:
        caught = sys.exc_info()
    record = logging.LogRecord("breastrig.jobs", logging.ERROR, __file__, 1, 'fit %s "broke"\n', ("abc",), caught)
    text = JsonLines().format(record)
    line = json.loads(text)
    assert "\n" not in text
    assert (line["level"], line["logger"], line["message"]) == ("error", "breastrig.jobs", 'fit abc "broke"\n')
    assert line["time"].endswith("Z")
    assert "ZeroDivisionError" in line["traceback"]
