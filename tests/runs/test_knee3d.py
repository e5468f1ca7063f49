"""The three-dimensional knee of docs/examples; needs MuJoCo, which ``.ci/run`` installs."""

import importlib
import shutil

import numpy as np
import pytest
from examples import EXAMPLES, differences, pictures, said
from matplotlib.image import imread

from kneecore import Model

pytest.importorskip("mujoco", reason="the extra `mujoco` is not installed")


@pytest.fixture(scope="module")
def model():
    made = Model.from_file(EXAMPLES / "knee3d" / "knee3d.toml").with_runs(workers=None)
    yield made
    made.close()


@pytest.fixture(scope="module")
def knee3d(model):
    return importlib.import_module("knee3d")  # the model's file has put its folder on the path


@pytest.fixture(scope="module")
def knees(model, knee3d):
    """Return points with their poses under each load: the nominal one, and others."""
    spread = np.random.default_rng(3).uniform(-1.0, 1.0, (3, 24))
    spread[0] = 0.0
    return [(x, knee3d.poses(x)) for x in model.nominal + spread]


def turned(abduction, rotation):
    """Return the matrix of a turn about x, then about the y that it has turned."""
    (ca, sa), (cr, sr) = ((np.cos(v), np.sin(v)) for v in (abduction, rotation))
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, ca, -sa], [0.0, sa, ca]])
    return about_x @ np.array([[cr, 0.0, sr], [0.0, 1.0, 0.0], [-sr, 0.0, cr]])


def residual(knee3d, x, joint, load, pose):
    """Return what is left of the forces (N) and moments (N m) on the tibia, apart from MuJoCo.

    All in the frame of the reference pose. The contacts' two forces, along the plateaus' normal,
    are the ones that leave least.
    """
    place, turn = pose[:3], turned(*pose[3:])
    back = knee3d.rotated(knee3d.FLEXION).T
    force, moment = np.zeros(3), np.zeros(3)
    if joint == "ap":
        force[0] = load
    else:
        moment = load * turn[:, 1]
    for name, (femur, tibia) in knee3d.attachments(x).items():
        rest, k = knee3d.springs(x)[name]
        arm = turn @ tibia
        along = back @ femur - place - arm
        length = np.linalg.norm(along)
        pull = k * max(length - rest, 0.0) ** 2 * along / length
        force, moment = force + pull, moment + np.cross(arm, pull)
    normal, columns = turn[:, 1], []
    for z, radius in knee3d.RADII.values():
        touched = back @ [0.0, 0.0, 1e-3 * z] - 1e-3 * radius * normal
        columns.append(np.concatenate([-normal, np.cross(touched - place, -normal)]))
    together = np.concatenate([force, moment])
    together[5] = 0.0  # about the flexion axis the rig holds the tibia
    columns = np.array(columns).T
    columns[5] = 0.0
    pressed = -np.linalg.lstsq(columns, together, rcond=None)[0]
    return together + columns @ pressed, pressed


def test_the_poses_are_in_equilibrium(knee3d, knees):
    for x, poses in knees:
        assert len(poses) == 10
        for (joint, load), pose in poses.items():
            left, pressed = residual(knee3d, x, joint, load, pose)
            assert np.abs(left[:3]).max() < 0.02
            assert np.abs(left[3:]).max() < 0.003
            assert (pressed > 0.0).all()  # bones press, and do not pull


def test_more_load_moves_further_and_the_signs_are_the_clinics(knee3d, model):
    y = model.evaluate([model.nominal])[0]
    assert (np.diff(y[:6]) > 0.0).all()
    assert (np.diff(y[6:]) > 0.0).all()
    # Turned inwards, the front of the tibia goes to the medial side, z < 0.
    assert (turned(0.0, 0.3) @ [1.0, 0.0, 0.0])[2] < 0.0


def test_an_unstable_simulation_is_a_failed_run(knee3d, model, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)  # MuJoCo leaves its log there
    monkeypatch.setattr(knee3d, "DRAWERS", (-100.0, -50.0, 50.0, 1e12))
    failing = model.with_runs(workers=None, timeout_s=None)
    y = failing.examine(model.nominal[None]).y
    assert np.isnan(y[0]).tolist() == [False] * 9 + [True]
    assert len(failing.failures) == 1


def test_a_knee_that_has_no_time_to_come_to_rest_has_no_pose(knee3d, model):
    compiled = knee3d.compiled(model.nominal)
    data = knee3d.mujoco.MjData(compiled)
    assert np.isnan(knee3d.settled(compiled, data, longest=50)).all()


def test_the_study_prints_what_the_page_says(tmp_path, run_study):
    folder = tmp_path / "knee3d"
    shutil.copytree(EXAMPLES / "knee3d", folder, ignore=shutil.ignore_patterns("*.png"))
    assert differences(said("knee3d"), run_study(folder), share=0.02) == []
    for picture in pictures("knee3d"):
        shown, drawn = (imread(root / picture).shape for root in (EXAMPLES, tmp_path))
        np.testing.assert_allclose(shown, drawn, atol=2)
