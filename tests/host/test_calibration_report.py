"""The report of a calibration: page, JSON and table say the same, escape what files hold, and need nothing outside."""

import csv
import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from made_calibration_result import calibration_result
from made_polygon_run import STATED

from arcref.angle import ARCSEC_PER_COUNT
from arcref.calibration.calibration_result import ReportSection, SeriesErrors
from arcref.calibration.correction_budget import correction_contributions
from arcref.calibration.fits.fit_names import fit_curve
from arcref.calibration.report.calibration_page import calibration_page
from arcref.calibration.report.calibration_record import calibration_record, corrected_by_rom_counts
from arcref.calibration.report.characteristics import characteristics
from arcref.calibration.report.result_table import COLUMNS, result_csv
from arcref.calibration.uncertainty_budget import UncertaintyBudget
from arcref.check import Check
from arcref.correction_rom import CorrectionRom
from arcref.error_curve import ErrorCurve

HOSTILE = '</style><script>alert(1)</script>"><img src=x onerror=alert(2)>{{ 7 * 7 }}&amp;'


class Page(HTMLParser):
    """The page's elements: numbers with their path, ids, tags that were left open, and the plain text."""

    VOID = ("meta", "br", "img", "link")

    def __init__(self, text: str):
        super().__init__()
        self.numbers, self.ids, self.tags, self.open, self.text, self.attributes = [], [], set(), [], "", []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.tags.add(tag)
        self.attributes += attrs
        if "id" in attributes:
            self.ids.append(attributes["id"])
        if tag not in self.VOID:
            self.open.append(tag)
        if tag == "data":
            self.numbers.append([attributes, ""])

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in self.VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if "data" in self.open:
            self.numbers[-1][1] += data
        elif not {"svg", "style", "pre"} & set(self.open):
            self.text += data + " "


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """A calibration with everything: tilt, both directions, Monte Carlo."""
    folder = tmp_path_factory.mktemp("report")
    made = {"psi_arcsec": 300.0, "directions": (1, -1), "rounds": 2, "metadata": (("encoder_serial", "A 7"), *STATED)}
    return calibration_result(folder / "found.csv", runs=200, **made)


@pytest.fixture(scope="module")
def as_left(tmp_path_factory):
    """The same encoder with a smaller error."""
    folder = tmp_path_factory.mktemp("report")
    return calibration_result(folder / "left.csv", psi_arcsec=300.0, harmonics=((1, 0.2), (8, 0.1)), metadata=STATED)


@pytest.fixture(scope="module")
def over_an_arc(result):
    """An arc without fit, series or uncertainty: the least a result can hold."""
    angle = np.linspace(0.0, 40.0, 9)
    curve = ErrorCurve(angle, np.sin(angle), arc_deg=(0.0, 40.0))
    return replace(
        result,
        kind="theodolite",
        curve=curve,
        fitted=None,
        series=None,
        results={},
        budget=UncertaintyBudget(()),
        provenance={},
        checks=(Check("the arc is long enough", "40 deg", False),),
    )


def pages(result, as_left, over_an_arc):
    return [(result, None), (result, as_left), (over_an_arc, None)]


def look_up(record, path: str):
    value = record
    for part in path.split("."):
        value = value[int(part)] if isinstance(value, list) else value[part]
    return value


def strings(value):
    """Every string in a record."""
    if isinstance(value, dict):
        for each in value.values():
            yield from strings(each)
    elif isinstance(value, list):
        for each in value:
            yield from strings(each)
    elif isinstance(value, str):
        yield value


def test_every_number_on_the_page_is_that_of_the_json(result, as_left, over_an_arc):
    for found, left in pages(result, as_left, over_an_arc):
        record = json.loads(json.dumps(calibration_record(found, left), allow_nan=False))
        numbers = Page(calibration_page(found, left)).numbers
        assert len(numbers) > 30
        for attributes, shown in numbers:
            value = look_up(record, attributes["data-path"])
            assert float(attributes["value"]) == value
            shown = shown.replace("−", "-")
            half_a_digit = 0.5 * 10.0 ** -len(shown.partition(".")[2])
            factor = float(attributes.get("data-factor", 1))
            assert float(shown) == pytest.approx(value * factor, abs=half_a_digit * (1 + 1e-9)), attributes


def test_numbers_outside_data_elements_come_from_texts_of_the_record(result, as_left, over_an_arc):
    of_the_page_itself = {"95.45"}  # the coverage that k is stated for
    for found, left in pages(result, as_left, over_an_arc):
        texts = " ".join(strings(calibration_record(found, left)))
        decimals = set(re.findall(r"\d+\.\d+", Page(calibration_page(found, left)).text))
        assert {each for each in decimals if each not in texts} <= of_the_page_itself


def test_the_page_needs_nothing_outside_itself(result, as_left, over_an_arc):
    for found, left in pages(result, as_left, over_an_arc):
        text = calibration_page(found, left)
        page = Page(text)
        assert not {"script", "link", "img", "iframe", "object", "image", "base"} & page.tags
        assert "@import" not in text
        for name, value in page.attributes:
            if name in ("href", "xlink:href", "src", "action"):
                assert value.startswith("#")
        assert not re.search(r"url\((?!#)", text)
        without_namespace = text.replace('xmlns="http://www.w3.org/2000/svg"', "")
        assert "http" not in without_namespace
        assert "//" not in re.sub(r"<pre>.*?</pre>", "", without_namespace, flags=re.DOTALL)


def test_the_page_closes_what_it_opens_and_no_id_stands_twice(result, as_left):
    page = Page(calibration_page(result, as_left))
    assert page.open == []
    assert len(page.ids) == len(set(page.ids))


def test_hostile_text_is_shown_and_never_obeyed(tmp_path):
    hostile = calibration_result(
        tmp_path / "run.csv",
        metadata=(("encoder_serial", HOSTILE), ("operator", HOSTILE), ("a <b>key</b>", HOSTILE), *STATED),
        warnings=(HOSTILE,),
        sections=(ReportSection(HOSTILE, (HOSTILE,), (HOSTILE,), ((HOSTILE,),)),),
    )
    hostile = replace(
        hostile,
        method=(HOSTILE,),
        figures=((HOSTILE, HOSTILE),),
        checks=(Check(HOSTILE, HOSTILE, True),),
        not_checked=(HOSTILE,),
        provenance={"inputs": [{"file": HOSTILE, "sha256": HOSTILE}]},
    )
    text = calibration_page(hostile)
    page = Page(text)
    assert not {"script", "img"} & page.tags
    assert "onerror" not in {name for name, _ in page.attributes}
    assert "<script" not in text
    assert page.text.count("alert(1)") >= 8
    assert page.text.count("{{ 7 * 7 }}") == page.text.count("alert(1)")
    assert json.loads(json.dumps(calibration_record(hostile)))["runs"][0]["warnings"] == [HOSTILE]


def test_a_key_of_the_metadata_with_markup_stays_text(tmp_path):
    text = calibration_page(calibration_result(tmp_path / "run.csv", metadata=(("a <i>key</i>", "x"),)))
    assert "a &lt;i&gt;key&lt;/i&gt;" in text


def test_what_is_missing_from_the_budget_is_on_the_page_with_its_key(tmp_path):
    made = calibration_result(tmp_path / "run.csv", rounds=1)
    page = Page(calibration_page(made))
    for missing in made.budget.missing:
        assert f"# {missing.metadata_key}: …" in page.text
        assert missing.name in page.text
    assert "of what was stated" in page.text
    assert "not stated" in page.text  # the serial number


def test_a_failed_check_is_the_first_thing_to_see(over_an_arc):
    page = Page(calibration_page(over_an_arc))
    assert "check FAILED" in page.text[:600]
    assert not calibration_record(over_an_arc)["passed"]


def test_the_page_says_what_was_not_checked(result):
    text = Page(calibration_page(result)).text
    for sentence in result.not_checked:
        assert sentence in text
    assert "What was not checked" in text


def test_as_found_and_as_left_stand_side_by_side(result, as_left):
    record = calibration_record(result, as_left)
    assert [run["label"] for run in record["runs"]] == ["as found", "as left"]
    change = np.array(record["change_arcsec"])
    np.testing.assert_allclose(change, as_left.curve.error_arcsec - result.curve.error_arcsec)
    paths = {attributes["data-path"] for attributes, _ in Page(calibration_page(result, as_left)).numbers}
    for run in (0, 1):
        for path in ("characteristics.0.value_arcsec", "table.23.error_arcsec", "budget.expanded_arcsec"):
            assert f"runs.{run}.{path}" in paths


def test_runs_at_other_angles_stand_under_each_other(result, tmp_path):
    left = calibration_result(tmp_path / "left.csv", faces=12, metadata=STATED)
    assert calibration_record(result, left)["change_arcsec"] is None
    paths = {attributes["data-path"] for attributes, _ in Page(calibration_page(result, left)).numbers}
    assert {"runs.0.table.23.error_arcsec", "runs.1.table.11.error_arcsec"} <= paths


def test_the_table_as_csv_is_that_of_the_json(result, as_left):
    for found, left in ((result, None), (result, as_left)):
        lines = result_csv(found, left).splitlines()
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
        expected = [row for run in calibration_record(found, left)["runs"] for row in run["table"]]
        assert len(rows) == len(expected)
        for row, numbers in zip(rows, expected, strict=True):
            for key, column in COLUMNS.items():
                assert row[column] == str(numbers[key])
        assert any(line.startswith("# ") and "expanded_corrected_angle_arcsec" in line for line in lines)


def test_what_the_rom_takes_off_is_what_the_rom_takes_off(result):
    rom = CorrectionRom.from_fit(result.fitted.evaluate)
    position = np.random.default_rng(1).integers(0, 1 << 23, 500)
    counts = corrected_by_rom_counts(result.fitted, position * (360.0 / (1 << 23)))
    np.testing.assert_array_equal(counts, rom.correction(position))
    row = calibration_record(result)["runs"][0]["table"][5]
    assert row["after_arcsec"] == pytest.approx(row["error_arcsec"] - row["correction_counts"] * ARCSEC_PER_COUNT)


def test_the_true_angle_is_the_reading_less_the_error(tmp_path):
    made = calibration_result(tmp_path / "run.csv", noise_arcsec=0.0, certificate=False, harmonics=((1, 3.0),))
    row = calibration_record(made)["runs"][0]["table"][6]  # 90 deg, reduced against 0: 3 (sin(90 + 57.3) - sin 57.3)
    error = 3 * (math.sin(math.pi / 2 + 1) - math.sin(1))
    assert row["angle_dms"] == "90° 00' 00.00\""
    assert row["count"] == 1 << 21
    assert row["error_arcsec"] == pytest.approx(error, abs=1e-3)
    assert row["true_angle_dms"] == f"90° 00' {-error:05.2f}\""


def test_shares_of_the_budget_sum_to_one(result):
    budget = calibration_record(result)["runs"][0]["budget"]
    assert sum(term["share"] for term in budget["contributions"]) == pytest.approx(1)
    assert budget["expanded_of_difference_arcsec"] == pytest.approx(math.sqrt(2) * budget["expanded_arcsec"])


def test_the_orders_that_errors_within_a_line_look_like_are_marked(result):
    marked = {row["order"]: row["looks_like_orders"] for row in calibration_record(result)["runs"][0]["harmonics"]}
    assert marked[8] == [4096, 8192, 16384]  # 4096 mod 24 = 16, which is -8
    assert not any(orders for order, orders in marked.items() if order != 8)
    assert "so looks order 4096, 8192, 16384" in calibration_page(result)


def test_an_error_too_large_for_the_rom_still_makes_a_report(tmp_path):
    made = calibration_result(tmp_path / "run.csv", harmonics=((1, 900.0),), metadata=STATED)
    assert Page(calibration_page(made)).numbers


def test_characteristics_as_worked_by_hand(result):
    angle = np.arange(4) * 90.0
    series = SeriesErrors(
        angle,
        np.zeros((3, 4)),
        (1, -1, 1),
        np.array([0.2, -0.5, np.nan]),
        np.array([0.1, -0.3, 0.2, 0.0]),
    )
    made = replace(result, curve=ErrorCurve(angle, [0.0, 3.0, -1.0, 1.0]), series=series)
    division, repeatability, zero, back = characteristics(made)
    assert division.value_arcsec == pytest.approx(2.0)
    assert zero.value_arcsec == pytest.approx(0.5)
    assert "2 times, from both directions" in zero.how
    assert back.value_arcsec == pytest.approx(0.3)
    assert repeatability.value_arcsec == next(
        term.u for term in result.budget.contributions if term.name == "repeatability"
    )


def test_characteristics_that_a_run_cannot_give_say_what_they_need(tmp_path):
    one_way = calibration_result(tmp_path / "run.csv", rounds=1)
    needs = {each.key: each for each in characteristics(one_way) if each.value_arcsec is None}
    assert set(needs) == {"repeatability", "return_error"}
    assert all(each.how.startswith("needs") for each in needs.values())


def test_contributions_of_the_correction_serve_an_arc_as_well(result):
    angle = np.linspace(0.0, 40.0, 9)
    curve = ErrorCurve(angle, np.sin(np.radians(angle)), np.full(9, 0.1), arc_deg=(0.0, 40.0))
    terms, missing = correction_contributions(result.run, fit_curve(curve, "spline"))
    assert missing == ()
    assert all(math.isfinite(term.u_arcsec) for term in terms)


def test_the_same_run_gives_the_same_page(result):
    assert calibration_page(result) == calibration_page(result)
