"""The Vulkan driver: scored pictures come from the software one, whatever the machine."""

import os
from pathlib import Path

from adc_bench.errors import MachineError

ICD_FOLDERS = (Path("/usr/share/vulkan/icd.d"), Path("/usr/local/share/vulkan/icd.d"), Path("/etc/vulkan/icd.d"))


def software_icd() -> Path:
    """Return the manifest of Mesa's software driver.

    Raises:
        MachineError: it is not installed.
    """
    found = sorted(path for folder in ICD_FOLDERS for path in folder.glob("lvp_icd*.json"))
    if not found:
        raise MachineError(
            where="the Vulkan driver",
            found=f"no lvp_icd*.json in {', '.join(map(str, ICD_FOLDERS))}",
            wanted="Mesa's software Vulkan driver (lavapipe) 24.3 or newer",
            todo="run `make setup`, or install mesa-vulkan-drivers and libvulkan1",
        )
    return found[0]


def choose_software_driver() -> None:
    """Point the Vulkan loader at the software driver; must run before the first import of sapien's renderer."""
    os.environ["VK_DRIVER_FILES"] = os.environ["VK_ICD_FILENAMES"] = str(software_icd())
