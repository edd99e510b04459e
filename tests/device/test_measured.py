"""Charts as CSV and in archives of NumPy."""

import io
import zipfile

import numpy as np
import pytest
from device.written import AMOUNTS, INKS, NM, SPECTRA

from symrt.device.inks import load_device


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_csv_names_its_columns_in_the_first_line(tmp_path, delimiter, end):
    file = tmp_path / "chart.csv"
    rows = [["name", *INKS, *map(str, NM)]]
    rows += [["a print", *map(repr, map(float, [*a, *s]))] for a, s in zip(AMOUNTS, SPECTRA, strict=True)]
    file.write_text(end.join(delimiter.join(row) for row in rows), newline="")
    device = load_device(file)
    np.testing.assert_array_equal(device.samples, SPECTRA)
    np.testing.assert_array_equal(device.amounts, AMOUNTS)
    file.write_text("name,400\na,0.5,0.6")
    with pytest.raises(ValueError, match=r"chart.csv: line 2: 3 values for 2 fields"):
        load_device(file)
    file.write_text("")
    with pytest.raises(ValueError, match=r"no lines"):
        load_device(file)


def test_numpy_archives_hold_reflectances_by_name(tmp_path):
    file = tmp_path / "chart.npz"
    np.savez(file, wavelengths=NM, reflectances=SPECTRA, amounts=AMOUNTS, inks=np.array(["c", "m", "y", "k"]))
    device = load_device(file)
    np.testing.assert_array_equal(device.samples, SPECTRA)
    np.testing.assert_array_equal(device.amounts, AMOUNTS)
    assert device.inks == ("c", "m", "y", "k")
    for arrays, message in (
        ({"reflectances": SPECTRA}, r"no array 'wavelengths', only 'reflectances'"),
        ({"wavelengths": NM, "reflectances": SPECTRA * np.nan}, r"'reflectances' does not hold finite numbers"),
        ({"wavelengths": NM, "reflectances": np.array([object()])}, r"not a whole|allow_pickle"),
        ({"wavelengths": NM / 1000, "reflectances": SPECTRA}, r"look like micrometres"),
        ({"wavelengths": NM[::-1], "reflectances": SPECTRA}, r"wavelengths must increase"),
        ({"wavelengths": NM[:9], "reflectances": SPECTRA}, r"reflectances are \(7, 36\) for \(9,\) wavelengths"),
        ({"wavelengths": NM, "reflectances": SPECTRA, "amounts": AMOUNTS[:3]}, r"amounts are \(3, 4\) for 7 prints"),
        ({"wavelengths": NM, "reflectances": SPECTRA, "amounts": AMOUNTS * 100}, r"divide percent by 100"),
        ({"wavelengths": NM, "reflectances": SPECTRA, "amounts": np.float64(0.5)}, r"amounts are \(\) for 7 prints"),
        (
            {"wavelengths": NM, "reflectances": SPECTRA.astype(np.longdouble) * np.longdouble("1e4000")},
            r"finite numbers",
        ),
        ({"wavelengths": NM, "reflectances": SPECTRA, "amounts": AMOUNTS, "inks": np.array(list("CCMY"))}, "two inks"),
        (
            {"wavelengths": NM, "reflectances": SPECTRA, "amounts": AMOUNTS[:, :1], "inks": np.array(["a\nb"])},
            r"an ink is called 'a\\nb'",
        ),
    ):
        np.savez(file, **arrays)
        with pytest.raises(ValueError, match=message) as error:
            load_device(file)
        assert "\n" not in str(error.value)


def test_archives_of_something_else_are_refused(tmp_path):
    file, head = tmp_path / "other.npz", io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (10**9,)})
    for content, message in (
        (b"hello", r"not a whole .npz \("),
        (head.getvalue(), r"the shape of 'reflectances' is not"),
    ):
        with zipfile.ZipFile(file, "w") as archive:
            archive.writestr("reflectances", content)
            archive.writestr("wavelengths", content)
        with pytest.raises(ValueError, match=message) as error:
            load_device(file)
        assert str(error.value).endswith("save it again with numpy.savez")


def test_bombs_are_refused_before_they_unfold(tmp_path):
    file = tmp_path / "bomb.npz"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("reflectances.npy", bytes(33 << 20))
    with pytest.raises(ValueError, match=r"'reflectances.npy' claims more than 32 MiB"):
        load_device(file)
    file = tmp_path / "long.txt"
    with file.open("wb") as out:
        out.truncate(33 << 20)
    with pytest.raises(ValueError, match=r"a chart has at most 32 MiB"):
        load_device(file)
    # Many arrays, each within the limit, and not needed.
    zeros = io.BytesIO()
    np.save(zeros, np.zeros(1 << 20))
    file = tmp_path / "many.npz"
    np.savez(file, wavelengths=NM, reflectances=SPECTRA)
    with zipfile.ZipFile(file, "a", zipfile.ZIP_DEFLATED) as archive:
        for i in range(5):
            archive.writestr(f"zeros{i}.npy", zeros.getvalue())
    with pytest.raises(ValueError, match=r"'zeros3.npy' claims more than 32 MiB together"):
        load_device(file)
