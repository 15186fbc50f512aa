"""Run filterpy's extended Kalman filter over recorded steps: `filterpy_steps.py STEPS.npz OUT.npz`.

A step is a travel (columns duration, forward, turn) and a point landmark seen, as in thesis.md. The motion is written
out here once more; its Jacobian is taken by complex steps, which are exact to the last digit.
"""

import sys

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter


def motion(state, way):
    x, y, yaw, bias, scale = state[:5]
    for duration, forward, turn in way:
        turned = turn - bias * duration
        x = x + (1 + scale) * forward * np.cos(yaw + turned / 2)
        y = y + (1 + scale) * forward * np.sin(yaw + turned / 2)
        yaw = yaw + turned
    return np.array([x, y, yaw, bias, scale, *state[5:]])


def seen(state, landmark):
    dx, dy, c, s = landmark[0] - state[0], landmark[1] - state[1], np.cos(state[2]), np.sin(state[2])
    return np.array([c * dx + s * dy, -s * dx + c * dy])


def derivative(function, state):
    step = 1e-30
    return np.stack([function(state + 1j * step * unit).imag / step for unit in np.eye(len(state))], axis=1)


class Filter(ExtendedKalmanFilter):
    def predict_x(self, u=0):
        self.F = derivative(lambda state: motion(state, u), self.x)
        self.x = motion(self.x, u)


steps = np.load(sys.argv[1])
size = len(steps["mean"])
ekf = Filter(dim_x=size, dim_z=2)
ekf.x, ekf.P, ekf.R = steps["mean"].copy(), steps["covariance"].copy(), steps["R"]
means, covariances = [], []
for way, Q, landmark, z in zip(steps["ways"], steps["Q"], steps["landmarks"], steps["seen"], strict=True):
    ekf.Q = Q
    ekf.predict_x(way)
    ekf.P = ekf.F @ ekf.P @ ekf.F.T + ekf.Q
    ekf.update(z, lambda x, m: derivative(lambda state: seen(state, m), x), seen, args=(landmark,), hx_args=(landmark,))
    means.append(ekf.x.copy())
    covariances.append(ekf.P.copy())
np.savez(sys.argv[2], means=means, covariances=covariances)
