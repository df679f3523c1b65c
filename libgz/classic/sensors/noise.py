"""Noise of measurements: one model for each value that a sensor measures."""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable
from enum import IntEnum
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError
from libgz.classic.names import takes_names
from libgz.classic.sensors.read import choice, number
from libgz.physics.check import finite
from libgz.sdf.element import Element
from libgz.simulation.event import Callback

__all__ = ["GaussianNoiseModel", "Noise", "NoiseFactory", "SensorNoiseType", "new_noise"]


class SensorNoiseType(IntEnum):
    """The values of sensors that can have noise."""

    NO_NOISE = 0
    CAMERA_NOISE = 1
    GPU_RAY_NOISE = 2
    GPS_POSITION_LATITUDE_NOISE_METERS = 3
    GPS_POSITION_LONGITUDE_NOISE_METERS = 4
    GPS_POSITION_ALTITUDE_NOISE_METERS = 5
    GPS_VELOCITY_LATITUDE_NOISE_METERS = 6
    GPS_VELOCITY_LONGITUDE_NOISE_METERS = 7
    GPS_VELOCITY_ALTITUDE_NOISE_METERS = 8
    RAY_NOISE = 9
    MAGNETOMETER_X_NOISE_TESLA = 10
    MAGNETOMETER_Y_NOISE_TESLA = 11
    MAGNETOMETER_Z_NOISE_TESLA = 12
    ALTIMETER_POSITION_NOISE_METERS = 13
    ALTIMETER_VELOCITY_NOISE_METERS_PER_S = 14
    IMU_ANGVEL_X_NOISE_RADIANS_PER_S = 15
    IMU_ANGVEL_Y_NOISE_RADIANS_PER_S = 16
    IMU_ANGVEL_Z_NOISE_RADIANS_PER_S = 17
    IMU_LINACC_X_NOISE_METERS_PER_S_SQR = 18
    IMU_LINACC_Y_NOISE_METERS_PER_S_SQR = 19
    IMU_LINACC_Z_NOISE_METERS_PER_S_SQR = 20


class NoiseType(IntEnum):
    """Kinds of noise."""

    NONE = 0
    CUSTOM = 1
    GAUSSIAN = 2
    GAUSSIAN_QUANTIZED = 3


class Noise:
    """A model of noise; without a callback this one adds none."""

    STATE: ClassVar[tuple[str, ...]] = ()

    NONE, CUSTOM, GAUSSIAN, GAUSSIAN_QUANTIZED = NoiseType

    def __init__(self, kind: NoiseType = NoiseType.NONE) -> None:
        self._kind = kind
        self._custom: Callback | None = None

    def GetNoiseType(self) -> NoiseType:
        """NONE, CUSTOM, GAUSSIAN or GAUSSIAN_QUANTIZED."""
        return self._kind

    def SetCustomNoiseCallback(self, callback: Callable[[float], float]) -> None:
        """Let a function make the noise: it takes the value and returns the noisy one.

        Raises:
            ParameterError: it cannot be called.
        """
        self._custom, self._kind = Callback("the noise callback", callback, float), NoiseType.CUSTOM

    def Apply(self, value: float, dt: float = 0.0) -> float:
        """A value with noise, `dt` seconds of sim time after the last one; no model here depends on that."""
        return self._custom(value, otherwise=value) if self._custom is not None else self._one(value)

    def apply_all(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values with noise, each with its own."""
        if self._custom is not None:
            return np.array([self.Apply(value) for value in values.ravel().tolist()]).reshape(values.shape)
        return self._many(values)

    def _one(self, value: float) -> float:
        return value

    def _many(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        return values

    def restart(self) -> None:
        """Start again, with the same random numbers."""

    def reseed(self, seed: int) -> None:
        """Start again, with the random numbers that a world of this seed has."""

    def Fini(self) -> None:
        """Release the callback."""
        self._custom = None


class GaussianNoiseModel(Noise):
    """Adds normally distributed numbers, and a bias that is sampled once.

    Args:
        mean, stddev: of the noise, in units of the value.
        bias_mean, bias_stddev: of the bias, whose sign is random.
        precision: values are rounded to multiples of it; 0 for no rounding.
        seed: of the random numbers.
    """

    STATE = ("_mean", "_stddev", "_bias", "_random")

    def __init__(
        self,
        mean: float,
        stddev: float,
        bias_mean: float = 0.0,
        bias_stddev: float = 0.0,
        precision: float = 0.0,
        seed: np.random.SeedSequence | None = None,
    ) -> None:
        super().__init__(NoiseType.GAUSSIAN_QUANTIZED if precision else NoiseType.GAUSSIAN)
        # Zero is added because numpy refuses a standard deviation of -0.
        self._mean, self._stddev = mean, stddev + 0.0
        self._bias_mean, self._bias_stddev = bias_mean, bias_stddev + 0.0
        self._precision = precision
        self._seed = seed if seed is not None else np.random.SeedSequence()
        self.restart()

    def restart(self) -> None:
        """Start again, with the same random numbers."""
        self._random = np.random.Generator(np.random.PCG64(self._seed))
        self.SampleBias()

    def reseed(self, seed: int) -> None:
        """Start again, with the random numbers that a world of this seed has."""
        self._seed = np.random.SeedSequence(seed, spawn_key=self._seed.spawn_key)
        self.restart()

    def SampleBias(self) -> None:
        """Sample the bias again."""
        bias = self._random.normal(self._bias_mean, self._bias_stddev)
        self._bias = float(bias if self._random.random() < 0.5 else -bias)

    def _one(self, value: float) -> float:
        noisy = value + self._bias + self._random.normal(self._mean, self._stddev)
        return round(noisy / self._precision) * self._precision if self._precision else float(noisy)

    def _many(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        noisy = values + self._bias + self._random.normal(self._mean, self._stddev, values.shape)
        return np.round(noisy / self._precision) * self._precision if self._precision else noisy

    def GetMean(self) -> float:
        """Mean of the noise."""
        return self._mean

    def GetStdDev(self) -> float:
        """Standard deviation of the noise."""
        return self._stddev

    def GetBias(self) -> float:
        """The sampled bias."""
        return self._bias

    def SetMean(self, mean: float) -> None:
        """Set the mean, and sample the bias again."""
        self._mean = finite(mean, "mean of the noise")
        self.SampleBias()

    def SetStdDev(self, stddev: float) -> None:
        """Set the standard deviation, and sample the bias again."""
        if not (stddev >= 0.0 and math.isfinite(stddev)):
            raise ParameterError(f"stddev is {stddev:g}; it must be at least 0")
        self._stddev = float(stddev)
        self.SampleBias()


KINDS = ("none", "gaussian", "gaussian_quantized", "custom")


def new_noise(element: Element, seed: int = 0, name: str = "", channel: int = 0) -> Noise:
    """The noise that a `<noise>` element describes; a custom one adds none until a plugin sets its callback.

    Args:
        element: with `type` as an attribute, or as a child in older places.
        seed: of the world.
        name, channel: of the sensor and of the measured value; each pair has its own random numbers.

    Raises:
        ParameterError: the kind is unknown, or a value is not allowed.
    """
    kind = choice(element, "type", KINDS, "none")
    if kind == "none":
        return Noise()
    if kind == "custom":
        return Noise(NoiseType.CUSTOM)
    stream = np.random.SeedSequence(entropy=seed, spawn_key=(zlib.crc32(name.encode()), channel))
    return GaussianNoiseModel(
        number(element, "mean"),
        number(element, "stddev", 0.0),
        number(element, "bias_mean"),
        number(element, "bias_stddev", 0.0),
        number(element, "precision", 0.0),
        stream,
    )


@takes_names
class NoiseFactory:
    """Makes noise from SDF."""

    @staticmethod
    def NewNoiseModel(sdf: Element, sensorType: str = "") -> Noise:
        """The noise that a `<noise>` element describes."""
        return new_noise(sdf, name=sensorType)
