"""Figures are made but not drawn: what pages and tutorials draw is not looked at here."""

import pytest


@pytest.fixture(scope="module", autouse=True)
def _rough_pictures():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rotor_ida.plot.saving._draw", lambda _, path: path.touch())
        patch.setattr("rotor_ida.plot.appearance.MOST_PASSES", 1)
        patch.setattr("rotor_ida.cli.pages.RESOLUTION", 30)
        patch.setattr("rotor_ida.cli.pages.write_pdf", lambda path, *_: path.touch())
        yield
