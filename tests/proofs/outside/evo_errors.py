"""Print evo's errors of pairs of trajectories: `evo_errors.py PAIRS.npy STEPS`, pairs (k, 2, n, 3) of x, y, yaw."""

import copy
import json
import sys

import numpy as np
from evo.core.metrics import APE, RPE, PoseRelation, StatisticsType, Unit
from evo.core.trajectory import PosePath3D


def path_of(poses):
    matrices = np.tile(np.eye(4), (len(poses), 1, 1))
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 0], matrices[:, 1, 1] = cos, -sin, sin, cos
    matrices[:, :2, 3] = poses[:, :2]
    return PosePath3D(poses_se3=list(matrices))


def rmse(metric, truth, estimate):
    metric.process_data((truth, estimate))
    return float(metric.get_statistic(StatisticsType.rmse))


def errors(truth, estimate, steps):
    laid_on = copy.deepcopy(estimate)
    laid_on.align(truth)
    place, angle = PoseRelation.translation_part, PoseRelation.rotation_angle_rad
    return {
        "ape": rmse(APE(place), truth, estimate),
        "aligned_ape": rmse(APE(place), truth, laid_on),
        "rpe_m": rmse(RPE(place, delta=steps, delta_unit=Unit.frames, all_pairs=True), truth, estimate),
        "rpe_rad": rmse(RPE(angle, delta=steps, delta_unit=Unit.frames, all_pairs=True), truth, estimate),
    }


pairs, steps = np.load(sys.argv[1]), int(sys.argv[2])
print(json.dumps([errors(path_of(truth), path_of(estimate), steps) for truth, estimate in pairs]))
