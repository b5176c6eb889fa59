"""The data sheet of a machine in a browser: its form, its sliders, the verdict on it."""

from __future__ import annotations

import pytest

from tests.explorer.browser import copied, needs_browser

# On a machine that does other things as well.
pytestmark = [needs_browser, pytest.mark.timeout(1500)]

# A pump in engineering units.
PUMP = {
    "mass": "12 kg", "shaft_stiffness": "4 MN/m", "damping": "415.7 N s/m", "clearance": "150 um",
    "eccentricity": "40 um", "speed": "3600 rpm", "friction": "0.3", "contact_stiffness": "1e8 N/m",
    "disc_radius": "60 mm",
}  # fmt: skip


def test_a_data_sheet_sets_the_machine(page):
    page.find("#sheet-open").click()
    for name, words in PUMP.items():
        page.type(f"#sheet-{name}", words)
    page.find("#sheet-apply").click()
    page.until("!document.getElementById('sheet').open")
    page.settle("settled")
    check_sliders_in_engineering_units(page)
    check_command_in_si_units(page)
    check_verdict(page)


def check_sliders_in_engineering_units(pump):
    shown = {
        "mass": "12", "speed": "3600", "clearance": "150", "eccentricity": "40", "damping": "415.7",
        "contact_stiffness": "100", "shaft_stiffness": "4", "disc_radius": "60", "friction": "0.3",
    }  # fmt: skip
    for name, value in shown.items():
        assert pump.find(f"#field-{name}").get_attribute("value") == value
    label = pump.find("label[for='field-clearance']").text
    assert label == "Clearance [µm]"
    assert pump.find("#fastest").get_attribute("value") == "6000"
    assert pump.run(
        "return rotorIda.plotOf(document.querySelector("
        "'[data-panel=\"response\"] .u-over')).scales.x.max"
    ) == pytest.approx(9000)
    # the sliders lie around these values, and their ends are not far
    ends = pump.run(
        "return ['min', 'max'].map((end) => Number("
        "document.getElementById('slider-clearance')[end]))"
    )
    place = float(pump.find("#slider-clearance").get_attribute("value"))
    assert ends[0] < place < ends[1]


def check_command_in_si_units(pump):
    text = copied(pump, '[data-copy="sh"]', "The command line is copied.")
    assert text.startswith("rotor-ida simulate --mass 12.0 --contact-stiffness 100000000.0")


def check_verdict(pump):
    """In bold above the fold."""
    box = pump.find("#verdict").rect
    assert box["y"] + box["height"] < 200
    assert int(pump.find("#verdict").value_of_css_property("font-weight")) >= 600
    assert pump.find("#verdict").text.startswith(
        "No contact: radius 29.66 µm, gap 120.3 µm left of"
    )


def test_a_wrong_data_sheet_is_told_of_in_the_form(page):
    page.find("#sheet-open").click()
    page.type("#sheet-mass", "12 parsecs")
    page.find("#sheet-apply").click()
    told = page.until("document.getElementById('sheet-wrong').textContent")
    assert "also give" in told or "mass" in told
    page.find("#sheet-cancel").click()
    assert page.state()["omega"] == 2.0
