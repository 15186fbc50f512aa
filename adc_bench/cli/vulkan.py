"""What the Vulkan loader offers on this machine, asked through ctypes, so that nothing else need be installed."""

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager

import msgspec

_DRIVER_PROPERTIES, _PROPERTIES_2 = 1000196000, 1000059001
_API_1_1 = 1 << 22 | 1 << 12
_TYPES = ("other", "integrated GPU", "discrete GPU", "virtual GPU", "software")


class VulkanDevice(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A Vulkan device: its name, type and driver."""

    name: str
    type: str
    driver: str


class _InstanceInfo(ctypes.Structure):
    _fields_ = (
        ("sType", ctypes.c_int),
        ("pNext", ctypes.c_void_p),
        ("flags", ctypes.c_uint32),
        ("pApplicationInfo", ctypes.c_void_p),
        ("layerCount", ctypes.c_uint32),
        ("layers", ctypes.c_void_p),
        ("extensionCount", ctypes.c_uint32),
        ("extensions", ctypes.c_void_p),
    )


class _ApplicationInfo(ctypes.Structure):
    _fields_ = (
        ("sType", ctypes.c_int),
        ("pNext", ctypes.c_void_p),
        ("name", ctypes.c_char_p),
        ("version", ctypes.c_uint32),
        ("engine", ctypes.c_char_p),
        ("engineVersion", ctypes.c_uint32),
        ("apiVersion", ctypes.c_uint32),
    )


class _DriverProperties(ctypes.Structure):
    _fields_ = (
        ("sType", ctypes.c_int),
        ("pNext", ctypes.c_void_p),
        ("driverID", ctypes.c_int),
        ("driverName", ctypes.c_char * 256),
        ("driverInfo", ctypes.c_char * 256),
        ("conformance", ctypes.c_uint8 * 4),
    )


class _Properties2(ctypes.Structure):
    _fields_ = (
        ("sType", ctypes.c_int),
        ("pNext", ctypes.c_void_p),
        ("apiVersion", ctypes.c_uint32),
        ("driverVersion", ctypes.c_uint32),
        ("vendorID", ctypes.c_uint32),
        ("deviceID", ctypes.c_uint32),
        ("deviceType", ctypes.c_uint32),
        ("deviceName", ctypes.c_char * 256),
        ("rest", ctypes.c_uint64 * 128),  # limits and the like, larger than any loader fills
    )


def vulkan_devices() -> tuple[VulkanDevice, ...] | None:
    """Return the devices that the Vulkan loader lists; None if there is no loader (libvulkan.so.1)."""
    try:
        vulkan = ctypes.CDLL("libvulkan.so.1")
    except OSError:
        return None
    with _instance(vulkan) as instance:
        count = ctypes.c_uint32()
        if instance is None or vulkan.vkEnumeratePhysicalDevices(instance, ctypes.byref(count), None):
            return ()
        handles = (ctypes.c_void_p * count.value)()
        vulkan.vkEnumeratePhysicalDevices(instance, ctypes.byref(count), handles)
        return tuple(_describe(vulkan, ctypes.c_void_p(handle)) for handle in handles[: count.value])


@contextmanager
def _instance(vulkan: ctypes.CDLL) -> Iterator[ctypes.c_void_p | None]:
    application = _ApplicationInfo(sType=0, apiVersion=_API_1_1)
    info = _InstanceInfo(sType=1, pApplicationInfo=ctypes.addressof(application))
    instance = ctypes.c_void_p()
    if vulkan.vkCreateInstance(ctypes.byref(info), None, ctypes.byref(instance)):
        yield None
        return
    try:
        yield instance
    finally:
        vulkan.vkDestroyInstance(instance, None)


def _describe(vulkan: ctypes.CDLL, device: ctypes.c_void_p) -> VulkanDevice:
    driver = _DriverProperties(sType=_DRIVER_PROPERTIES)
    properties = _Properties2(sType=_PROPERTIES_2, pNext=ctypes.addressof(driver))
    vulkan.vkGetPhysicalDeviceProperties2(device, ctypes.byref(properties))
    return VulkanDevice(
        name=properties.deviceName.decode(),
        type=_TYPES[min(properties.deviceType, 4)],
        driver=f"{driver.driverName.decode()} {driver.driverInfo.decode()}".strip(),
    )
