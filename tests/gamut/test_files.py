"""Gamuts of every model in files: they come back bit for bit, and what was damaged or changed is refused."""

import io
import json
import pickle
import zipfile
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

import symrt.gamut.files as module
from symrt.archives import read_archive, write_archive
from symrt.device.fitting import fit_halftone
from symrt.device.halftone import Halftone
from symrt.device.inks import load_device
from symrt.device.printing import Device
from symrt.gamut.files import KIND, load_gamut, save_gamut
from symrt.gamut.gamuts import device_gamut
from symrt.spectra.bands import wavelengths
from symrt.spectra.library import spectrum

BANDS = wavelengths(400, 700, 20)


def measured(draw=3):
    """A chart of a made-up printer, with an instrument's noise: measured prints with known amounts."""
    device = load_device("synthetic-cmyk", BANDS)
    random = np.random.default_rng(draw)
    chosen = random.permutation(len(device.samples))[:60]
    noisy = device.samples[chosen] + random.normal(0, 1e-4, (60, len(BANDS)))
    return Device(
        "chart.ti3", BANDS, noisy, device.amounts[chosen], device.inks, np.zeros(len(BANDS), bool), "60 “prints”",
        "Ünïcode, a long line and a \"quote\".", modelled=False,
    )  # fmt: skip


def geometric():
    """A printer of one ink whose exponent is infinite, with a black below 0, as instruments read it."""
    printer = Halftone(BANDS, ("K",), np.array([[0.9] * 16, [1e-3] * 16]), np.inf, np.array([0.1]), most=0.9)
    amounts = np.array([[0.0], [0.4], [0.9]])
    samples = printer.printed(amounts) - [[0], [0], [0.02]]
    return Device("one-ink", BANDS, samples, amounts, ("K",), np.arange(16) < 2, "one ink", "made up", printer)


def made(name):
    """A gamut by its name in the tests below."""
    kind, _, black = name.partition("/")
    small = load_device("dye3-endura-premier", BANDS)
    if kind in {"unit", "envelope"}:
        return device_gamut(small, kind, black)
    return {
        "under": lambda: device_gamut(small, "envelope", "luminance").under(spectrum("illuminant/A", BANDS)),
        "chart": lambda: device_gamut(replace(measured(), amounts=np.empty((60, 0)), inks=()), "envelope", "strict"),
        "hull": lambda: device_gamut(small, "hull", tolerance=0.02),
        "chart's hull": lambda: device_gamut(measured(), "hull", tolerance=0.0),
        "inks": lambda: device_gamut(small, "inks"),
        "fitted": lambda: device_gamut(fit_halftone(measured()).device, "inks", tolerance=0.003),
        "one ink": lambda: device_gamut(geometric(), "inks"),
        "colorimetric": lambda: device_gamut(small, "colorimetric", light="illuminant/A"),
        "chart's colours": lambda: device_gamut(measured(), "colorimetric"),
        "monitor": lambda: device_gamut(load_device("crt-brainard"), "monitor"),
        "monitor under": lambda: device_gamut(load_device("apple-studio-display", BANDS), "monitor").under(
            spectrum("illuminant/A", BANDS)
        ),
        "srgb": lambda: device_gamut(load_device("srgb"), "monitor"),
    }[kind]()


NAMES = [
    *(f"{model}/{black}" for model in ("unit", "envelope") for black in ("clip", "luminance", "strict")),
    *("under", "chart", "hull", "chart's hull", "inks", "fitted", "one ink", "colorimetric", "chart's colours"),
    *("monitor", "monitor under", "srgb"),
]


def assert_same_bits(one, other):
    """Two records are of one class and hold the same, bit for bit."""
    assert type(one) is type(other)
    if is_dataclass(one):
        for field in fields(one):
            assert_same_bits(getattr(one, field.name), getattr(other, field.name))
    elif isinstance(one, np.ndarray):
        assert (one.dtype, one.shape) == (other.dtype, other.shape)
        assert np.ascontiguousarray(one).tobytes() == np.ascontiguousarray(other).tobytes()
    else:
        assert repr(one) == repr(other)


@pytest.mark.parametrize("name", NAMES)
def test_a_gamut_of_every_model_comes_back_bit_for_bit_and_answers_alike(name, tmp_path):
    gamut = made(name)
    save_gamut(tmp_path / "a.npz", gamut)
    again = load_gamut(tmp_path / "a.npz")
    assert [p.name for p in tmp_path.iterdir()] == ["a.npz"]
    assert_same_bits(again, gamut)
    assert (repr(again), again.name, again.label, again.bands) == (repr(gamut), gamut.name, gamut.label, gamut.bands)
    random = np.random.default_rng(0)
    spectra = random.uniform(-0.1, 1.1, (12, len(gamut.bands))) * random.uniform(0.2, 1, (12, 1))
    spectra[::3] = np.random.default_rng(1).uniform(0, 1, (4, 1))
    ask = [name for name in ("contains", "violation", "nearest", "support") if hasattr(gamut, name)]
    for question in ask:
        np.testing.assert_array_equal(getattr(again, question)(spectra), getattr(gamut, question)(spectra))


def test_a_gamut_that_was_loaded_saves_to_the_same_arrays_and_header(tmp_path):
    for name in NAMES:
        save_gamut(tmp_path / "a.npz", made(name))
        save_gamut(tmp_path / "b.npz", load_gamut(tmp_path / "a.npz"))
        (one, header), (other, again) = (read_archive(tmp_path / f"{file}.npz", KIND) for file in "ab")
        assert header == again
        assert {n: a.tobytes("A") for n, a in one.items()} == {n: a.tobytes("A") for n, a in other.items()}


class Foreign:
    """A printer that files know nothing of."""

    bands, inks, most = BANDS, ("K",), 1.0

    def printed(self, amounts):
        return 1 - amounts @ np.full((1, 16), 0.9)

    def on(self, bands):
        raise NotImplementedError


def test_a_printer_that_files_do_not_hold_is_refused_and_nothing_is_written(tmp_path):
    gamut = device_gamut(replace(geometric(), printer=Foreign()), "inks")
    with pytest.raises(ValueError, match="one-ink: its printer is a Foreign, and files hold dyes and halftone"):
        save_gamut(tmp_path / "a.npz", gamut)
    assert list(tmp_path.iterdir()) == []


def test_a_failed_save_keeps_the_old_file(tmp_path, monkeypatch):
    save_gamut(tmp_path / "a.npz", made("srgb"))
    before = (tmp_path / "a.npz").read_bytes()

    def full_disk(file, **_):
        file.write(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full_disk)
    with pytest.raises(OSError, match="No space left"):
        save_gamut(tmp_path / "a.npz", made("monitor"))
    assert (tmp_path / "a.npz").read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["a.npz"]


def refused(path, reason):
    with pytest.raises(ValueError, match=reason) as caught:
        load_gamut(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "save" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """Files of some gamuts, by name."""
    folder = tmp_path_factory.mktemp("saved")
    for name in ("envelope/luminance", "hull", "fitted", "colorimetric", "monitor", "srgb"):
        save_gamut(folder / f"{name.replace('/', '-')}.npz", made(name))
    return {path.stem: path for path in folder.iterdir()}


def test_a_file_cut_off_anywhere_or_of_something_else_is_refused(saved, tmp_path):
    whole, path = saved["monitor"].read_bytes(), tmp_path / "cut.npz"
    for length in (0, 1, 3, *range(100, len(whole), 97), len(whole) - 1):
        path.write_bytes(whole[:length])
        refused(path, "not a whole symrt gamut")
    path.write_bytes(b"gamut")
    refused(path, "not a whole symrt gamut")
    refused(tmp_path / "none.npz", "no such file")
    refused(tmp_path, "not a whole symrt gamut")


def test_a_flipped_bit_is_noticed(saved, tmp_path):
    whole = saved["fitted"].read_bytes()
    with zipfile.ZipFile(io.BytesIO(whole)) as archive:
        infos = archive.infolist()
    for info in infos:
        damaged = bytearray(whole)
        damaged[info.header_offset + 30 + len(info.filename) + info.compress_size // 2] ^= 1
        (tmp_path / "b.npz").write_bytes(damaged)
        refused(tmp_path / "b.npz", "not a whole symrt gamut")


def as_it_was_sealed(path, header, arrays):
    """Write header and arrays with the digest that stands in the header, whether or not it is theirs."""
    np.savez(path, header=np.frombuffer(json.dumps(header).encode(), dtype=np.uint8), **arrays)


def test_a_number_that_was_changed_is_noticed_even_where_it_might_have_been(saved, tmp_path):
    arrays, header = read_archive(saved["envelope-luminance"], KIND)
    changed = arrays["device0_samples"].copy()
    changed[5, 5] = np.nextafter(changed[5, 5], 0)
    as_it_was_sealed(tmp_path / "a.npz", header, arrays | {"device0_samples": changed})
    refused(tmp_path / "a.npz", "it was changed after it was saved")
    arrays, header = read_archive(saved["hull"], KIND)
    header["gamuts"][0]["tolerance"] = (0.5).hex()
    as_it_was_sealed(tmp_path / "b.npz", header, arrays)
    refused(tmp_path / "b.npz", "it was changed after it was saved")


def put(value, *path):
    """A change of the header at a path of keys."""

    def change(header, _):
        inner = header
        for key in path[:-1]:
            inner = inner[key]
        inner[path[-1]] = value(inner[path[-1]]) if callable(value) else value

    return change


def array(name, change):
    """A change of an array; None takes it away."""

    def changed(_, arrays):
        arrays[name] = change(arrays.get(name))
        if arrays[name] is None:
            del arrays[name]

    return changed


def at(place, value):
    def change(given):
        given = given.copy()
        given[place] = value
        return given

    return change


DEVICE, GAMUT = ("devices", 0), ("gamuts", 0)
DAMAGE = [
    ("hull", array("device0_samples", lambda a: a[:, :5]), r"device0_samples is \(729, 5\), not \(729, 16\)"),
    ("hull", array("device0_samples", lambda a: a[0]), r"device0_samples is \(16,\)"),
    ("hull", array("device0_samples", lambda a: a[:0]), r"amounts is \(729, 3\), not \(0, 3\)"),
    ("hull", array("device0_samples", at((3, 3), np.nan)), "device0_samples does not hold finite float64"),
    ("hull", array("device0_samples", lambda a: a.astype(np.float32)), "device0_samples does not hold finite float64"),
    ("hull", array("device0_samples", lambda _: None), "'device0_samples' is missing"),
    ("hull", array("device0_amounts", lambda a: a[:, :2]), r"device0_amounts is \(729, 2\), not \(729, 3\)"),
    ("hull", array("device0_extrapolated", lambda a: a.astype(float)), "does not hold finite bool numbers"),
    ("hull", array("device0_printer_densities", lambda a: a[:2]), "device0_printer_densities is"),
    ("hull", array("more", lambda _: np.ones(3)), "more belongs to nothing"),
    ("hull", put((1e-9).hex(), *GAMUT, "tolerance"), "the tolerance is less than the sampling gap"),
    ("hull", put("nan", *GAMUT, "tolerance"), "the tolerance is less than the sampling gap"),
    ("hull", put("inf", *GAMUT, "tolerance"), "the tolerance is less than the sampling gap"),
    ("hull", put("a lot", *GAMUT, "tolerance"), "not a whole symrt gamut"),
    ("hull", put(0.01, *GAMUT, "tolerance"), "0.01 is not a text"),
    ("hull", put("monitor", *GAMUT, "model"), "monitor is no gamut of dye3-endura-premier"),
    ("hull", put("__import__", *GAMUT, "model"), "'__import__' is none of unit, envelope"),
    ("hull", put([], *GAMUT, "model"), "is none of unit, envelope"),
    ("hull", put(1, *GAMUT, "device"), "there is no device 1"),
    ("hull", put(-1, *GAMUT, "device"), "there is no device -1"),
    ("hull", put(True, *GAMUT, "device"), "there is no device True"),
    ("hull", put([], "gamuts"), "no gamuts to intersect"),
    ("hull", put(None, "devices"), "not a whole symrt gamut"),
    ("hull", put(5, *DEVICE, "name"), "5 is not a text"),
    ("hull", put("yes", *DEVICE, "modelled"), "whether the prints are modelled"),
    ("hull", put(["cyan"], *DEVICE, "inks"), "device0_amounts is"),
    ("hull", put([1, 2, 3], *DEVICE, "inks"), "1 is not a text"),
    ("hull", put("os", *DEVICE, "printer", "kind"), "'os' is none of dyes, halftone"),
    ("hull", put((-1.0).hex(), *DEVICE, "printer", "most"), "the largest amount of an ink is not above 0"),
    ("hull", put("colour", *DEVICE, "bands", "kind"), "bands of kind 'colour'"),
    ("hull", put("rgb", *DEVICE, "bands", "kind"), "RGB has the bands 0, 1 and 2"),
    ("hull", put(lambda c: c[::-1], *DEVICE, "bands", "centres"), "wavelengths must increase"),
    ("hull", put(lambda c: c[1:], *DEVICE, "bands", "centres"), "printer_densities is"),
    ("hull", put("inf", *DEVICE, "printer", "most"), "the largest amount of an ink is not above 0"),
    ("hull", put("nan", *DEVICE, "printer", "paper"), "paper nan, surface 0.004"),
    ("hull", put((0.95).hex(), *DEVICE, "printer", "surface"), "paper 0.9, surface 0.95"),
    ("fitted", put((0.5).hex(), *DEVICE, "printer", "exponent"), "n is 1 or more"),
    ("fitted", put(None, *DEVICE, "printer"), "there is no printer whose inks are meant"),
    ("fitted", array("device0_printer_gain", lambda a: a + 1), "a gain within"),
    ("fitted", array("device0_printer_primaries", lambda a: a[:8]), r"printer_primaries is \(8, 16\), not \(16, 16\)"),
    ("fitted", put((0.0).hex(), *GAMUT, "tolerance"), "the tolerance is not above 0"),
    ("envelope-luminance", array("gamut0_lower", lambda a: a + 2), "a lower bound is above the upper"),
    ("envelope-luminance", array("gamut0_upper", lambda a: a * 0.9), "the envelope does not hold the prints"),
    ("envelope-luminance", array("gamut0_upper", at(2, np.inf)), "gamut0_upper does not hold finite"),
    ("envelope-luminance", array("gamut0_weights", lambda _: None), "weights belong to the luminance of black alone"),
    ("envelope-luminance", array("gamut0_weights", lambda a: a * 2), "weights of luminance"),
    ("envelope-luminance", put("lift", *GAMUT, "black"), "black is 'lift', none of clip"),
    ("envelope-luminance", put("strict", *GAMUT, "black"), "weights belong to the luminance of black alone"),
    ("colorimetric", array("gamut0_offsets", lambda a: a - 0.01), "a corner is outside a face"),
    ("colorimetric", array("gamut0_offsets", lambda a: a[:-1]), "gamut0_offsets is"),
    ("colorimetric", array("gamut0_colours", lambda a: a[:4]), "a face has fewer than three corners"),
    ("colorimetric", put("illuminant/D50", *GAMUT, "light"), "a print's colour is outside"),
    ("colorimetric", put("illuminant/X", *GAMUT, "light"), "no spectrum is named"),
    ("monitor", array("device0_primaries", np.ones_like), "the primaries span no three colours"),
    ("monitor", array("gamut0_drive", lambda a: a * 0), "the drive values span no three colours"),
    ("monitor", put("printer", *DEVICE, "kind"), "not a whole symrt gamut"),
    ("srgb", put(["0x0p0"], *DEVICE, "bands", "centres"), "RGB has the bands"),
]


@pytest.mark.parametrize(("name", "damage", "reason"), DAMAGE)
def test_parts_that_contradict_each_other_are_refused_whatever_the_digest(saved, tmp_path, name, damage, reason):
    arrays, header = read_archive(saved[name], KIND)
    kept = {key: header[key] for key in ("devices", "gamuts")}
    damage(kept, arrays)
    write_archive(tmp_path / "b.npz", KIND, kept, arrays)
    refused(tmp_path / "b.npz", reason)


@pytest.mark.parametrize(
    ("header", "reason"),
    [
        (b'{"format": "symrt-gamut", "version": 99}', "it is of version 99, and this symrt reads 3"),
        (b'{"format": "symrt-system", "version": 2}', "its header does not say 'symrt-gamut'"),
        (b'{"format": "symrt-gamut", "version": 3}', "'devices' is missing"),
        (b"[1, 2]", "its header does not say"),
        (b"{not json", "not a whole symrt gamut"),
        (b"\xff\xfe", "not a whole symrt gamut"),
        (b"[" * 100_000, "not a whole symrt gamut"),
    ],
)
def test_headers_of_another_kind_are_refused(tmp_path, header, reason):
    np.savez(tmp_path / "a.npz", header=np.frombuffer(header, dtype=np.uint8))
    refused(tmp_path / "a.npz", reason)


class Bomb:
    def __reduce__(self):
        return (exec, ("raise SystemExit('a pickle was run')",))


def test_a_pickle_is_never_run(tmp_path):
    with (tmp_path / "a.npz").open("wb") as file:
        np.savez(file, header=np.array([Bomb()], dtype=object))
    refused(tmp_path / "a.npz", "an array of objects")
    (tmp_path / "b.npz").write_bytes(pickle.dumps(Bomb()))
    refused(tmp_path / "b.npz", "not a whole symrt gamut")


@pytest.mark.parametrize("shape", [(1 << 50,), (1 << 20, 1 << 40), (3,), (5, 5), ()])
def test_a_shape_that_claims_more_or_less_than_there_is_is_refused_unread(saved, tmp_path, shape):
    path = tmp_path / "a.npz"
    path.write_bytes(saved["srgb"].read_bytes())
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": shape})
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("claims.npy", head.getvalue() + bytes(16))
    refused(path, r"the shape of 'claims\.npy' is not that of its")


def test_what_unpacks_to_too_much_or_is_there_twice_is_refused(saved, tmp_path, monkeypatch):
    path = tmp_path / "a.npz"
    path.write_bytes(saved["srgb"].read_bytes())
    monkeypatch.setattr(module, "LARGEST", 1 << 20)
    assert load_gamut(path).name == made("srgb").name
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("zeros.npy", bytes((1 << 20) + 1))
    refused(path, r"zeros\.npy' claims more than")
    path.write_bytes(saved["srgb"].read_bytes())
    with zipfile.ZipFile(path, "a") as archive, pytest.warns(UserWarning, match="Duplicate name"):
        archive.writestr("header.npy", json.dumps({}))
    refused(path, "one appears twice")


def test_arrays_that_unpack_to_too_much_together_are_refused(saved, tmp_path, monkeypatch):
    path = tmp_path / "a.npz"
    path.write_bytes(saved["srgb"].read_bytes())
    monkeypatch.setattr(module, "LARGEST", 1 << 20)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        for i in range(3):
            content = io.BytesIO()
            np.save(content, np.zeros(50_000))
            archive.writestr(f"zeros{i}.npy", content.getvalue())
    refused(path, r"zeros2\.npy' claims more than 1 MiB together with what is before it")
