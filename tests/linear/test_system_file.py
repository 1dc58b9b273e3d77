"""Files of systems: the same bits after a round trip, and what MATLAB and Octave write."""

import shutil
import subprocess
from dataclasses import replace

import control
import numpy as np
import pytest
from scipy.io import loadmat, savemat

import tvclin as tv

PLANT = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
AUTOPILOT = tv.Autopilot(attitude_gain=0.3, rate_gain=0.5, actuator=tv.Actuator(), delay=0.02)


def _same_bits(read, system):
    for letter in "ABCD":
        given = np.ascontiguousarray(getattr(system, letter))
        assert np.ascontiguousarray(getattr(read, letter)).tobytes() == given.tobytes()
    assert read.inputs == tuple(system.input_labels)
    assert read.outputs == tuple(system.output_labels)
    assert read.states == tuple(system.state_labels)


@pytest.mark.parametrize("suffix", ["mat", "npz"])
@pytest.mark.parametrize(
    "system",
    [
        PLANT.ss(),
        tv.linear.plant_of(tv.load_vehicle("made-up-booster")).ss(),
        AUTOPILOT.loop(PLANT),
        AUTOPILOT.close(PLANT),
        control.StateSpace([], [], [], [[0.3, 0.5]], 0.02, inputs=["a", "b"], outputs=["u"]),
    ],
)
def test_a_system_has_the_same_bits_after_a_round_trip(tmp_path, system, suffix):
    file = tmp_path / f"system.{suffix}"
    tv.linear.write_system(system, file)
    read = tv.linear.read_system(file)
    _same_bits(read, system)
    dt = 0.0 if read.period is None else float(read.period)
    assert dt == system.dt
    again = read.to_control("again")
    assert again.dt == system.dt
    assert np.array_equal(again.A, system.A)


def test_a_plant_and_a_controller_from_files_are_analysed(tmp_path):
    files = [tmp_path / name for name in ("plant.mat", "controller.mat")]
    tv.linear.write_system(PLANT.ss(), files[0])
    law = control.StateSpace(
        [], [], [], [[0.3, 0.5]], inputs=["attitude", "attitude_rate"], outputs=["u"]
    )
    tv.linear.write_system(law, files[1])
    plant = tv.linear.SystemPlant(tv.linear.read_system(files[0]))
    controller = tv.control.SystemAutopilot(
        tv.linear.read_system(files[1]), actuator=tv.Actuator(), delay=0.02
    )
    margin = controller.margins(plant).phase_margin_deg
    assert margin == pytest.approx(AUTOPILOT.margins(PLANT).phase_margin_deg, rel=1e-9)


def test_the_cells_and_structs_of_matlab_are_read(tmp_path):
    A, B, C, D = PLANT.matrices()
    cells = np.array([["deflection"], ["wind"]], dtype=object)
    rows = np.array(PLANT.outputs)  # a padded matrix of characters, as char() and Octave have it
    variables = {"A": A, "B": B, "C": C, "D": D, "Ts": 0.0}
    names = {"InputName": cells, "OutputName": rows}
    savemat(tmp_path / "flat.mat", variables | names)
    savemat(tmp_path / "packed.mat", {"s": variables | names}, do_compression=True)
    savemat(tmp_path / "short.mat", variables | {"inputs": cells, "outputs": rows, "dt": 0})
    for name in ("flat", "packed", "short"):
        read = tv.linear.read_system(tmp_path / f"{name}.mat")
        assert (read.inputs, read.outputs) == (PLANT.inputs, PLANT.outputs)
        assert np.array_equal(read.A, A)


def test_a_written_file_has_cells_of_names_as_columns(tmp_path):
    tv.linear.write_system(PLANT.ss(), tmp_path / "plant.mat")
    content = loadmat(tmp_path / "plant.mat")
    assert content["InputName"].shape == (2, 1)
    assert content["InputName"][1, 0].item() == "wind"
    assert content["Ts"].item() == 0.0


def _written(folder, name, **changes):
    variables = dict(zip("ABCD", PLANT.matrices(), strict=True)) | changes
    file = folder / name
    if name.endswith("npz"):
        np.savez(file, **{k: v for k, v in variables.items() if v is not None})
    else:
        savemat(file, {k: v for k, v in variables.items() if v is not None})
    return file


@pytest.mark.parametrize(
    ("file", "message"),
    [
        (lambda f: _written(f, "a.mat", B=None), "has no B; its variables are A, C, D"),
        (lambda f: _written(f, "a.npz", B=np.ones((2, 2))), "B of .*a.npz must be 3 by 2"),
        (lambda f: _written(f, "a.mat", A=np.eye(2)), "must be 2 by 2, for 2 states"),
        (lambda f: _written(f, "a.mat", A=1j * np.eye(3)), "matrix of real numbers"),
        (lambda f: _written(f, "a.mat", C=np.nan * np.ones((4, 3))), "finite"),
        (lambda f: _written(f, "a.npz", inputs=["x", "x"]), "x is twice"),
        (lambda f: _written(f, "a.npz", inputs=[1, 2]), "cells or rows of text"),
        (lambda f: _written(f, "a.mat", Ts=-1.0), "sample time Ts in seconds"),
        (lambda f: f / "missing.mat", "does not exist"),
        (lambda f: f / "system.txt", "must end in .mat or .npz"),
    ],
)
def test_a_bad_file_is_refused_in_one_sentence(tmp_path, file, message):
    with pytest.raises(tv.InputError, match=message):
        tv.linear.read_system(file(tmp_path))


def test_damaged_and_newer_files_are_refused_in_one_sentence(tmp_path):
    header = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM" + b"\x89HDF"
    for name, content, message in (
        ("new.mat", header, "version 7.3; save it in MATLAB with -v7"),
        ("text.mat", b"# Created by Octave 8.4\n# name: A\n", "save it with -v7"),
        ("bad.npz", b"PK\x03\x04 no", "is not a .mat file"),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(tv.InputError, match=message):
            tv.linear.read_system(tmp_path / name)
    whole = _written(tmp_path, "whole.mat").read_bytes()
    (tmp_path / "cut.mat").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(tv.InputError, match=r"save it with -v7|has no"):
        tv.linear.read_system(tmp_path / "cut.mat")
    with pytest.raises(tv.InputError, match="must end in"):
        tv.linear.write_system(PLANT.ss(), tmp_path / "plant.txt")


@pytest.mark.thorough
@pytest.mark.skipif(shutil.which("octave-cli") is None, reason="needs Octave")
@pytest.mark.parametrize("rate", [None, 50.0])
def test_octave_reads_and_writes_the_same_system(tmp_path, rate):
    loop = replace(AUTOPILOT, sample_rate=rate).loop(PLANT)
    tv.linear.write_system(loop, tmp_path / "loop.mat")
    script = """
        s = load("loop.mat");
        assert(iscellstr(s.InputName) && iscellstr(s.OutputName) && iscellstr(s.StateName));
        A = s.A; B = s.B; C = s.C; D = s.D; Ts = s.Ts;
        InputName = s.InputName; OutputName = s.OutputName'; StateName = s.StateName;
        save("-v7", "loose.mat", "A", "B", "C", "D", "Ts", "InputName", "OutputName", "StateName");
        save("-v6", "struct.mat", "s");
    """
    run = subprocess.run(
        ["octave-cli", "--no-gui", "--eval", script], cwd=tmp_path, capture_output=True, check=False
    )
    assert run.returncode == 0, run.stderr
    for name in ("loose.mat", "struct.mat"):
        read = tv.linear.read_system(tmp_path / name)
        _same_bits(read, loop)
        assert (0.0 if read.period is None else read.period) == loop.dt
