"""The sensors a robot carries, as data: where they sit, how often they speak, how late, and how wrong."""

import math

import msgspec
import numpy as np

from adc_bench.geometry import ROTATION_BODY_OPTICAL, Camera, Pose3, rotation_zyx


class Lens(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Radial distortion as OpenCV's k1 and k2; zeros are a pinhole.

    The defaults are a common wide lens', our own choice: lines at the border of the road camera's picture bend by
    several pixels. The published camera of the competition's robots (a PS3 Eye) has -0.276 and 0.045.
    """

    k1: float = -0.12
    k2: float = 0.015


PINHOLE = Lens(k1=0.0, k2=0.0)


class Imaging(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What lies between the light and the delivered picture. Every stage can be turned off.

    Attributes:
        shutter_max_s: the longest exposure time; light that it does not suffice for is made up by gain, which noise
            grows with. 0 turns motion blur off (the noise is that of 1/60 s).
        exposure_lag_s: time constant with which the auto-exposure follows the scene, in stops; 0: at once.
        vignetting: share of light lost in the picture's corners, growing with the square of the distance from its
            middle; 0: none.
        white_balance: how much of the lamps' colour the camera removes, in [0, 1].
        full_well_electrons: electrons at full scale at the lowest gain, which fixes the shot noise; 0: no noise at all.
        read_noise_electrons: standard deviation of the read noise; 0: none.
        jpeg_quality: of the delivered JPEG; None delivers a PNG.
    """

    shutter_max_s: float = 1 / 60
    exposure_lag_s: float = 0.4
    vignetting: float = 0.3
    white_balance: float = 0.7
    full_well_electrons: float = 9000.0
    read_noise_electrons: float = 6.0
    jpeg_quality: int | None = 92


IDEAL = Imaging(
    shutter_max_s=0.0,
    exposure_lag_s=0.0,
    vignetting=0.0,
    white_balance=0.0,
    full_well_electrons=0.0,
    read_noise_electrons=0.0,
    jpeg_quality=None,
)


class CameraMount(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A camera on the robot: where it sits, where it looks (pitch down positive), what it delivers and how often."""

    name: str
    x_m: float
    z_m: float
    pitch_down_rad: float
    hfov_rad: float
    width_px: int = 320
    height_px: int = 240
    period_steps: int = 1  # control steps between two pictures
    latency_s: float = 0.0  # from mid-exposure to delivery
    lens: Lens = Lens()
    imaging: Imaging = Imaging()

    def camera(self) -> Camera:
        """Return the intrinsics."""
        return Camera.from_hfov(
            width_px=self.width_px,
            height_px=self.height_px,
            hfov_rad=self.hfov_rad,
            k1=self.lens.k1,
            k2=self.lens.k2,
        )

    def resized(self, width_px: int, height_px: int) -> "CameraMount":
        """Return the same mount with another picture size."""
        return msgspec.structs.replace(self, width_px=width_px, height_px=height_px)

    def pose_robot_camera(self, pitch_error_rad: float = 0.0, roll_error_rad: float = 0.0) -> Pose3:
        """Return where the camera (x right, y down, z forward) is, seen from the robot."""
        body = rotation_zyx(0.0, self.pitch_down_rad + pitch_error_rad, roll_error_rad)
        return Pose3(rotation=body @ ROTATION_BODY_OPTICAL, translation_m=np.array([self.x_m, 0.0, self.z_m]))


class EncoderSpec(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Two incremental encoders; their ticks a turn are the robot's."""

    rate_hz: int = 50
    latency_s: float = 0.0


class ImuSpec(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A gyro about z and an accelerometer along x; their errors beside the gyro bias drawn with the robot.

    The figures are those of a common MEMS unit, its band limited to half the sampling rate; our own choice.
    """

    rate_hz: int = 100
    latency_s: float = 0.0
    gyro_noise_radps: float = math.radians(0.1)  # sd of one sample
    gyro_walk_radps_sqrts: float = math.radians(0.005)  # sd of the bias' change over one second
    acceleration_noise_mps2: float = 0.05  # sd of one sample
    acceleration_bias_mps2: float = 0.05  # sd over robots


class LaserSpec(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A level laser range finder of the Hokuyo kind: beams evenly spread about straight ahead, from right to left.

    A beam that meets nothing between the range's ends reads `range_max_m`. The noise is the data sheet's of a
    URG-04LX: 10 mm up to 1 m, 1 % of the range beyond.
    """

    x_m: float = 0.16
    z_m: float = 0.12
    field_rad: float = math.radians(270)
    step_rad: float = math.radians(0.8)
    range_min_m: float = 0.06
    range_max_m: float = 3.0
    rate_hz: int = 10
    latency_s: float = 0.0
    noise_near_m: float = 0.010
    noise_share: float = 0.010

    @property
    def beams(self) -> int:
        """How many beams a scan has."""
        return math.floor(self.field_rad / self.step_rad + 1e-9) + 1


class SemanticCameraSpec(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Says which objects a camera of the rig has in view, and where they are; for teams that skip perception."""

    camera: str = "road"
    range_max_m: float = 5.0


class SensorRig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The sensors a submission drives with. No ranked suite has a semantic camera."""

    cameras: tuple[CameraMount, ...] = (
        CameraMount(
            name="road",
            x_m=0.10,
            z_m=0.70,
            pitch_down_rad=math.radians(28),
            hfov_rad=math.radians(70),
            period_steps=1,
        ),
        CameraMount(
            name="panel",
            x_m=-0.05,
            z_m=0.78,
            pitch_down_rad=math.radians(-16),
            hfov_rad=math.radians(90),
            period_steps=4,
        ),
    )
    encoders: EncoderSpec = EncoderSpec()
    imu: ImuSpec = ImuSpec()
    laser: LaserSpec | None = LaserSpec()
    semantic: SemanticCameraSpec | None = None

    def camera(self, name: str) -> CameraMount:
        """Return the mount of this name."""
        return next(mount for mount in self.cameras if mount.name == name)
