"""Machines from controls, and machines as they were built."""

import pickle

import numpy as np
import pytest

import trunnion

JERK = {"linear.jerk": 40000, "rotary.jerk": 6000}


def turned(point, pivot, direction, angle):
    """Turns a point about a line (Rodrigues)."""
    k, v = np.asarray(direction, dtype=float), np.asarray(point) - pivot
    return pivot + v * np.cos(angle) + np.cross(k, v) * np.sin(angle) + k * (k @ v) * (1 - np.cos(angle))


def test_the_parameters_of_a_control_become_a_machine(root, tmp_path):
    file = root / "fixtures" / "machine-descriptions" / "fanuc-table.prm"
    found = trunnion.import_machine(file, given=JERK)
    assert found.format == "fanuc" and found.values and all(one["became"] for one in found.values)
    machine = found.machine.with_setup(tool_length=137.5)
    # 19680 = 12: both rotaries turn the table, and count left-handed as it turns.
    a, b = np.array([10.0, 20, -300]), np.array([10.25, 19.5, -330.5])
    q = np.random.default_rng(2).uniform(-1, 1, (20, 5)) * [200, 200, 200, 1, 1]
    first, second = machine.axes.index("B"), machine.axes.index("C")
    for row, tip in zip(q, machine.forward(q)[0]):
        place = turned(row[:3] - [0, 0, 137.5], a, [0, 1, 0], row[first])
        np.testing.assert_allclose(tip, turned(place, b, [0, 0, 1], row[second]), atol=1e-9)
    same = trunnion.Machine.from_control(file.read_bytes(), "fanuc", given=JERK)
    np.testing.assert_allclose(same.forward(q)[0], found.machine.forward(q)[0], atol=1e-12)
    found.save(tmp_path / "own.toml")
    np.testing.assert_allclose(trunnion.Machine(tmp_path / "own.toml").travel(), found.machine.travel())
    assert "fanuc" in repr(found) and "<svg" in found._repr_html_() and len(found.to_pandas()) == len(found.values)
    assert "became" in str(found) and found.to_dict()["open"] == found.open


def test_what_a_control_does_not_state_is_asked_for(root):
    file = root / "fixtures" / "machine-descriptions" / "fanuc-table.prm"
    with pytest.raises(trunnion.InputError, match="jerk") as found:
        trunnion.import_machine(file)
    assert "linear.jerk" in str(found.value) and "--" not in str(found.value)
    with pytest.raises(trunnion.InputError, match="format"):
        trunnion.import_machine(b"nothing of the kind")
    with pytest.raises(trunnion.ArgumentError) as found:
        trunnion.import_machine(file, given=[1])
    assert found.value.argument == "given"


def test_a_machine_that_no_file_has_is_checked_and_posted(root):
    machine = trunnion.Machine.from_control(root / "fixtures" / "machine-descriptions" / "fanuc-table.prm", given=JERK)
    machine = machine.with_setup(origin=(0, 0, -300), tool_length=120)
    program = b"G21 G90 G94\nT1 M6\nM3 S1000\nG43 H1\nG0 X0 Y0 Z50 B0 C0\nG1 X20 B10 F600\nM2\n"
    read = trunnion.read(program, machine=machine)
    np.testing.assert_allclose(machine.forward(read.q)[0], read.tip, atol=1e-9)
    assert trunnion.check(program, machine=machine).summary["duration"] > 0
    assert trunnion.post(program, machine, dialect="g93").text


#: What is off on the machine as it was built [mm].
OFF = {"C": (0.08, -0.05, 0.0), "B": (-0.04, 0.0, 0.11)}


def built():
    """The machine as it was built: places of the rotaries a little off."""
    data = trunnion._trunnion.toml_data(trunnion.Machine("bc-trunnion").to_toml())
    for name, off in OFF.items():
        axis = data["axis"][name]
        axis["point"] = [value + by for value, by in zip(axis["point"], off)]
    return trunnion.Machine(data)


def readings(real, length, sphere, noise):
    """Axis positions at which a probe of that length finds a sphere on the table."""
    real = real.with_setup(tool_length=length)
    turns = np.stack([0.31 * np.arange(20), np.tile([0.0, 0.5, -0.4, 0.9], 5)], axis=1)
    rows = []
    for turn in turns:
        q = np.concatenate([np.zeros((4, 3)), np.tile(turn, (4, 1))], axis=1)
        q[1:, :3] = np.eye(3)
        tip = real.forward(q)[0]
        rows.append([*np.linalg.solve((tip[1:] - tip[0]).T, sphere - tip[0]), *np.degrees(turn)])
    rows = np.array(rows)
    rows[:, :3] += noise * np.random.default_rng(4).standard_normal((len(rows), 3))
    names = ["X_mm", "Y_mm", "Z_mm", "C_deg", "B_deg"]
    return {**dict(zip(names, rows.T)), "length_mm": np.full(len(rows), length)}


def test_a_machine_is_calibrated_by_spheres(tmp_path):
    pandas = pytest.importorskip("pandas")
    machine, real = trunnion.Machine("bc-trunnion", origin=(-381, -254, -505), tool_length=120), built()
    sphere = np.array([-221.0, -254.0, -370.0])
    tables = [readings(real, length, sphere, 5e-4) for length in (150.0, 90.0)]
    found = machine.calibrate(tables)
    assert found.complete and found.rms_before > 0.02 and found.rms < 2e-3
    # Tips at many positions, as the machine that was built has them: the frame is that of the machine file.
    q = np.random.default_rng(5).uniform(-1, 1, (50, 5)) * [100, 100, 100, 3, 0.5] + [-381, -254, -300, 0, 0.3]
    off = [one.with_setup(origin=(0, 0, 0), tool_length=120).forward(q)[0] for one in (real, found.machine, machine)]
    shift = (off[1] - off[0]).mean(axis=0)
    assert np.linalg.norm(off[1] - off[0] - shift, axis=1).max() < 0.01 < np.linalg.norm(off[2] - off[0], axis=1).max()
    np.testing.assert_array_equal(found.machine.origin, machine.origin)
    assert found.value.shape == found.uncertainty.shape == (len(found.name),) and found.to_pandas().shape[1] == 5
    assert "calibrat" in repr(found).lower() and "error" in str(found) and "<table" in found._repr_html_()
    pandas.DataFrame(tables[0]).to_csv(tmp_path / "a.csv", index=False)
    files = machine.calibrate([tmp_path / "a.csv", pandas.DataFrame(tables[1])], noise=5e-4)
    np.testing.assert_allclose(files.value, found.value, atol=1e-9)
    found.save(tmp_path / "calibrated.toml")
    again = trunnion.Machine(tmp_path / "calibrated.toml")
    np.testing.assert_allclose(again.forward(q)[0], found.machine.with_setup(origin=(0, 0, 0), tool_length=0).forward(q)[0])
    assert pickle.loads(pickle.dumps(found.machine)).to_toml() == found.text


def test_readings_that_leave_something_open_say_so():
    table = readings(built(), 120.0, np.array([-221.0, -254.0, -370.0]), 0.0)
    found = trunnion.Machine("bc-trunnion").calibrate(table)
    assert not found.complete and found.confounded and found.further[0]["words"]
    assert np.isnan(found.uncertainty).any()


def test_faults_of_readings_have_lines():
    machine = trunnion.Machine("bc-trunnion")
    with pytest.raises(trunnion.InputError, match="measurements1.csv"):
        machine.calibrate({"X_mm": [0.0, 1.0]})
    with pytest.raises(trunnion.InputError) as found:
        machine.calibrate(b"X_mm,Y_mm,Z_mm,C_deg,B_deg\n0,0,0,0,0\n0,0,zero,0,0\n")
    assert found.value.line == 3 and found.value.file == "measurements1.csv"
    for wrong in ({"X_mm": ["a"]}, {"X_mm": [[1.0]]}, {"X_mm": [1.0], "Y_mm": [1.0, 2.0]}, None):
        with pytest.raises(trunnion.ArgumentError) as found:
            machine.calibrate(wrong)
        assert found.value.argument == "measurements"
