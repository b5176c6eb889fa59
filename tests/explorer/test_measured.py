"""A measured file is analysed by the library; what cannot be drawn is left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rotor_ida.explorer import measured
from rotor_ida.explorer.messages import Upload
from rotor_ida.signals.orders import orders
from rotor_ida.signals.reading import NO_UNIT, read_signals
from rotor_ida.signals.spectra import full_spectrum, spectrogram
from tests.explorer.asking import Message, answer_to

STEP = 0.01


def written(path: Path, rate: float, *, angle: bool = True, size: int = 6000) -> Path:
    """Write a whirl with a harmonic, at a speed that rises from 1 at a rate."""
    t = STEP * np.arange(size)
    turn = t + 0.5 * rate * t**2
    z = np.exp(1j * turn) + 0.2 * np.exp(-2j * turn)
    columns = [t, z.real, z.imag, *([turn] if angle else [])]
    names = ",".join(("t", "x", "y", "angle")[: len(columns)])
    np.savetxt(path, np.stack(columns, axis=1), "%.17g", ",", header=names, comments="")
    return path


def analysed(path: Path, **changes: object) -> Message:
    given = {"number": 1, "name": "probes.csv", "size": 1, "probe_angles": (0.0, 90.0),
             "gains": (1.0, 1.0), "path": path} | changes  # fmt: skip
    (message,) = answer_to(Upload(about="upload", **given))  # type: ignore[arg-type]
    return message


@pytest.mark.parametrize("changes", [{}, {"probe_angles": (45.0, 135.0), "gains": (2.0, 0.5)}])
def test_order_1_and_one_spectrum_at_one_speed(changes: dict[str, object], tmp_path: Path):
    path = written(tmp_path / "one.csv", 0.0)
    found, signals = analysed(path, **changes), read_signals(path, **changes)  # type: ignore[arg-type]
    tracked = orders(signals).isel(order=0)
    np.testing.assert_array_equal(found.arrays["order_speed"], tracked.speed)
    np.testing.assert_array_equal(found.arrays["order_amplitude"], tracked.forward_whirl_amplitude)
    np.testing.assert_array_equal(found.arrays["order_lag"], tracked.forward_phase_lag)
    lines = full_spectrum(signals)
    drawn = np.abs(lines.frequency_over_omega.values) <= measured.ORDERS
    np.testing.assert_array_equal(found.arrays["full_frequency"], lines.frequency[drawn])
    np.testing.assert_array_equal(found.arrays["full_amplitude"], lines.whirl_amplitude[drawn])
    unit, *_, mean = found.facts["notes"]
    assert unit == NO_UNIT
    assert mean.startswith("the mean position is subtracted: x ")
    assert found.facts["by"] == "angle"
    assert "cascade_speed" not in found.arrays


def test_a_cascade_while_the_speed_changes_has_no_more_rows_than_can_be_told_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    path = written(tmp_path / "up.csv", 0.05)
    found = analysed(path)
    frequency = found.arrays["cascade_frequency"]
    segment = round(2.0 * np.pi / STEP / (frequency[1] - frequency[0]))
    assert segment == measured.segment_for(0.05, STEP)
    exact = spectrogram(read_signals(path), segment=segment)
    rows = np.isin(exact.speed, found.arrays["cascade_speed"])
    drawn = np.isin(exact.frequency, frequency)
    assert rows.all()
    np.testing.assert_array_equal(
        found.arrays["cascade_amplitude"].reshape(-1, frequency.size),
        exact.whirl_amplitude.values[:, drawn],
    )
    assert "full_frequency" not in found.arrays
    monkeypatch.setattr(measured, "MOST_ROWS", 3)
    few = analysed(path).arrays["cascade_speed"]
    assert 2 <= few.size <= 4
    assert np.isin(few, exact.speed).all()


def test_of_lines_too_many_to_be_drawn_the_tallest_are_sent(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    path = written(tmp_path / "plain.csv", 0.0, angle=False)
    full = analysed(path)
    assert [full.facts["notes"][place] for place in (0, -1)] == [NO_UNIT, measured.NO_ANGLE]
    assert full.facts["speed"] is None
    monkeypatch.setattr(measured, "MOST_LINES", 500)
    few = analysed(path)
    assert few.arrays["full_amplitude"].size == 500
    assert few.arrays["full_amplitude"].max() == full.arrays["full_amplitude"].max()


def test_what_cannot_be_analysed_is_a_note(tmp_path: Path):
    t = STEP * np.arange(6000.0)
    t += 0.3 * STEP * np.sin(t)  # not equally spaced
    table = np.stack([t, np.cos(t), np.sin(t), t], axis=1)
    np.savetxt(tmp_path / "odd.csv", table, "%.17g", ",", header="t,x,y,angle", comments="")
    found = analysed(tmp_path / "odd.csv")
    (*_, note) = found.facts["notes"]
    assert "equally spaced" in note
    assert found.arrays["order_speed"].size > 5


def test_a_file_that_is_refused_has_the_name_that_the_page_knows(tmp_path: Path):
    """Not that of the stored file, nor its folder."""
    for name, told in (
        ("a+b.wav", "'a+b.wav' must be a WAV file: "),
        ("a+b.nc", "a+b.nc is not an archive of rotor_ida: "),
    ):
        path = tmp_path / name.replace("+", "_")
        path.write_bytes(b"RIFF")
        found = analysed(path, name=name)
        assert found.part == "trouble"
        assert found.facts["message"].startswith(told)


def test_columns_that_are_not_clear_are_offered_with_what_is_wrong(tmp_path: Path):
    path = written(tmp_path / "one.csv", 0.0)
    path.write_text(path.read_text().replace("t,x,y,angle", "t,left [um],right [um],angle", 1))
    found = analysed(path)
    assert found.part == "measured"
    assert "must have a column for x and y" in found.facts["trouble"]
    assert found.facts["names"] == [["t", ""], ["left", "um"], ["right", "um"], ["angle", ""]]
    chosen = analysed(path, columns={"x": "left", "y": "right"}, units={"x": "mm", "y": "mm"})
    assert chosen.facts["columns"] == {"t": "t", "x": "left", "y": "right", "angle": "angle"}
    assert chosen.facts["length"] == "mm"
    assert chosen.arrays["order_speed"].size > 5
    wrong = analysed(path, columns={"x": "none", "y": "right"})
    assert "the file must have the column 'none' for x" in wrong.facts["trouble"]
