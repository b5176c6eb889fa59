"""Figures of few dots, laid out once: what pages and tutorials draw is not looked at here."""

import pytest


@pytest.fixture(scope="module", autouse=True)
def _rough_pictures():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rotor_ida.plot.saving._DOTS_PER_INCH", 30)
        patch.setattr("rotor_ida.plot.appearance.MOST_PASSES", 1)
        patch.setattr("rotor_ida.cli.pages.RESOLUTION", 30)
        yield
