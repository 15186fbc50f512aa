"""Whether this machine draws: one picture of an empty scene on the software driver, told in one line of JSON.

`python -m adc_bench.render.probe`, so that a driver that takes its process down takes nothing else with it.
"""

import json
import sys
import time

from adc_bench.errors import MachineError
from adc_bench.render.driver import choose_software_driver


def main() -> None:
    """Draw; exit with 0, or with 4 and the reason on stderr."""
    started = time.perf_counter()
    try:
        choose_software_driver()
        device = _draw()
    except MachineError as error:
        sys.stderr.write(f"{error.found}\n")
        sys.exit(error.exit_code)
    except RuntimeError as error:  # what SAPIEN raises where Vulkan fails
        sys.stderr.write(f"{error}\n")
        sys.exit(MachineError.exit_code)
    sys.stdout.write(json.dumps({"device": device, "first_picture_s": round(time.perf_counter() - started, 2)}) + "\n")


def _draw() -> str:
    import sapien

    sapien.render.set_camera_shader_dir("trivial")
    system = sapien.render.RenderSystem()
    scene = sapien.Scene([system])
    camera = scene.add_camera("probe", 64, 48, 1.0, 0.05, 10.0)
    scene.update_render()
    camera.take_picture()
    assert camera.get_picture("Color").shape == (48, 64, 4)
    return str(system.device.name)


if __name__ == "__main__":
    main()
