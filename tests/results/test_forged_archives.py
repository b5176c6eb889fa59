"""Files made to harm a reader are refused, with and without a seal of the forger's."""

from __future__ import annotations

from pathlib import Path

import netCDF4
import pytest

from rotor_ida import ArchiveError, load
from rotor_ida.results.archive.checksum import append_seal

forgeries = pytest.importorskip("tests.results.forgeries", reason="forgeries need h5py")


@pytest.mark.parametrize(("forgery", "message"), forgeries.SEALED_AGAIN.items())
def test_forged_archive_is_refused(
    forgery: str, message: str, archive: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    forgeries.FORGERIES[forgery](archive)
    with monkeypatch.context() as patch:
        patch.setattr(netCDF4, "Dataset", None)  # netCDF must not open it at all
        with pytest.raises(ArchiveError, match=r"no seal; xarray.open_dataset and ncdump may"):
            load(archive)
    append_seal(archive)
    if "outside" in message:
        monkeypatch.setattr(netCDF4, "Dataset", None)
    with pytest.raises(ArchiveError, match=message):
        load(archive)
