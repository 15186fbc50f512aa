from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from adc_bench.dataset.shard import Shard
from adc_bench.dataset.store import Store
from adc_bench.dataset.tally import Tally
from adc_bench.dataset.tum import drive_text, pose_figures
from adc_bench.errors import InputError
from adc_bench.geometry import Pose3


def test_pose_figures_are_those_of_each_pose() -> None:
    rng = np.random.default_rng(0)
    matrices = np.tile(np.eye(4), (20, 1, 1))
    matrices[:, :3, :3] = Rotation.random(20, rng=rng).as_matrix()
    matrices[:, :3, 3] = rng.normal(size=(20, 3))
    for figures, matrix in zip(pose_figures(matrices), matrices, strict=True):
        pose = Pose3(rotation=matrix[:3, :3].copy(), translation_m=matrix[:3, 3].copy())
        np.testing.assert_allclose(figures, pose.figures(), atol=1e-12)
        np.testing.assert_allclose(Pose3.from_figures(figures).matrix(), matrix, atol=1e-12)
    assert pose_figures(np.zeros((0, 4, 4))).shape == (0, 7)


def test_a_drives_file_has_a_line_a_time_stamp(tmp_path: Path) -> None:
    time_s = np.arange(5) * 0.02
    poses = np.tile([1.0, -2.0, 0.5, 0.0, 0.0, 0.6, 0.8], (5, 1))
    (tmp_path / "a.tum").write_text(drive_text(time_s, poses))
    lines = (tmp_path / "a.tum").read_text().splitlines()
    assert lines[0].startswith("# time_s tx_m") and lines[2].startswith("0.020000 1.000000000 -2.000000000 0.5")
    np.testing.assert_allclose(np.loadtxt(tmp_path / "a.tum"), np.column_stack([time_s, poses]), atol=1e-9)


def test_a_drive_is_counted_by_its_truth(folder: Path) -> None:
    shard = Shard(Store(folder), "shard-00001.h5", 6)
    with pytest.raises(InputError, match="not a readable shard"):
        shard.truth()
    with h5py.File(folder / "shard-00001.h5", "a") as file:
        file["truth/time_s"] = np.array([0.0, 0.5, 1.25])
        file["truth/pose_world_robot"] = np.array([[0.0] * 7, [3.0, 4.0, 9.0, 0, 0, 0, 1], [3.0, 5.0, 0, 0, 0, 0, 1]])
    tally = Tally()
    tally.add_drive(shard)
    tally.add_drive(shard)
    driving = tally.summary("drives", 7).driving
    assert driving is not None
    assert (driving.drives, driving.simulated_s, driving.distance_m) == (2, 2.5, 12.0)
