"""The summary page of a batch."""

import re

from shapemorph.view.batch_page import batch_page


def _row(case, state="done", verdict="PASS", reason="", **score):
    report = f"cases/{case}/report.html" if verdict else None
    row = {"case": case, "state": state, "verdict": verdict, "reason": reason, "seconds": 2.5}
    return row | {"report": report, "scorecard": score}


def test_every_report_is_linked_and_a_failed_case_has_its_reason():
    rows = [
        _row("s1", E1=0.25),
        _row("s2", "kept", "WARN", "few points", E1=0.5),
        _row("s3", "failed", None, "no mesh"),
    ]
    page = batch_page(rows, "2 workers")
    links = re.findall(r'href="([^"]+)"', page)
    assert links == ["batch.csv", "cases/s1/report.html", "cases/s2/report.html"]
    assert "1 PASS, 1 WARN, 1 failed" in page
    assert "2 workers" in page
    assert "no mesh" in page
    assert page.count("<tr>") == 4


def test_text_of_users_is_escaped_and_nothing_is_fetched():
    page = batch_page([_row("s1", "failed", None, "<script>alert(1)</script> & co")], "")
    assert "<script" not in page
    assert "&lt;script&gt;" in page
    assert not re.search(r'(src|href)="(https?:)?//', page)
